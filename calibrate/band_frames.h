// SPDX-License-Identifier: Apache-2.0
// All frames of one band, read, checked and brought together: what is resampled afterwards.
#pragma once

#include <vector>

#include "calibrate/calibrate.h"
#include "calibrate/gray_card.h"
#include "calibrate/linearity.h"
#include "calibrate/mosaic.h"
#include "calibrate/noise_model.h"

namespace dermap {

// What every band's preparation reads.
struct SessionContext {
  const Session& session;
  const FrameReader& read;
  const BlackFrames& blacks;
  PixelRegion gray_card;
  StepSet skip;  // steps that are left out
  Linearity linearity;
};

// One skin frame beside the band's Spectralon frame, cut to the window's surroundings.
struct SkinMosaic {
  Mosaic mosaic;
  int skin_iso = 0;
  int spectralon_iso = 0;
  int spectralon_frames = 1;
  double shared_black = 0.0;  // as in MosaicNoise
  double skin_black = 0.0;
  double spectralon_black = 0.0;
  GrayCardRatio card;
};

struct BandFrames {
  BandCalibration record;
  std::vector<SkinMosaic> skins;             // one a skin frame; record.windows in the same order
  std::vector<PhotonTransferPoint> pairs;    // from skin and Spectralon frames of one ISO
  std::vector<PhotonTransferPoint> singles;  // from frames without a partner of their ISO
};

// The bands of which there are skin frames, ascending. Throws InputError where there are none.
std::vector<Band> BandsOfSession(const Session& session);

// Throws InputError naming the frame or the band (CaptureFailure where there is something to be seen): no
// Spectralon frame, a flash that did not fire, swapped frames, no window.
// `certificate`: the panel's reflectance in this band and its relative uncertainty.
BandFrames PrepareBand(const SessionContext& context, const Band& band, const Known& certificate);

}  // namespace dermap
