// SPDX-License-Identifier: Apache-2.0
// One band's frames on the patch, with their noise.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "calibrate/band_frames.h"
#include "calibrate/resample.h"

namespace dermap {

// Gain and read noise of each ISO, from all bands together; says in `notes` where that is only a bound. Throws InputError
// where the gray card cannot be read.
std::map<int, NoiseModel> NoiseOfSession(const BlackFrames& blacks, const std::vector<BandFrames>& bands,
                                         std::vector<std::string>& notes);

struct PatchBand {
  PlaneF reflectance;  // NaN where nothing is usable
  PlaneF sigma;        // one standard deviation
};

// Mean of the band's skin frames, moved by its alignment. record.correlation must be there already.
PatchBand ResampleBand(const BandFrames& band, const std::map<int, NoiseModel>& models, int patch_px);

NoiseCorrelation CorrelationOfBand(const BandFrames& band, const std::map<int, NoiseModel>& models, int patch_px);

}  // namespace dermap
