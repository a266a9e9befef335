// SPDX-License-Identifier: Apache-2.0
// For the tests of acquire/: folders that vanish, small rigs, plans and scenes, and a camera that fails on
// demand.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "acquire/devices/station.h"
#include "acquire/simulated/optical_bench.h"

namespace dermap::acquire_test {

class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path Write(const std::string& name, const std::string& text) const;

 private:
  std::filesystem::path path_;
};

// Two filters (540 nm in slot 1, 650 nm in slot 2) and the opaque slot 3.
RigConfig SmallRig();
// A scene of one reflectance, with these effects.
Scene FlatScene(double reflectance, const BenchConfig& bench, std::uint64_t seed = 1);

// The same as files, for RunCapture: PLAN takes 2 black, 2 Spectralon and 2 skin frames.
inline constexpr int kSmallPlanFrames = 6;
std::string SmallRigToml(const std::string& scene);
std::string SmallPlanToml();
std::string SmallSceneToml();  // flat, a small sensor, all effects on

// Passes everything on to another station, and counts; `before_capture` may throw, `after_capture` may damage
// a frame.
class WatchedStation : public Station, private Camera {
 public:
  explicit WatchedStation(Station& inner) : inner_(inner) {}
  Camera& camera() override { return *this; }
  FilterWheel& wheel() override { return inner_.wheel(); }
  void Prepare(const ProgressFunction& progress) override { inner_.Prepare(progress); }
  void Place(FrameRole role) override { inner_.Place(role); }
  void WriteRecords(const std::filesystem::path& directory, std::span<const FrameRecord> schedule) override {
    inner_.WriteRecords(directory, schedule);
  }

  std::map<int, int> shots;  // how often each number was exposed
  std::function<void(const CaptureSettings&)> before_capture;
  std::function<void(const CaptureSettings&, RawFrame&)> after_capture;

 private:
  std::string Name() const override { return "watched camera"; }
  std::uintmax_t FrameBytes() const override { return inner_.camera().FrameBytes(); }
  std::chrono::steady_clock::time_point Expose(const CaptureSettings& settings) override;
  RawFrame Fetch() override;

  Station& inner_;
  CaptureSettings exposed_;
};

}  // namespace dermap::acquire_test
