// SPDX-License-Identifier: Apache-2.0
// What the steps of the radiometry do to one band, each with its record.
#pragma once

#include "calibrate/band_frames.h"
#include "calibrate/stray_light.h"

namespace dermap {

// Means of the window's middle, for what the steps did.
struct MiddleMeans {
  double skin = 0.0, spectralon = 0.0;
  double skin_square = 0.0,
         spectralon_square = 0.0;  // weighted by the signals themselves: Spectralon's strong ones
};

MiddleMeans MeansOf(const Mosaic& mosaic);

// What the black frames and the mask of hot photosites did.
void AddFrameSteps(const SessionContext& context, const SignalFrame& skin, const MiddleMeans& means,
                   BandCalibration& record);
// Stray light off the mosaic; the gray card's ratio without it.
double CorrectStrayLight(const SessionContext& context, const Window& window, const FrameMeans& frames,
                         double certificate, const MiddleMeans& means, SkinMosaic& skin,
                         BandCalibration& record);
// The scale that makes the mosaic's ratio a reflectance: drift, certificate, polarization.
void SetScale(const SessionContext& context, double card_ratio, const Known& certificate, SkinMosaic& skin,
              BandCalibration& record);

}  // namespace dermap
