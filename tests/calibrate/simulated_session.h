// SPDX-License-Identifier: Apache-2.0
// Sessions straight from the simulated bench, without files: the frames are exposed when they are read.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "acquire/simulated/optical_bench.h"
#include "calibrate/frames.h"
#include "common/files/session.h"

namespace dermap {

class SimulatedSession {
 public:
  // The 8-band rig and the standard plan, with a scene of a test pattern.
  SimulatedSession(const std::string& scene_file, const std::function<void(Scene&)>& change = {},
                   const std::function<void(PlanConfig&)>& change_plan = {});

  Session& session() { return session_; }
  const OpticalBench& bench() const { return *bench_; }
  FrameReader Reader() const;
  // Frames of one role at one wavelength (0: any).
  std::vector<FrameRecord> Frames(FrameRole role, double wavelength_nm = 0.0) const;
  Shot ShotOf(const FrameRecord& record) const;

 private:
  std::unique_ptr<OpticalBench> bench_;
  Session session_;
};

BayerFrame FrameOf(Plane<std::uint16_t> values);

}  // namespace dermap
