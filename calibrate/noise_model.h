// SPDX-License-Identifier: Apache-2.0
// Shot and read noise of a photosite, estimated from the session itself by photon transfer. All in DN.
//
// The gray card stands still, so the difference of two frames of it, D = a - k b (k makes their means equal),
// contains neither its texture, nor uneven light, nor fixed offsets, only noise:
//   var D = gain (mean a + k^2 mean b) + read variance (1 + k^2).
// Every colour of every frame pair gives one such equation; a weighted line through them gives gain and read
// variance.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "calibrate/frames.h"
#include "calibrate/gray_card.h"

namespace dermap {

struct NoiseModel {
  double gain = 0.0;           // DN per electron
  double read_variance = 0.0;  // DN^2, rounding included
  int points = 0;              // photon transfer points that it rests on
  double Variance(double signal_dn) const {
    return gain * (signal_dn > 0.0 ? signal_dn : 0.0) + read_variance;
  }
};

struct PhotonTransferPoint {
  int iso = 0;
  double signal = 0.0;  // mean a + k^2 mean b, DN
  double reads = 0.0;   // 1 + k^2
  double variance = 0.0;
  int samples = 0;
};

// One point a kind of photosite (of the filter pattern) from the gray card of two frames of one ISO, the
// second the mean of `frames_b`.
std::vector<PhotonTransferPoint> PhotonTransfer(const SignalFrame& a, const SignalFrame& b, int frames_b,
                                                const PixelRegion& card);
// The same from one frame alone, its card's texture counted as noise: an upper bound, where no second frame
// exists.
std::vector<PhotonTransferPoint> PhotonTransferOfOne(const SignalFrame& frame, const PixelRegion& card);
// Black frames of known scatter pin the read noise.
std::vector<PhotonTransferPoint> PhotonTransferOfBlack(const BlackFrames& blacks);

// One model an ISO. Throws InputError where the points do not make a line with a positive slope.
std::map<int, NoiseModel> FitNoise(const std::vector<PhotonTransferPoint>& points);

}  // namespace dermap
