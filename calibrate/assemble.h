// SPDX-License-Identifier: Apache-2.0
// Within this folder: the end of the stage, from resampled bands to the stack and its record.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "calibrate/band_frames.h"
#include "calibrate/calibrate.h"

namespace dermap {

inline constexpr double kSkinIndex = 1.4;  // of the epidermis

struct PatchBand {
  PlaneF reflectance;
  PlaneF sigma;
};

// The model of an ISO, or of the nearest one.
const NoiseModel& ModelOf(const std::map<int, NoiseModel>& models, int iso);

// A window of another size than the other bands' is another thing: that band is left out, by name.
void DropStrangeWindows(std::vector<BandFrames>& bands);
// So is a band whose place neither its window nor its structure tells.
void DropUnalignable(std::vector<BandFrames>& bands);
void NoteMissingBands(const Session& session, const std::vector<Band>& bands,
                      std::vector<std::string>& notes);
// What the noise of the gray card leaves open of the flash's drift.
void SetDriftUncertainty(const std::vector<SkinMosaic>& skins, const std::map<int, NoiseModel>& models,
                         BandCalibration& record);
// Throws InputError where no band is left.
void Assemble(std::vector<BandFrames>& bands, std::vector<PatchBand>& patches, const Session& session,
              const CalibrationOptions& options, CalibrationResult& result);

}  // namespace dermap
