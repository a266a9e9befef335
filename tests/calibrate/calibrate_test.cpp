// SPDX-License-Identifier: Apache-2.0
// The whole stage against the simulated bench, whose truth is known: test patterns of known reflectance, so that no model
// of skin takes part.
#include "calibrate/calibrate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "common/core/error.h"
#include "simulated_session.h"

namespace dermap {
namespace {

using ::testing::HasSubstr;

struct Mean {
  double value = 0.0, variance = 0.0;
  int count = 0;
};

Mean MeanOver(const PlaneF& plane, const PlaneF& valid) {
  Mean mean;
  for (std::size_t i = 0; i < plane.size(); ++i) {
    if (valid.data()[i] == 0.0f || std::isnan(plane.data()[i])) continue;
    mean.value += plane.data()[i];
    ++mean.count;
  }
  mean.value /= mean.count;
  for (std::size_t i = 0; i < plane.size(); ++i) {
    if (valid.data()[i] == 0.0f || std::isnan(plane.data()[i])) continue;
    mean.variance += std::pow(plane.data()[i] - mean.value, 2) / (mean.count - 1);
  }
  return mean;
}

// The scene's own reflectance, 0.5 in every band, with every effect of the bench switched on.
TEST(Calibrate, GrayPatchComesOutWithinHalfAPercent) {
  SimulatedSession simulated("gray_50.toml");
  const auto result = CalibrateFrames(simulated.session(), simulated.Reader(), {});
  ASSERT_EQ(result.stack.bands.size(), 8u);
  for (std::size_t b = 0; b < 8; ++b) {
    const Mean mean = MeanOver(result.stack.reflectance[b], result.stack.valid);
    std::cout << result.stack.bands[b].wavelength_nm << " nm: mean " << mean.value << " scatter "
              << std::sqrt(mean.variance) << " sigma " << result.bands[b].median_noise << " drift "
              << result.bands[b].gray_card_drift[0] << " shift " << result.bands[b].alignment.dx_px << " "
              << result.bands[b].alignment.dy_px << "\n";
    for (const auto& note : result.bands[b].notes) std::cout << "   " << note << "\n";
    EXPECT_NEAR(mean.value, 0.5, 0.005 * 0.5) << result.stack.bands[b].wavelength_nm << " nm";
  }
}

}  // namespace
}  // namespace dermap
