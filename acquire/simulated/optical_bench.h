// SPDX-License-Identifier: Apache-2.0
// The optical bench: flash, filter, target, gray card and lens in front of the sensor, for one scene on one
// rig.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "acquire/simulated/patch_reflectance.h"
#include "acquire/simulated/pinhole_view.h"
#include "acquire/simulated/scene.h"
#include "acquire/simulated/sensor.h"
#include "common/core/progress.h"
#include "common/files/rig.h"
#include "common/files/session.h"
#include "common/spectra/sampled_spectrum.h"

namespace dermap {

struct Shot {
  FrameRole target = FrameRole::kSkin;  // what lies at the place of the skin
  int slot = 1;
  double exposure_ms = 10.0;
  int iso = 100;
  int number = 1;  // everything that changes from shot to shot is drawn by it
};

class OpticalBench {
 public:
  // Renders the scene in every band; `progress` tells how far that is.
  OpticalBench(const RigConfig& rig, Scene scene, const ProgressFunction& progress = {});
  // With a patch that was rendered before, for the same scene content and filters.
  OpticalBench(const RigConfig& rig, Scene scene, PatchReflectance patch);

  Plane<std::uint16_t> Expose(const Shot& shot) const;

  // The truth, for tests and for truth/.
  const Scene& scene() const { return scene_; }
  const RigConfig& rig() const { return rig_; }
  const PatchReflectance& patch() const { return patch_; }
  const PinholeView& view() const { return view_; }
  const Sensor& sensor() const { return sensor_; }
  double FlashFactor(int shot_number) const;  // relative to the nominal flash; 0 where it misfires
  Pose PoseOfShot(const Shot& shot) const;    // only skin moves
  std::array<Point2, 4> CornersOfShot(const Shot& shot) const;
  // Expected electrons of every photosite, before the sensor's own patterns.
  PlaneF ExpectedElectrons(const Shot& shot) const;

 private:
  using ChannelValues = std::array<double, 3>;  // red, green, blue photosites
  struct BandLight {
    int band = 0;                          // index into patch_.bands
    std::vector<ChannelValues> electrons;  // from a perfect white diffuser, by filter node and channel
    ChannelValues white{}, spectralon{};   // summed over the nodes
  };
  const WheelSlot& SlotOf(const Shot& shot) const;
  BandLight LightOfBand(const WheelSlot& slot) const;
  // Electrons of each channel at full light: scene content of one target, before shading.
  std::array<PlaneF, 3> Content(const Shot& shot, const BandLight& light) const;
  void DrawSkin(const Shot& shot, const BandLight& light, std::array<PlaneF, 3>& content) const;
  void DrawGrayCard(const BandLight& light, std::array<PlaneF, 3>& content) const;

  RigConfig rig_;
  Scene scene_;
  PatchReflectance patch_;
  PinholeView view_;
  Sensor sensor_;
  SampledSpectrum flash_, spectralon_;
  std::array<SampledSpectrum, 3> camera_;
  PlaneF shading_;  // vignetting and the flash's unevenness
  PlaneF tape_;     // reflectance of the tape, a tile around the window
};

}  // namespace dermap
