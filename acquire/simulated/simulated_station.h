// SPDX-License-Identifier: Apache-2.0
// Camera and wheel in front of one simulated optical bench.
#pragma once

#include <memory>
#include <optional>

#include "acquire/devices/station.h"
#include "acquire/simulated/optical_bench.h"

namespace dermap {

class SimulatedStation : public Station {
 public:
  // Reads the rig's scene. Throws InputError where the rig names none or the scene is wrong.
  explicit SimulatedStation(const RigConfig& rig);
  ~SimulatedStation() override;

  Camera& camera() override;
  FilterWheel& wheel() override;
  void Prepare(const ProgressFunction& progress) override;  // renders the scene, unless that is done
  void Place(FrameRole role) override;
  // truth/maps.exr (where skin is simulated), truth/reflectance.exr and truth/bench.json.
  void WriteRecords(const std::filesystem::path& session_directory,
                    std::span<const FrameRecord> schedule) override;

  const OpticalBench& bench();  // prepares the station if need be

 private:
  class SimulatedCamera;
  class SimulatedWheel;
  RigConfig rig_;
  Scene scene_;
  std::optional<OpticalBench> bench_;
  int slot_ = 1;
  FrameRole target_ = FrameRole::kBlack;
  std::unique_ptr<SimulatedWheel> wheel_;
  std::unique_ptr<SimulatedCamera> camera_;
};

// The DNG's metadata of a shot: the simulated camera has a clock of its own (20 s from shot to shot), so that
// the same seed gives the same file.
struct DngMetadata;
DngMetadata MetadataOfShot(const OpticalBench& bench, const Shot& shot);

}  // namespace dermap
