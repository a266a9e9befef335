// SPDX-License-Identifier: Apache-2.0
// The in-process camera and wheel.
#include "acquire/simulated/simulated_station.h"

#include <cstdio>

#include "acquire/simulated/dng_writer.h"
#include "acquire/simulated/truth.h"
#include "common/core/error.h"

namespace dermap {
namespace {

constexpr int kLowestIso = 50;
constexpr int kHighestIso = 6400;
constexpr double kFlashSync_ms = 4.0;  // a shorter exposure would not see the whole flash: 1/250 s

Scene SceneOfRig(const RigConfig& rig) {
  if (rig.simulated_scene.empty()) {
    throw InputError("Rig \"" + rig.name +
                     "\" uses simulated devices but names no scene; set scene in its [simulated] table.");
  }
  return ReadScene(rig.simulated_scene, rig.window_mm);
}

}  // namespace

class SimulatedStation::SimulatedWheel : public FilterWheel {
 public:
  explicit SimulatedWheel(SimulatedStation& station) : station_(station) {
    for (const WheelSlot& s : station.rig_.slots) slot_count_ = std::max(slot_count_, s.slot);
  }
  std::string Name() const override { return "simulated wheel"; }
  int SlotCount() const override { return slot_count_; }
  void MoveTo(int slot) override {
    if (slot < 1 || slot > slot_count_) {
      throw DeviceError("Simulated wheel: slot " + std::to_string(slot) + " was asked for; it has 1 to " +
                        std::to_string(slot_count_) + ".");
    }
    station_.slot_ = slot;
  }

 private:
  SimulatedStation& station_;
  int slot_count_ = 0;
};

class SimulatedStation::SimulatedCamera : public Camera {
 public:
  explicit SimulatedCamera(SimulatedStation& station) : station_(station) {}
  std::string Name() const override { return "simulated camera"; }
  std::uintmax_t FrameBytes() const override {
    const BenchConfig& c = station_.scene_.bench;
    return static_cast<std::uintmax_t>(c.width_px) * static_cast<std::uintmax_t>(c.height_px) * 3 / 2 + 2048;
  }
  std::chrono::steady_clock::time_point Expose(const CaptureSettings& s) override {
    const auto pressed = std::chrono::steady_clock::now();
    if (s.iso < kLowestIso || s.iso > kHighestIso) {
      throw DeviceError("Simulated camera: ISO " + std::to_string(s.iso) + " was asked for; it has " +
                        std::to_string(kLowestIso) + " to " + std::to_string(kHighestIso) + ".");
    }
    if (s.exposure_ms < kFlashSync_ms) {
      throw DeviceError("Simulated camera: " + std::to_string(s.exposure_ms) +
                        " ms was asked for; below 4 ms the shutter is not open for the whole flash.");
    }
    const Shot shot{station_.target_, station_.slot_, s.exposure_ms, s.iso, s.shot};
    frame_ = {EncodeDng(station_.bench().Expose(shot), MetadataOfShot(station_.bench(), shot)), ".dng"};
    return pressed;
  }
  RawFrame Fetch() override { return std::move(frame_); }

 private:
  SimulatedStation& station_;
  RawFrame frame_;
};

SimulatedStation::SimulatedStation(const RigConfig& rig)
    : rig_(rig),
      scene_(SceneOfRig(rig)),
      wheel_(std::make_unique<SimulatedWheel>(*this)),
      camera_(std::make_unique<SimulatedCamera>(*this)) {}

SimulatedStation::~SimulatedStation() = default;
Camera& SimulatedStation::camera() {
  return *camera_;
}
FilterWheel& SimulatedStation::wheel() {
  return *wheel_;
}
void SimulatedStation::Prepare(const ProgressFunction& progress) {
  if (!bench_) bench_.emplace(rig_, scene_, progress);
}

const OpticalBench& SimulatedStation::bench() {
  Prepare({});
  return *bench_;
}

void SimulatedStation::Place(FrameRole role) {
  target_ = role;
}

void SimulatedStation::WriteRecords(const std::filesystem::path& session_directory,
                                    std::span<const FrameRecord> schedule) {
  WriteTruth(session_directory / "truth", bench(), schedule);
}

DngMetadata MetadataOfShot(const OpticalBench& bench, const Shot& shot) {
  DngMetadata m;
  m.exposure_ms = shot.exposure_ms;
  m.iso = shot.iso;
  m.black_level = bench.scene().bench.black_level_dn;
  m.as_shot_neutral = {0.5, 1.0,
                       0.7};  // about what the response of the modelled camera asks for; of no use to us
  const int seconds = 20 * (shot.number - 1);
  char time[32];
  std::snprintf(time, sizeof time, "2024:01:01 %02d:%02d:%02d", 9 + seconds / 3600 % 12, seconds / 60 % 60,
                seconds % 60);
  m.date_time = time;
  m.serial = "simulated-seed-" + std::to_string(bench.scene().seed);
  m.description = bench.scene().name + ", seed " + std::to_string(bench.scene().seed) + ", shot " +
                  std::to_string(shot.number);
  return m;
}

}  // namespace dermap
