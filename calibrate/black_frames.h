// SPDX-License-Identifier: Apache-2.0
// What the sensor shows in darkness: means of a session's black frames, in DN, and hot photosites.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "calibrate/raw_frame.h"
#include "common/core/image.h"
#include "common/files/session.h"

namespace dermap {

// Of a frame's offset against its black frames', one standard deviation.
inline constexpr double kBlackDrift_dn = 0.1;

// Where frames come from: files of a session, or memory in tests.
using FrameReader = std::function<BayerFrame(const FrameRecord&)>;

// Why a photosite is not used, as bits.
enum PhotositeMask : std::uint8_t {
  kPhotositeSaturated = 1,
  kPhotositeHot = 2,   // far from its kind in a black frame
  kPhotositeDead = 4,  // responds to Spectralon unlike its neighbours
};
using MaskPlane = Plane<std::uint8_t>;

// What all frames of a session must have in common.
struct SensorFormat {
  int width = 0;
  int height = 0;
  std::array<char, kLatticeCount> colours{};
  int period = 2;
  double white_level = 0.0;
  double black_level = 0.0;  // as the first black frame's file states it
};

// Throws InputError naming the frame where it is of another camera or setting than the session's others.
void CheckSensor(const FrameRecord& record, const BayerFrame& frame, const SensorFormat& sensor);

// Mean of all black frames of one exposure and ISO, in steps of a fraction of a DN: half of the memory of
// floats, and finer than what rounding to whole DN leaves of it. What exceeds the range is hot in any case.
struct BlackReference {
  double exposure_ms = 0.0;
  int iso = 0;
  int frames = 0;
  Plane<std::uint16_t> mean_steps;
  float step_dn = 1.0f / 16.0f;
  double level_dn = 0.0;           // median
  double temporal_variance = 0.0;  // of one frame, DN^2, from frame to frame; NaN with one frame
};

// What is done to a frame's values on the way to a signal.
struct SignalOptions {
  bool subtract_black = true;  // else the level that the file itself states
  bool mask_hot = true;
  double nonlinearity = 0.0;  // light = signal (1 + nonlinearity signal / full scale)
};

// All black frames of a session. Throws InputError where there is none, or where their shapes differ.
class BlackFrames {
 public:
  BlackFrames(const Session& session, const FrameReader& read, const SignalOptions& options = {});

  struct Match {
    const BlackReference* level;
    std::string note;  // empty where exposure and ISO are the same
  };
  // The same exposure and ISO, else the same ISO and the nearest exposure, else the nearest ISO.
  Match Find(double exposure_ms, int iso) const;

  const SensorFormat& sensor() const { return sensor_; }
  const MaskPlane& hot() const { return hot_; }
  double hot_share() const;
  const std::vector<BlackReference>& levels() const { return levels_; }
  const SignalOptions& options() const { return options_; }
  // For the frames that are read from now on.
  void SetNonlinearity(double nonlinearity) { options_.nonlinearity = nonlinearity; }
  double FullScale(const BlackReference& level) const { return sensor_.white_level - level.level_dn; }

 private:
  void AddLevel(const Session& session, const FrameReader& read, double exposure_ms, int iso);
  // Marks them; returns the median of all photosites, DN.
  double FindHotPhotosites(const BlackReference& level);

  SensorFormat sensor_;
  SignalOptions options_;
  std::vector<BlackReference> levels_;
  MaskPlane hot_;
};

}  // namespace dermap
