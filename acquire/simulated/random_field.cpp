// SPDX-License-Identifier: Apache-2.0
// Random Fourier features, and seeds mixed by FNV-1a and splitmix64.
#include "acquire/simulated/random_field.h"

#include <cassert>
#include <cmath>
#include <numbers>

namespace dermap {
namespace {

constexpr int kWaves = 96;  // enough for the one-point distribution to be near normal

std::uint64_t Mix(std::uint64_t z) {  // splitmix64's finaliser
  z += 0x9E3779B97F4A7C15ull;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
  return z ^ (z >> 31);
}

}  // namespace

std::mt19937_64 RandomStream(std::uint64_t seed, std::string_view purpose, std::uint64_t index) {
  std::uint64_t hash = 0xCBF29CE484222325ull;  // FNV-1a
  for (const char c : purpose) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3ull;
  return std::mt19937_64(Mix(Mix(seed ^ hash) + index));
}

double Uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1.0p-53;
}

double Normal(std::mt19937_64& random) {
  const double u = 1.0 - Uniform(random);  // (0, 1]
  const double v = Uniform(random);
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
}

RandomField::RandomField(std::mt19937_64 random, double correlation_mm) {
  assert(correlation_mm > 0.0);
  waves_.reserve(kWaves);
  for (int i = 0; i < kWaves; ++i) {
    const double kx = Normal(random) / correlation_mm;
    const double ky = Normal(random) / correlation_mm;
    waves_.push_back({kx, ky, 2.0 * std::numbers::pi * Uniform(random)});
  }
}

double RandomField::At(double x_mm, double y_mm) const noexcept {
  double sum = 0.0;
  for (const Wave& w : waves_) sum += std::cos(w.kx * x_mm + w.ky * y_mm + w.phase);
  return sum * std::sqrt(2.0 / kWaves);
}

}  // namespace dermap
