// SPDX-License-Identifier: Apache-2.0
// xoshiro256++ (Blackman and Vigna 2019), seeded through splitmix64: fast uniform numbers for the Monte
// Carlo.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace dermap::reference {

class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t stream) {
    std::uint64_t x = seed ^ (stream * 0xd1342543de82ef95ULL + 0x632be59bd9b4e019ULL);
    for (std::uint64_t& s : state_) {
      x += 0x9e3779b97f4a7c15ULL;
      std::uint64_t z = x;
      z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
      z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
      s = z ^ (z >> 31);
    }
  }
  // In [0, 1).
  double Uniform() noexcept { return static_cast<double>(Next() >> 11) * 0x1.0p-53; }
  // -ln of a uniform number: an optical depth.
  double Exponential() noexcept { return -std::log1p(-Uniform()); }

 private:
  std::array<std::uint64_t, 4> state_{};

  std::uint64_t Next() noexcept {
    const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
    const std::uint64_t t = state_[1] << 17;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= t;
    state_[3] = std::rotl(state_[3], 45);
    return result;
  }
};

}  // namespace dermap::reference
