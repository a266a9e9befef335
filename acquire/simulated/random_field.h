// SPDX-License-Identifier: Apache-2.0
// Smooth random functions of the plane, and random numbers that depend on nothing but a seed and a purpose.
#pragma once

#include <cstdint>
#include <random>
#include <string_view>
#include <vector>

namespace dermap {

// A generator for one purpose (and one index within it) of a seed; streams of different purposes are
// independent, so that adding a consumer of randomness changes nothing for the others.
std::mt19937_64 RandomStream(std::uint64_t seed, std::string_view purpose, std::uint64_t index = 0);

// Uniform in [0, 1), the same on every standard library.
double Uniform(std::mt19937_64& random);
// Mean 0, variance 1 (Box and Muller), the same on every standard library.
double Normal(std::mt19937_64& random);

// A stationary field of mean 0, variance 1 and correlation exp(-d^2 / (2 correlation_mm^2)): a sum of plane
// waves whose wave vectors are drawn from that correlation's spectrum (random Fourier features). Being a
// function of position, not an image, it is the same at every resolution.
class RandomField {
 public:
  RandomField(std::mt19937_64 random, double correlation_mm);
  double At(double x_mm, double y_mm) const noexcept;

 private:
  struct Wave {
    double kx, ky, phase;  // 1/mm, radians
  };
  std::vector<Wave> waves_;
};

}  // namespace dermap
