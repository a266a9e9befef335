// SPDX-License-Identifier: Apache-2.0
// Photosite by photosite: response, dark current, Poisson, read noise, black level, conversion, saturation.
#include "acquire/simulated/sensor.h"

#include <algorithm>
#include <cmath>

#include "acquire/simulated/dng_writer.h"
#include "acquire/simulated/random_field.h"

namespace dermap {
namespace {

constexpr double kHotDarkCurrent =
    200000.0;  // electrons/s of the hottest photosites: 160 DN in 10 ms at ISO 100

// A photosite drawn at random.
float& AnyPhotosite(PlaneF& plane, std::mt19937_64& random) {
  const int x = static_cast<int>(Uniform(random) * plane.width());
  const int y = static_cast<int>(Uniform(random) * plane.height());
  return plane(x, y);
}

}  // namespace

Sensor::Sensor(const BenchConfig& config, std::uint64_t seed)
    : config_(config),
      response_(config.width_px, config.height_px, 1.0f),
      offset_dn_(config.width_px, config.height_px),
      dark_current_(config.width_px, config.height_px,
                    static_cast<float>(config.dark_current_electrons_per_s)) {
  auto pattern = RandomStream(seed, "sensor pattern");
  for (float& v : response_.values()) v += static_cast<float>(config.response_pattern * Normal(pattern));
  for (float& v : offset_dn_.values()) v = static_cast<float>(config.black_pattern_dn * Normal(pattern));
  auto defects = RandomStream(seed, "sensor defects");
  for (int i = 0; i < config.hot_photosites; ++i) {
    AnyPhotosite(dark_current_, defects) =
        static_cast<float>(kHotDarkCurrent * (0.2 + 0.8 * Uniform(defects)));
  }
  for (int i = 0; i < config.dead_photosites; ++i) AnyPhotosite(response_, defects) = 0.0f;
}

double Sensor::ElectronsPerDn(int iso) const noexcept {
  return config_.full_well_electrons / (kDngWhiteLevel - config_.black_level_dn) * 100.0 / iso;
}

Plane<std::uint16_t> Sensor::Read(const PlaneF& electrons, double exposure_ms, int iso,
                                  std::mt19937_64 random) const {
  const double electrons_per_dn = ElectronsPerDn(iso);
  const double exposure_s = exposure_ms / 1000.0;
  Plane<std::uint16_t> frame(config_.width_px, config_.height_px);
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const double expected = static_cast<double>(electrons.values()[i]) * response_.values()[i] +
                            dark_current_.values()[i] * exposure_s;
    double collected = expected;
    if (config_.shot_noise && expected > 0.0)
      collected = static_cast<double>(std::poisson_distribution<long>(expected)(random));
    collected = std::min(
        collected, config_.full_well_electrons * 1.02);  // the well itself is a little larger than the range
    if (config_.read_noise_electrons > 0.0) collected += config_.read_noise_electrons * Normal(random);
    double signal_dn = collected / electrons_per_dn;
    if (config_.nonlinearity != 0.0) {  // light = signal (1 + k signal / full scale), solved for the signal
      const double k = config_.nonlinearity / (kDngWhiteLevel - config_.black_level_dn);
      signal_dn = (std::sqrt(std::max(0.0, 1.0 + 4.0 * k * signal_dn)) - 1.0) / (2.0 * k);
    }
    double dn = config_.black_level_dn + offset_dn_.values()[i] + signal_dn;
    if (config_.read_noise_dn > 0.0) dn += config_.read_noise_dn * Normal(random);
    frame.values()[i] = static_cast<std::uint16_t>(std::clamp<long>(std::lround(dn), 0, kDngWhiteLevel));
  }
  return frame;
}

}  // namespace dermap
