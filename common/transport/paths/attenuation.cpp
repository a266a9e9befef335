// SPDX-License-Identifier: Apache-2.0
// A vector exponential.
#include "common/transport/paths/attenuation.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/core/kernel.h"
#include "common/core/lanes.h"
#include "common/transport/domain.h"

namespace dermap {
namespace {

// How far, along one axis, half of a path strays from its end, in mean free paths of scattering: a walk of
// isotropic scattering goes (2/3)(s - (1 - exp(-s))) in a length s. Mean over half a path of 1.5 mean free
// paths (the epidermis's own thickness, where most of its light goes), times 1/3 because both ends are pinned
// (a Brownian bridge over its half against a free walk): the square is 0.0175.
constexpr double kSpread = 0.132;
constexpr double kLeastSpread_px2 = 0.01;  // a narrower blur is none

// exp(-length x) = 2^n 2^f with f in [-1/2, 1/2]; Taylor's polynomial of 2^f. n is a multiple of kLanes.
DERMAP_KERNEL
void NegativeExponential(const float* x, float length, std::size_t n, float* out) noexcept {
  typedef std::int32_t WholeLanes __attribute__((vector_size(sizeof(Lanes))));
  constexpr float kRound = 12582912.0f;  // 1.5 * 2^23: adding it rounds to a whole number
  const float scale = -1.44269504f * length;
  const Lanes lowest = Lanes{} - 126.0f;
  for (std::size_t i = 0; i < n; i += kLanes) {
    const Lanes scaled = DERMAP_LOAD(x + i) * scale;
    const Lanes power = scaled < lowest ? lowest : scaled;
    const Lanes whole = (power + kRound) - kRound, f = power - whole;
    Lanes series = f * 1.54035304e-4f + 1.33335581e-3f;
    series = series * f + 9.61812911e-3f;
    series = series * f + 5.55041087e-2f;
    series = series * f + 2.40226507e-1f;
    series = series * f + 6.93147181e-1f;
    series = series * f + 1.0f;
    const WholeLanes exponent = (__builtin_convertvector(whole, WholeLanes) + 127) << 23;
    DERMAP_STORE(out + i, series * (Lanes)exponent);  // the bits of a float
  }
}

}  // namespace

void Attenuate(const PlaneF& mu_a, double length_mm, PlaneF& out) {
  EnsureShape(out, mu_a.width(), mu_a.height());
  const std::size_t whole = mu_a.size() / kLanes * kLanes, rest = mu_a.size() - whole;
  const auto length = static_cast<float>(length_mm);
  NegativeExponential(mu_a.data(), length, whole, out.data());
  if (rest == 0) return;
  float last[kLanes] = {};
  std::copy_n(mu_a.data() + whole, rest, last);
  NegativeExponential(last, length, kLanes, last);
  std::copy_n(last, rest, out.data() + whole);
}

SymmetricKernel StrayKernel(double mean_free_path_mm, double pixel_size_mm) {
  const double spread_px2 = std::pow(kSpread * mean_free_path_mm / pixel_size_mm, 2);
  return spread_px2 > kLeastSpread_px2 ? BlurKernel(0.0, spread_px2) : SymmetricKernel{};
}

}  // namespace dermap
