// SPDX-License-Identifier: Apache-2.0
// Frames of one session as signals above black, in DN: black subtraction, and the photosites that must not be
// used.
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
  double white_level = 0.0;
};

// Mean of all black frames of one exposure and ISO.
struct BlackReference {
  double exposure_ms = 0.0;
  int iso = 0;
  int frames = 0;
  PlaneF mean;                     // DN
  double temporal_variance = 0.0;  // of one frame, DN^2, from frame to frame; NaN with one frame
};

// All black frames of a session. Throws InputError where there is none, or where their shapes differ.
class BlackFrames {
 public:
  BlackFrames(const Session& session, const FrameReader& read);

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

 private:
  void Add(const FrameRecord& record, const BayerFrame& frame);
  void FindHotPhotosites();
  void FindTemporalVariance();

  SensorFormat sensor_;
  std::vector<BlackReference> levels_;
  std::vector<PlaneF> squares_;  // a level each: sum of squared deviations from the mean
  MaskPlane hot_;
};

// One exposed frame above black.
struct SignalFrame {
  FrameRecord record;
  const BlackReference* black = nullptr;
  PlaneF signal;   // DN above black
  MaskPlane mask;  // saturated (with the nearest photosites of its colour, where noise is clipped) and hot
  double saturated_share = 0.0;
  std::vector<std::string> notes;
};

// Reads, checks against the sensor and subtracts black. Throws InputError naming the frame.
SignalFrame ReadSignal(const FrameRecord& record, const FrameReader& read, const BlackFrames& blacks);

// Adds kPhotositeDead to `mask` wherever a frame of an even target answers unlike the photosites of its kind
// around.
void MarkDead(const PlaneF& spectralon, MaskPlane& mask);

}  // namespace dermap
