// SPDX-License-Identifier: Apache-2.0
// The bench's exposures as frames of a session.
#include "tests/calibrate/simulated_session.h"

#include "acquire/schedule.h"
#include "acquire/simulated/dng_writer.h"

namespace dermap {

SimulatedSession::SimulatedSession(const std::string& scene_file, const std::function<void(Scene&)>& change,
                                   const std::function<void(PlanConfig&)>& change_plan) {
  session_.rig = ReadRig(ConfigDirectory() / "rigs/simulated_8band.toml");
  session_.plan = ReadPlan(ConfigDirectory() / "plans/standard.toml");
  if (change_plan) change_plan(session_.plan);
  Scene scene = ReadScene(ConfigDirectory() / "scenes" / scene_file, session_.rig.window_mm);
  if (change) change(scene);
  bench_ = std::make_unique<OpticalBench>(session_.rig, std::move(scene));
  session_.directory = "simulated";
  session_.complete = true;
  session_.frames = MakeSchedule(session_.rig, session_.plan);
  for (FrameRecord& record : session_.frames) record.file = "frame " + std::to_string(record.number);
}

Shot SimulatedSession::ShotOf(const FrameRecord& record) const {
  return {record.role, record.slot, record.exposure_ms, record.iso, record.number};
}

FrameReader SimulatedSession::Reader() const {
  return [this](const FrameRecord& record) {
    BayerFrame frame = FrameOf(bench_->Expose(ShotOf(record)));
    if (bench_->scene().bench.filters == BenchConfig::Filters::kNone) frame.colours.fill('W');
    if (bench_->scene().bench.filters == BenchConfig::Filters::kXTrans) {
      frame.colours.fill('X');
      frame.period = 6;
    }
    return frame;
  };
}

std::vector<FrameRecord> SimulatedSession::Frames(FrameRole role, double wavelength_nm) const {
  std::vector<FrameRecord> found;
  for (const FrameRecord& record : session_.frames) {
    if (record.role == role && (wavelength_nm == 0.0 || record.wavelength_nm == wavelength_nm))
      found.push_back(record);
  }
  return found;
}

BayerFrame FrameOf(Plane<std::uint16_t> values) {
  BayerFrame frame;
  frame.values = std::move(values);
  frame.colours = {'R', 'G', 'G', 'B'};
  frame.black_level = 126;
  frame.white_level = kDngWhiteLevel;
  return frame;
}

}  // namespace dermap
