// SPDX-License-Identifier: Apache-2.0
// The shipped plan on the shipped rig.
#include <gtest/gtest.h>

#include <algorithm>

#include "acquire/schedule.h"
#include "acquire/simulated/optical_bench.h"
#include "tests/acquire/support.h"

namespace dermap {
namespace {

// What the plan's own first lines promise: Spectralon reaches 65 to 90 % of full scale in the photosites that
// see a band best (the flash's drift included), and nothing saturates.
TEST(StandardPlan, ExposesSpectralonWell) {
  const RigConfig rig = ReadRig(ConfigDirectory() / "rigs/simulated_8band.toml");
  const OpticalBench bench(rig, acquire_test::FlatScene(0.5, BenchConfig{}));
  for (const FrameRecord& f : MakeSchedule(rig, ReadPlan(ConfigDirectory() / "plans/standard.toml"))) {
    if (f.role != FrameRole::kSpectralon) continue;
    auto frame = bench.Expose({f.role, f.slot, f.exposure_ms, f.iso, f.number});
    auto values = frame.values();
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() * 99 / 100),
                     values.end());
    const double level = (values[values.size() * 99 / 100] - 126.0) / (4095.0 - 126.0);
    EXPECT_GT(level, 0.65) << f.wavelength_nm;
    EXPECT_LT(level, 0.90) << f.wavelength_nm;
    EXPECT_EQ(std::count(values.begin(), values.end(), 4095), 0) << f.wavelength_nm;
  }
}

}  // namespace
}  // namespace dermap
