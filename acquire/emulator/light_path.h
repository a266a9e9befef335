// SPDX-License-Identifier: Apache-2.0
// What lies between the emulated flash and the emulated camera: the optical bench, with the filter that the
// emulated wheel really holds into the light, and the target that the operator has put in place.
#pragma once

#include <functional>

#include "acquire/emulator/wheel_motion.h"
#include "acquire/simulated/optical_bench.h"

namespace dermap::emulator {

class LightPath {
 public:
  // Renders the scene of the rig: takes seconds. A flash that is fired before its lamp says that it has
  // recycled, at nine tenths of `flash_recycle_s`, stays dark.
  LightPath(const RigConfig& rig, const WheelMotion& wheel, double flash_recycle_s,
            const ProgressFunction& progress = {});

  FrameRole target = FrameRole::kBlack;
  // One exposure, with what stands in the light now; what it returns makes the file, at any time and in any
  // thread. A wheel that turns lets nothing through, as one between two slots does.
  std::function<Bytes()> Expose(double exposure_ms, int iso);

 private:
  const WheelMotion& wheel_;
  bool FlashFires();
  OpticalBench bench_;
  double flash_recycle_s_;
  Clock::time_point flash_ready_{};
  int shots_ = 0;
};

}  // namespace dermap::emulator
