// SPDX-License-Identifier: Apache-2.0
// Kernels for the grids of the path engine.
#include "common/transport/paths/path_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/core/kernel.h"
#include "common/core/lanes.h"
#include "common/optics/profile_table.h"
#include "common/transport/paths/radial_transform.h"

namespace dermap {
namespace {

// Steps of ln mu_a to which a scene's range is rounded: finer where it is narrow, since two path lengths do
// for less than a tenth. A quarter of a step is left on both sides.
double RangeStep(double width) {
  return width < 0.08 ? 0.02 : width < 0.3 ? 0.1 : 0.4;
}
// What a stencil may leave out by few path lengths, in units of the tolerance: of what the surface returns,
// at its finest structure.
constexpr double kSurfaceShare = 2.0;
// Halving takes off middle frequencies; more than this is not given back to what has no fine structure.
constexpr double kMostCompensation = 4.0;

std::vector<RadialTransform> Radial(const std::vector<std::vector<float>>& kernels) {
  return {kernels.begin(), kernels.end()};
}

// Where a grid's part ends and the next finer one's begins, and how long the stencils are.
struct Split {
  int order;        // terms of the series in LowPass
  double sigma_px;  // of its Gaussian, in pixels of the finer grid
  int radius;       // of the stencil
};

// Measured on the recorded scenes (path_light_test.cpp): 2e-4, 4e-4 and 7e-4 rms of the render.
Split SplitFor(double tolerance) {
  if (tolerance < kStrictTolerance) return {3, 3.0, 12};
  return tolerance < kLooseTolerance ? Split{2, 2.5, 9} : Split{2, 2.2, 7};
}

double Compensation(double gain) {
  return 1.0 / std::max(gain, 1.0 / kMostCompensation);
}

class Planner {
 public:
  Planner(const PathFrames& frames, const ForwardOptions& options)
      : frames_(frames), options_(options), split_(SplitFor(options.tolerance)) {
    const double p = frames.pixel_size_mm;
    const auto axis = [&](int count) {
      std::vector<double> gains;
      for (int u = 0; u < count; ++u)
        gains.push_back(frames.GainDown(frames.halvings,
                                        std::numbers::pi * u / count * p / frames.pixel_at(frames.halvings)));
      return gains;
    };
    gain_x_ = axis(frames.transforms().width);
    gain_y_ = axis(frames.transforms().height);
    whole_ = FrequenciesOf(frames.transforms(), frames.pixel_at(frames.halvings));
    rest_ = FrequenciesOf(frames.rest, 2.0 * frames.pixel_at(frames.halvings));
  }

  // Of what is smooth by itself; `halved`: what halving took off light on its way here is given back.
  PathPlan::Kernels Smooth(const std::vector<RadialTransform>& paths, bool halved) const {
    return Spectra(paths, whole_, [&](int u, int v, double) {
      return halved ? Compensation(gain_x_[u] * gain_y_[v]) : 1.0;
    });
  }

  // What the transforms' grid carries of the surface's response, from the patch's grid and back.
  PathPlan::Kernels Surface(const std::vector<RadialTransform>& paths) const {
    return Spectra(paths, whole_, [&](int u, int v, double k) {
      const double gain = gain_x_[u] * gain_y_[v];
      return LowPass(frames_.halvings, k) / std::max(gain * gain, 1e-9);
    });
  }

  PathPlan::Kernels Rest(const std::vector<RadialTransform>& paths) const {
    return Spectra(paths, rest_, [](int, int, double) { return 1.0; });
  }

  // As few of the shortest paths as leave no error, relative to all that is returned, beyond the tolerance.
  std::vector<Stencil> SurfaceStencils(const TransformTable& response, std::span<const double> lengths_mm,
                                       const AbsorptionRange& range, int level) const {
    const auto frequencies = TableFrequencies_per_mm();
    PathFit fit;
    for (std::size_t count = 1; count <= lengths_mm.size(); ++count) {
      fit = FitPaths(response, lengths_mm.first(count), range.lowest, range.highest);
      double error = 0.0;
      for (std::size_t k = 0; k < frequencies.size(); ++k)
        error = std::max(error, fit.errors[k] * Share(level, frequencies[k]));
      if (error <= kSurfaceShare * options_.tolerance) break;
    }
    std::vector<Stencil> stencils;
    for (const RadialTransform& path : Radial(fit.kernels)) stencils.push_back(SurfaceStencil(path, level));
    return stencils;
  }

 private:
  static PlaneF FrequenciesOf(const PathFrames::Frame& grid, double pixel_mm) {
    PlaneF k_per_mm(grid.width, grid.height);
    for (int v = 0; v < grid.height; ++v)
      for (int u = 0; u < grid.width; ++u)
        k_per_mm(u, v) = static_cast<float>(std::numbers::pi / pixel_mm *
                                            std::hypot(double(u) / grid.width, double(v) / grid.height));
    return k_per_mm;
  }

  template <class Weight>
  static PathPlan::Kernels Spectra(const std::vector<RadialTransform>& paths, const PlaneF& frequencies,
                                   Weight weight) {
    PlaneF weights = frequencies;
    std::vector<RadialTransform::Position> positions;
    for (int v = 0; v < frequencies.height(); ++v) {
      for (int u = 0; u < frequencies.width(); ++u) {
        positions.push_back(RadialTransform::PositionOf(frequencies(u, v)));
        weights(u, v) = static_cast<float>(weight(u, v, frequencies(u, v)));
      }
    }
    PathPlan::Kernels kernels;
    for (const RadialTransform& path : paths) {
      PlaneF& plane = kernels.planes.emplace_back(frequencies.width(), frequencies.height());
      for (std::size_t i = 0; i < plane.size(); ++i)
        plane.data()[i] = path.At(positions[i]) * weights.data()[i];
      kernels.totals.push_back(path.At(RadialTransform::PositionOf(0.0)));
    }
    return kernels;
  }

  // What the grid `level` and the coarser ones carry: exp(-x) (1 + x + ...), x = (k s)^2 / 2, which is flat
  // at low frequencies, so that what it leaves to the finer grid has no long tail.
  double LowPass(int level, double k_per_mm) const {
    if (level == 0) return 1.0;
    const double s = split_.sigma_px * frames_.pixel_at(level - 1), x = 0.5 * k_per_mm * k_per_mm * s * s;
    double series = 1.0, term = 1.0;
    for (int i = 1; i < split_.order; ++i) series += term *= x / i;
    return std::exp(-x) * series;
  }

  double Share(int level, double k_per_mm) const {
    return LowPass(level, k_per_mm) - LowPass(level + 1, k_per_mm);
  }

  Stencil SurfaceStencil(const RadialTransform& path, int level) const {
    const double pixel = frames_.pixel_at(level);
    const auto transfer = [&](double x, double y) {
      const double k = std::hypot(x, y) / pixel, fine = frames_.pixel_size_mm / pixel;
      const double gain = frames_.GainDown(level, x * fine) * frames_.GainDown(level, y * fine);
      return path.At(RadialTransform::PositionOf(k)) * Share(level, k) / std::max(gain * gain, 1e-9);
    };
    return {transfer, split_.radius};
  }

  const PathFrames& frames_;
  const ForwardOptions& options_;
  Split split_;
  std::vector<double> gain_x_, gain_y_;
  PlaneF whole_, rest_;  // frequencies of both grids, 1/mm
};

DERMAP_KERNEL
void FindExtremes(const float* values, std::size_t n, float& least, float& most) noexcept {
  float low[kLanes], high[kLanes];
  std::fill_n(low, kLanes, values[0]);
  std::fill_n(high, kLanes, values[0]);
  for (std::size_t i = 0; i + kLanes <= n; i += kLanes) {
    for (int l = 0; l < kLanes; ++l) {
      low[l] = values[i + l] < low[l] ? values[i + l] : low[l];
      high[l] = values[i + l] > high[l] ? values[i + l] : high[l];
    }
  }
  for (std::size_t i = n / kLanes * kLanes; i < n; ++i) {
    low[0] = std::min(low[0], values[i]);
    high[0] = std::max(high[0], values[i]);
  }
  least = *std::min_element(low, low + kLanes);
  most = *std::max_element(high, high + kLanes);
}

}  // namespace

AbsorptionRange RangeOf(const PlaneF& mu_a, double tolerance) {
  float least = mu_a.data()[0], most = least;
  FindExtremes(mu_a.data(), mu_a.size(), least, most);
  const auto bounded = [](double value) { return std::clamp(value, kTableMinMuA, kTableMaxMuA); };
  if (bounded(most) <= (1.0 + tolerance) * bounded(least)) return {bounded(least), bounded(most)};
  const double low = std::log(bounded(least)), high = std::log(bounded(most));
  const double step = RangeStep(high - low), margin = 0.25 * step;
  return {bounded(std::exp(std::floor((low - margin) / step) * step)),
          bounded(std::exp(std::ceil((high + margin) / step) * step))};
}

namespace {

// Nearly an exponential: light that is reflected twice and still crosses unscattered is next to nothing.
void SetBallistic(const ProfileTable& table, const AbsorptionRange& range, PathPlan& plan) {
  const auto share = [&](double mu_a) { return double(table.Total(static_cast<float>(mu_a))); };
  const double low = 0.9 * range.lowest, high = 1.1 * range.highest;  // a scene may have one absorption only
  const double least = share(high), most = share(low);
  if (!(least > 0.0)) return;
  plan.ballistic_mm = std::log(most / least) / (high - low);
  plan.ballistic_share = most * std::exp(low * plan.ballistic_mm);
}

// What an error of a response does to the reflectance of skin, relative: the derivatives of
// R1+ + T R2 T1- / (1 - R1- R2), with the other layer as light as it is anywhere in the scene.
class Influence {
 public:
  Influence(const BandTables& tables, const AbsorptionRange& epidermis, const AbsorptionRange& dermis)
      : t_(tables), lightest_epidermis_(epidermis.lowest), lightest_dermis_(dermis.lowest) {}

  // In the order of MakePlan's lists.
  double OfEpidermis(std::size_t response, double mu_a) const {
    const Passage p = At(mu_a, lightest_dermis_);
    const double back = p.r2 * p.again;
    const std::array<double, 4> of = {1.0, back * p.out, p.in * back * back * p.out, p.in * back};
    return of[response == 4 ? 2 : response] / p.reflectance;
  }
  double OfDermis(std::size_t, double mu_a) const {
    const Passage p = At(lightest_epidermis_, mu_a);
    return p.in * p.out * p.again * p.again / p.reflectance;
  }

 private:
  struct Passage {
    double in, out, r2, again, reflectance;
  };
  Passage At(double epidermis, double dermis) const {
    const auto above = static_cast<float>(epidermis), below = static_cast<float>(dermis);
    Passage p{};
    p.in = t_.t1_forward.Total(above) + (t_.t1_ballistic.empty() ? 0.0f : t_.t1_ballistic.Total(above));
    p.out = t_.t1_backward.Total(above);
    p.r2 = t_.r2_diffuse.Total(below);
    p.again = 1.0 / (1.0 - t_.r1_backward.Total(above) * p.r2);
    p.reflectance = t_.r1_forward.Total(above) + p.in * p.r2 * p.out * p.again;
    return p;
  }
  const BandTables& t_;
  double lightest_epidermis_, lightest_dermis_;
};

PathPlan MakePlan(const BandTables& t, const AbsorptionRange& epidermis, const AbsorptionRange& dermis,
                  bool black_tape, const PathFrames& frames, const ForwardOptions& options) {
  const TransformTable* const upper[] = {&t.r1_forward.transforms(), &t.t1_forward.transforms(),
                                         &t.r1_backward.transforms(), &t.t1_backward.transforms(),
                                         &t.r1_backward_black.transforms()};
  const TransformTable* const lower[] = {&t.r2_diffuse.transforms(), &t.r2_normal.transforms()};
  const Influence influence(t, epidermis, dermis);
  const ScenePaths e = ReducePaths(
      std::span(upper).first(black_tape ? 5 : 4), epidermis.lowest, epidermis.highest, options.tolerance,
      options.path_lengths, [&](std::size_t r, double mu_a) { return influence.OfEpidermis(r, mu_a); });
  const ScenePaths d =
      ReducePaths(lower, dermis.lowest, dermis.highest, options.tolerance, options.path_lengths,
                  [&](std::size_t r, double mu_a) { return influence.OfDermis(r, mu_a); });
  const Planner planner(frames, options);
  PathPlan plan;
  plan.epidermis_mm = e.lengths_mm;
  plan.dermis_mm = d.lengths_mm;
  plan.error = std::max(e.error, d.error);
  plan.r1_forward = planner.Surface(Radial(e.kernels[0]));
  plan.t1_forward = planner.Smooth(Radial(e.kernels[1]), true);
  plan.t1_backward = planner.Smooth(Radial(e.kernels[3]), true);
  plan.r1_backward_rest = planner.Rest(Radial(e.kernels[2]));
  if (black_tape) plan.r1_backward_black_rest = planner.Rest(Radial(e.kernels[4]));
  plan.r2_diffuse = planner.Smooth(Radial(d.kernels[0]), false);
  plan.r2_normal = planner.Smooth(Radial(d.kernels[1]), true);
  plan.r2_diffuse_rest = planner.Rest(Radial(d.kernels[0]));
  for (int level = 0; level < frames.halvings; ++level)
    plan.surface.push_back(
        planner.SurfaceStencils(t.r1_forward.transforms(), plan.epidermis_mm, epidermis, level));
  if (!t.t1_ballistic.empty()) SetBallistic(t.t1_ballistic, epidermis, plan);
  return plan;
}

}  // namespace

struct PathPlans::Entry {
  const BandTables* tables;
  AbsorptionRange epidermis, dermis;
  bool black_tape;
  int width, height;
  double margin_mm;
  std::once_flag made;
  PathPlan plan;
};

std::shared_ptr<const PathPlan> PathPlans::Get(const BandTables& tables, const AbsorptionRange& epidermis,
                                               const AbsorptionRange& dermis, bool black_tape,
                                               const PathFrames& frames, const ForwardOptions& options) {
  constexpr std::size_t kMostEntries = 64;
  std::shared_ptr<Entry> entry;
  {
    const std::lock_guard lock(mutex_);
    const auto same = [&](const std::shared_ptr<Entry>& e) {
      return e->tables == &tables && e->epidermis == epidermis && e->dermis == dermis &&
             e->black_tape == black_tape && e->width == frames.patch.width &&
             e->height == frames.patch.height && e->margin_mm == frames.margin_mm;
    };
    const auto found = std::find_if(entries_.begin(), entries_.end(), same);
    if (found != entries_.end()) {
      entry = *found;
      std::rotate(found, found + 1, entries_.end());
    } else {
      entry = std::make_shared<Entry>();
      entry->tables = &tables;
      entry->epidermis = epidermis;
      entry->dermis = dermis;
      entry->black_tape = black_tape;
      entry->width = frames.patch.width;
      entry->height = frames.patch.height;
      entry->margin_mm = frames.margin_mm;
      entries_.push_back(entry);
      if (entries_.size() > kMostEntries) entries_.erase(entries_.begin());
    }
  }
  std::call_once(entry->made,
                 [&] { entry->plan = MakePlan(tables, epidermis, dermis, black_tape, frames, options); });
  return {entry, &entry->plan};
}

}  // namespace dermap
