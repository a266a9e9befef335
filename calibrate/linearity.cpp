// SPDX-License-Identifier: Apache-2.0
// Gauss-Newton on ln(panel / card) = ln(ratio of the frame), each signal s put right as s + c s^2.
#include "calibrate/linearity.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "calibrate/statistics.h"
#include "common/core/parallel.h"

namespace dermap {
namespace {

constexpr int kCardMargin_px = 16;        // cards are larger than the region in which they are read
constexpr double kFaintest_dn = 20.0;     // mean of the card, below which a kind is not used
constexpr double kSaturatedKind = 0.005;  // share of a kind's photosites
constexpr double kOutlier = 0.2;          // of the mean, and its inverse: dead photosites, specks
constexpr int kFewestCells = 64;
constexpr double kMostPhotosites = 4e5;  // of a frame, about
constexpr int kRounds = 4;
constexpr double kUseful = 0.02;  // one standard deviation beyond which nothing is told

constexpr double kUsual = 0.01;        // of a sensor, one standard deviation: what is expected before looking
constexpr double kDisagreement = 4.0;  // standard deviations
constexpr double kWorthAWord = 0.002;  // of what the rig states and the frames say

struct KindSums {
  double sum = 0.0, square = 0.0;
  int count = 0;
  double mean() const { return count > 0 ? sum / count : 0.0; }
};
using Kinds = std::array<KindSums, kLatticeCount>;

enum class Place { kNeither, kPanel, kCard };

Place PlaceOf(int x, int y, const PixelRegion& card) {
  const auto within = [&](int margin) {
    return x >= card.x - margin && y >= card.y - margin && x + 1 < card.x + card.width + margin &&
           y + 1 < card.y + card.height + margin;
  };
  if (within(0)) return Place::kCard;
  return within(kCardMargin_px) ? Place::kNeither : Place::kPanel;
}

// Photosites from one cell that is used to the next: enough cells tell, whatever the frame's size.
int StrideOf(const SignalFrame& frame) {
  return 2 *
         std::max(1, static_cast<int>(std::sqrt(static_cast<double>(frame.signal.size()) / kMostPhotosites)));
}

// Calls body(place, x, y) for the upper left photosite of the cells.
template <class Body>
void ForEachCell(const SignalFrame& frame, const PixelRegion& card, const Body& body) {
  const int stride = StrideOf(frame);
  for (int y = 0; y + 1 < frame.signal.height(); y += stride) {
    for (int x = 0; x + 1 < frame.signal.width(); x += stride) {
      const Place place = PlaceOf(x, y, card);
      if (place != Place::kNeither) body(place == Place::kCard ? 1 : 0, x, y);
    }
  }
}

// How light rises over a cell: a kind sees it half a photosite off the cell's middle.
struct Slope {
  double x = 0.0, y = 0.0, level = 0.0;
  void Add(const PlaneF& signal, int px, int py) {
    if (px + 3 >= signal.width() || py + 3 >= signal.height()) return;
    for (int i = 0; i < kLatticeCount; ++i) {
      const int cx = px + (i & 1), cy = py + (i >> 1);
      const double here = signal(cx, cy);
      x += 0.5 * (signal(cx + 2, cy) - here);
      y += 0.5 * (signal(cx, cy + 2) - here);
      level += here;
    }
  }
  double At(int kind) const {
    return level > 0.0 ? (((kind & 1) - 0.5) * x + ((kind >> 1) - 0.5) * y) / level : 0.0;
  }
};

struct Rough {
  std::array<std::array<double, kLatticeCount>, 2> mean{};  // panel, card
  std::array<bool, kLatticeCount> usable{};
};

Rough RoughMeans(const SignalFrame& frame, const PixelRegion& card) {
  std::array<Kinds, 2> sums;
  std::array<int, kLatticeCount> saturated{}, all{};
  ForEachCell(frame, card, [&](int place, int x, int y) {
    for (int i = 0; i < kLatticeCount; ++i) {
      const int px = x + (i & 1), py = y + (i >> 1);
      ++all[i];
      if ((frame.mask(px, py) & kPhotositeSaturated) != 0) ++saturated[i];
      if (frame.mask(px, py) != 0) continue;
      sums[place][i].sum += frame.signal(px, py);
      ++sums[place][i].count;
    }
  });
  Rough rough;
  for (int i = 0; i < kLatticeCount; ++i) {
    rough.mean[0][i] = sums[0][i].mean();
    rough.mean[1][i] = sums[1][i].mean();
    rough.usable[i] = saturated[i] <= kSaturatedKind * all[i] && rough.mean[1][i] >= kFaintest_dn &&
                      rough.mean[0][i] > rough.mean[1][i];
  }
  return rough;
}

// Shot noise of a kind on the card, DN^2: differences of neighbours of one kind.
double CardVariance(const SignalFrame& frame, const PixelRegion& card, int kind) {
  std::vector<float> differences;
  const int stride = StrideOf(frame);
  for (int y = card.y + (kind >> 1); y < card.y + card.height; y += stride) {
    for (int x = card.x + (kind & 1); x + 2 < card.x + card.width; x += stride) {
      if (frame.mask(x, y) == 0 && frame.mask(x + 2, y) == 0)
        differences.push_back((frame.signal(x, y) - frame.signal(x + 2, y)) / std::sqrt(2.0f));
    }
  }
  return differences.empty() ? 0.0 : ClippedVariance(differences);
}

struct Line {
  double slope = 0.0, sigma = 0.0, chi2 = 0.0;
  int degrees = 0;
};

// y = own constant of each frame + slope x.
Line CommonSlope(const std::vector<LinearityPoint>& points, const std::vector<double>& x,
                 const std::vector<double>& y) {
  double xx = 0, xy = 0, yy = 0;
  int frames = 0;
  for (std::size_t first = 0; first < points.size(); ++frames) {
    std::size_t last = first;
    double n = 0, sx = 0, sy = 0;
    for (; last < points.size() && points[last].frame == points[first].frame; ++last) {
      const double w = 1.0 / points[last].variance;
      n += w, sx += w * x[last], sy += w * y[last];
    }
    for (; first < last; ++first) {
      const double w = 1.0 / points[first].variance;
      const double dx = x[first] - sx / n, dy = y[first] - sy / n;
      xx += w * dx * dx, xy += w * dx * dy, yy += w * dy * dy;
    }
  }
  Line line;
  line.degrees = static_cast<int>(points.size()) - frames - 1;
  if (!(xx > 0.0) || line.degrees < 1) return line;
  line.slope = xy / xx;
  line.chi2 = std::max(0.0, yy - xy * xy / xx) / line.degrees;
  line.sigma = std::sqrt(std::max(1.0, line.chi2) / xx);
  return line;
}

}  // namespace

std::vector<LinearityPoint> LinearityPointsOf(const SignalFrame& spectralon, const PixelRegion& card,
                                              int frame) {
  std::vector<LinearityPoint> points;
  if (spectralon.period != 2) return points;
  const Rough rough = RoughMeans(spectralon, card);
  std::array<Kinds, 2> sums;
  std::array<Slope, 2> slopes;
  const auto usable = [&](int place, int x, int y) {
    // A cell counts for all kinds or for none: uneven light must not differ between them.
    for (int i = 0; i < kLatticeCount; ++i) {
      if (!rough.usable[i]) continue;
      const int px = x + (i & 1), py = y + (i >> 1);
      const double relative = spectralon.signal(px, py) / rough.mean[place][i];
      if (spectralon.mask(px, py) != 0 || relative < kOutlier || relative > 1.0 / kOutlier) return false;
    }
    return true;
  };
  ForEachCell(spectralon, card, [&](int place, int x, int y) {
    if (!usable(place, x, y)) return;
    for (int i = 0; i < kLatticeCount; ++i) {
      const double s = spectralon.signal(x + (i & 1), y + (i >> 1));
      sums[place][i].sum += s;
      sums[place][i].square += s * s;
      ++sums[place][i].count;
    }
    slopes[place].Add(spectralon.signal, x, y);
  });
  for (int i = 0; i < kLatticeCount; ++i) {
    const KindSums &panel = sums[0][i], &gray = sums[1][i];
    if (!rough.usable[i] || std::min(panel.count, gray.count) < kFewestCells) continue;
    const double panel_here = 1.0 + slopes[0].At(i), card_here = 1.0 + slopes[1].At(i);
    const double noise = CardVariance(spectralon, card, i);
    const double of_card = noise / gray.count / (gray.mean() * gray.mean());
    const double of_panel = noise / gray.mean() / panel.count / panel.mean();  // shot noise grows with signal
    const double of_black = kBlackDrift_dn * (1.0 / gray.mean() - 1.0 / panel.mean());
    points.push_back({frame, panel.mean() / panel_here,
                      panel.square / panel.count / (panel_here * panel_here), gray.mean() / card_here,
                      gray.square / gray.count / (card_here * card_here),
                      of_card + of_panel + of_black * of_black});
  }
  if (points.size() < 2) points.clear();
  return points;
}

std::optional<LinearityEstimate> FitNonlinearity(const std::vector<LinearityPoint>& points,
                                                 double full_scale) {
  LinearityEstimate estimate;
  estimate.points = static_cast<int>(points.size());
  double c = 0.0;  // 1 / DN
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> x, y;
    for (const LinearityPoint& p : points) {
      const double panel = p.panel + c * p.panel_square, card = p.card + c * p.card_square;
      y.push_back(std::log(panel / card));
      x.push_back(p.card_square / card - p.panel_square / panel);
    }
    const Line line = CommonSlope(points, x, y);
    if (line.degrees < 1 || !(line.sigma > 0.0)) return std::nullopt;
    c += line.slope;
    estimate.nonlinearity = {c * full_scale, line.sigma * full_scale};
    estimate.chi2 = line.chi2;
  }
  if (!(estimate.nonlinearity.sigma < kUseful) || !std::isfinite(estimate.nonlinearity.value))
    return std::nullopt;
  return estimate;
}

Linearity FindLinearity(const Session& session, const FrameReader& read, const BlackFrames& blacks,
                        const PixelRegion& card) {
  std::vector<const FrameRecord*> firsts;
  std::set<double> seen;
  for (const FrameRecord& record : session.frames) {
    if (record.role == FrameRole::kSpectralon && seen.insert(record.wavelength_nm).second)
      firsts.push_back(&record);
  }
  std::vector<std::vector<LinearityPoint>> of_frames(firsts.size());
  ParallelFor(static_cast<int>(firsts.size()), [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    of_frames[k] = LinearityPointsOf(ReadSignal(*firsts[k], read, blacks), card, i);
  });
  std::vector<LinearityPoint> points;
  for (const auto& own : of_frames) points.insert(points.end(), own.begin(), own.end());
  Linearity found;
  found.measured = FitNonlinearity(points, blacks.FullScale(blacks.levels().front()));
  const auto& stated = session.rig.optics.nonlinearity;
  const auto text = [](const Known& k) {
    return Short(100 * k.value) + " +- " + Short(100 * k.sigma) + " %";
  };
  if (stated) {
    found.used = stated;
    found.note = "as the rig states";
    if (!found.measured) return found;
    const Known& own = found.measured->nonlinearity;
    const double off = std::abs(own.value - stated->value);
    if (off > kWorthAWord && off > kDisagreement * std::hypot(own.sigma, stated->sigma))
      found.warning = "the rig states a nonlinearity of " + text(*stated) +
                      " at full scale, the Spectralon frames show " + text(own) +
                      ": measure it again, or leave it out of the rig's file to use the frames' own";
    return found;
  }
  if (!found.measured) {
    found.note = "the rig states no nonlinearity, and the frames do not tell it";
    return found;
  }
  const Known& own = found.measured->nonlinearity;
  const double belief = kUsual * kUsual / (kUsual * kUsual + own.sigma * own.sigma);
  found.used = Known{belief * own.value, own.sigma * std::sqrt(belief)};
  found.note = text(*found.used) + " at full scale, by the Spectralon frames";
  return found;
}

}  // namespace dermap
