// SPDX-License-Identifier: Apache-2.0
// From a map of absorption to attenuations along a few path lengths.
#include "common/transport/path_layer.h"

#include <algorithm>
#include <cmath>

#include "common/core/kernel.h"
#include "common/optics/profile_table.h"

namespace dermap {
namespace {

constexpr double kRangeStep = 0.4;    // of ln mu_a
constexpr double kRangeMargin = 0.1;  // of ln mu_a, at least, on both sides
// How far, along one axis, half of a path strays from its end, in mean free paths of scattering: a walk of
// isotropic scattering goes (2/3)(s - (1 - exp(-s))) in a length s. Mean over half a path of 1.5 mean free
// paths (the epidermis's own thickness, where most of its light goes), times 1/3 because both ends are pinned
// (a Brownian bridge over its half against a free walk): the square is 0.0175.
constexpr double kSpread = 0.132;
constexpr double kLeastSpread_px2 = 0.01;  // a narrower blur is none

DERMAP_KERNEL
void Attenuate(const float* mu_a, float length, std::size_t n, float* __restrict out) noexcept {
  for (std::size_t i = 0; i < n; ++i) out[i] = std::exp(-length * mu_a[i]);
}

}  // namespace

AbsorptionRange RangeOf(const PlaneF& mu_a) {
  const auto [least, most] = std::minmax_element(mu_a.values().begin(), mu_a.values().end());
  const auto bounded = [](double value) { return std::clamp(value, kTableMinMuA, kTableMaxMuA); };
  const double low = std::floor((std::log(bounded(*least)) - kRangeMargin) / kRangeStep) * kRangeStep;
  const double high = std::ceil((std::log(bounded(*most)) + kRangeMargin) / kRangeStep) * kRangeStep;
  return {bounded(std::exp(low)), bounded(std::exp(high))};
}

void PathLayer::Set(std::span<const TransformTable* const> responses, const PlaneF& mu_a,
                    double mean_free_path_mm, double pixel_size_mm, Coupling coupling, double tolerance) {
  coupling_ = coupling;
  range_ = RangeOf(mu_a);
  paths_ = ReducePaths(responses, range_.lowest, range_.highest, tolerance);
  kernels_.resize(responses.size());
  for (std::size_t r = 0; r < responses.size(); ++r) {
    kernels_[r].clear();
    for (const auto& kernel : paths_.kernels[r]) kernels_[r].emplace_back(kernel);
  }
  const double share = coupling == Coupling::kReciprocal ? 0.5 : 1.0;  // of the path at the leaving end
  const double spread_px2 = std::pow(kSpread * mean_free_path_mm / pixel_size_mm, 2);
  const bool strays = coupling == Coupling::kReciprocal && spread_px2 > kLeastSpread_px2;
  const SymmetricKernel spread = strays ? BlurKernel(0.0, spread_px2) : SymmetricKernel{};
  attenuation_.resize(paths_.count());
  for (int j = 0; j < paths_.count(); ++j) {
    PlaneF& plane = attenuation_[j];
    EnsureShape(plane, mu_a.width(), mu_a.height());
    Attenuate(mu_a.data(), static_cast<float>(share * paths_.lengths_mm[j]), mu_a.size(), plane.data());
    if (!spread.empty()) blur_.Apply(plane, spread, plane);
  }
}

}  // namespace dermap
