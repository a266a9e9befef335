// SPDX-License-Identifier: Apache-2.0
// Sub-photosite position of the window: half-level points along the normals of each edge, a robust line
// through them, corners where the lines meet.
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "calibrate/edge_model.h"
#include "calibrate/window.h"
#include "common/core/error.h"

namespace dermap {
namespace {

constexpr double kReach_px = 8.0;        // of a profile to either side
constexpr double kRoughReach_px = 12.0;  // in the first pass, which starts from a contour
constexpr double kStep_px = 0.5;
constexpr double kClear_px = 3.0;  // blur of lens and lattice: nearer to the edge neither side is level
constexpr int kNeighbours = 2;     // profiles averaged to either side
constexpr int kPasses = 3;         // the last two by the model of the edge
constexpr std::size_t kRoughSamples = 8000;  // of all passes by the model but the last, which decides
constexpr double kFewestProfiles = 0.3;      // of those tried
constexpr double kLeastContrast = 0.004;     // reflectance

using Profile = std::vector<double>;  // from outside to inside, NaN where masked

double Offset(std::size_t index, double reach) {
  return static_cast<double>(index) * kStep_px - reach;
}

std::vector<Profile> Profiles(const Mosaic& mosaic, const Edge& edge, const std::vector<double>& positions,
                              double reach) {
  const auto count = static_cast<std::size_t>(2 * reach / kStep_px) + 1;
  std::vector<Profile> profiles;
  for (const double t : positions) {
    Profile profile(count);
    for (std::size_t i = 0; i < count; ++i) {
      const Point p = edge.At(t, Offset(i, reach));
      profile[i] = ReflectanceAt(mosaic, p.x, p.y);
    }
    profiles.push_back(std::move(profile));
  }
  return profiles;
}

Profile MeanOfNeighbours(const std::vector<Profile>& profiles, int index) {
  Profile mean(profiles[0].size(), 0.0);
  for (std::size_t i = 0; i < mean.size(); ++i) {
    double sum = 0.0;
    int count = 0;
    for (int k = index - kNeighbours; k <= index + kNeighbours; ++k) {
      if (k < 0 || k >= static_cast<int>(profiles.size()) || std::isnan(profiles[k][i])) continue;
      sum += profiles[k][i];
      ++count;
    }
    mean[i] = count > 0 ? sum / count : std::nan("");
  }
  return mean;
}

// Straight line through the inside's samples, read at the edge: skin darkens towards the tape, since light is
// lost under it, and the level to halve is the one right at the edge.
double InsideLevel(const Profile& profile, double centre, double reach) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const double x = Offset(i, reach) - centre;
    if (x < kClear_px || std::isnan(profile[i])) continue;
    n += 1, sx += x, sy += profile[i], sxx += x * x, sxy += x * profile[i];
  }
  const double determinant = n * sxx - sx * sx;
  if (n < 4 || determinant <= 0) return std::nan("");
  return (sxx * sy - sx * sxy) / determinant;
}

double OutsideLevel(const Profile& profile, double centre, double reach) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < profile.size(); ++i) {
    if (Offset(i, reach) - centre > -kClear_px || std::isnan(profile[i])) continue;
    sum += profile[i];
    ++count;
  }
  return count > 0 ? sum / count : std::nan("");
}

// Where the profile rises through the half level, nearest to `centre`.
std::optional<double> Crossing(const Profile& profile, double centre, double reach) {
  const double outside = OutsideLevel(profile, centre, reach);
  const double inside = InsideLevel(profile, centre, reach);
  if (!(inside - outside > kLeastContrast)) return std::nullopt;
  const double half = 0.5 * (inside + outside);
  std::optional<double> best;
  for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
    const double a = profile[i];
    const double b = profile[i + 1];
    if (!(a < half && b >= half)) continue;
    const double s = Offset(i, reach) + kStep_px * (half - a) / (b - a);
    if (!best || std::abs(s - centre) < std::abs(*best - centre)) best = s;
  }
  return best;
}

struct Line {
  Point origin, direction;
};

struct EdgeFit {
  Line line;
  double uncertainty_px = 0.0;
  double blur_px = 0.0;
};

std::optional<EdgeFit> HalfLevelLine(const Mosaic& mosaic, const Edge& edge, double reach) {
  std::vector<double> positions;
  for (double t = kCornerShare * edge.length(); t <= (1 - kCornerShare) * edge.length(); t += 2.0)
    positions.push_back(t);
  const std::vector<Profile> profiles = Profiles(mosaic, edge, positions, reach);
  std::vector<cv::Point2f> points;  // along, inwards
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Profile mean = MeanOfNeighbours(profiles, static_cast<int>(i));
    std::optional<double> crossing = Crossing(mean, 0.0, reach);
    if (crossing) crossing = Crossing(mean, *crossing, reach);  // levels reckoned from the edge found
    if (crossing) points.emplace_back(static_cast<float>(positions[i]), static_cast<float>(*crossing));
  }
  if (static_cast<double>(points.size()) < kFewestProfiles * static_cast<double>(positions.size()))
    return std::nullopt;
  cv::Vec4f fit;
  cv::fitLine(points, fit, cv::DIST_HUBER, 0, 0.001, 0.001);
  EdgeFit result;
  const Point a = edge.At(fit[2], fit[3]);
  const Point b = edge.At(fit[2] + fit[0], fit[3] + fit[1]);
  result.line = {a, {b.x - a.x, b.y - a.y}};
  for (const auto& p : points) {
    const double off = (p.y - fit[3]) * fit[0] - (p.x - fit[2]) * fit[1];
    result.uncertainty_px += off * off / static_cast<double>(points.size());
  }
  result.uncertainty_px = std::sqrt(result.uncertainty_px / static_cast<double>(points.size()));
  return result;
}

// The edges where the model puts them, or by half levels where the model finds none.
std::array<std::optional<EdgeFit>, 4> ModelLines(const Mosaic& mosaic, const std::array<Edge, 4>& edges,
                                                 double window_mm, std::size_t most_samples) {
  std::array<std::optional<EdgeFit>, 4> lines;
  const auto shifts = FitEdges(mosaic, edges, window_mm, most_samples);
  for (std::size_t i = 0; i < 4; ++i) {
    if (!shifts) {
      lines[i] = HalfLevelLine(mosaic, edges[i], kReach_px);
      continue;
    }
    const Point a = edges[i].At(0.0, (*shifts)[i].from_px);
    const Point b = edges[i].At(edges[i].length(), (*shifts)[i].to_px);
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    lines[i] = EdgeFit{
        {a, {(b.x - a.x) / length, (b.y - a.y) / length}}, (*shifts)[i].uncertainty_px, (*shifts)[i].blur_px};
  }
  return lines;
}

std::optional<Point> Intersection(const Line& a, const Line& b) {
  const double cross = a.direction.x * b.direction.y - a.direction.y * b.direction.x;
  if (std::abs(cross) < 0.2) return std::nullopt;  // of unit vectors: less than 12 degrees apart
  const double t =
      ((b.origin.x - a.origin.x) * b.direction.y - (b.origin.y - a.origin.y) * b.direction.x) / cross;
  return Point{a.origin.x + t * a.direction.x, a.origin.y + t * a.direction.y};
}

void MeasureSides(Window& window) {
  for (std::size_t i = 0; i < 4; ++i) {
    const double side = Edge{window.corners[i], window.corners[(i + 1) % 4]}.length();
    window.smallest_side_px = i == 0 ? side : std::min(window.smallest_side_px, side);
    window.largest_side_px = std::max(window.largest_side_px, side);
  }
}

}  // namespace

Window RefineWindow(const Mosaic& mosaic, const std::array<Point, 4>& rough, double window_mm,
                    const std::string& frame_name) {
  Window window;
  window.corners = rough;
  for (int pass = 0; pass < kPasses; ++pass) {
    std::array<Edge, 4> edges;
    for (std::size_t i = 0; i < 4; ++i) edges[i] = {window.corners[i], window.corners[(i + 1) % 4]};
    std::array<std::optional<EdgeFit>, 4> fits;
    if (pass == 0) {
      for (std::size_t i = 0; i < 4; ++i) fits[i] = HalfLevelLine(mosaic, edges[i], kRoughReach_px);
    } else {
      fits = ModelLines(mosaic, edges, window_mm, pass + 1 < kPasses ? kRoughSamples : kEdgeSamples);
    }
    double mean_square = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      if (!fits[i]) {
        throw InputError(
            frame_name + ": side " + std::to_string(i + 1) +
            " of the window (clockwise from the top) has no clear edge against the tape; expected a "
            "straight cut, in focus and in the light: check the tape and capture this frame again");
      }
      mean_square += fits[i]->uncertainty_px * fits[i]->uncertainty_px / 4;
    }
    for (std::size_t i = 0; i < 4; ++i) {
      const auto corner = Intersection(fits[(i + 3) % 4]->line, fits[i]->line);
      if (!corner) {
        throw InputError(
            frame_name +
            ": the window's sides do not make a square; expected one square cut into black tape: "
            "check the tape and capture this frame again");
      }
      window.corners[i] = *corner;
    }
    window.edge_uncertainty_px = std::sqrt(mean_square);
    window.blur_px = fits[0]->blur_px;
  }
  MeasureSides(window);
  window.camera_from_unit = CameraFromUnit(window.corners);
  return window;
}

}  // namespace dermap
