// SPDX-License-Identifier: Apache-2.0
// The sensor: expected electrons in, 12-bit numbers out, with the noise and the fixed patterns of a CMOS
// camera.
#pragma once

#include <cstdint>
#include <random>

#include "acquire/simulated/bench_config.h"
#include "common/core/image.h"

namespace dermap {

class Sensor {
 public:
  Sensor(const BenchConfig& config, std::uint64_t seed);

  // Photo-electrons that the amplifier at this ISO turns into one digital number.
  double ElectronsPerDn(int iso) const noexcept;
  // `electrons`: expected photo-electrons of a photosite with the mean response.
  Plane<std::uint16_t> Read(const PlaneF& electrons, double exposure_ms, int iso,
                            std::mt19937_64 random) const;

 private:
  BenchConfig config_;
  PlaneF response_;      // relative; 0 for dead photosites
  PlaneF offset_dn_;     // fixed pattern around the black level
  PlaneF dark_current_;  // electrons/s, high for hot photosites
};

}  // namespace dermap
