// SPDX-License-Identifier: Apache-2.0
// What the patch reflects through each filter: the scene's maps through the shared forward model, at several
// wavelengths of every filter, since the red, green and blue photosites weigh a filter's band differently.
#pragma once

#include <vector>

#include "acquire/simulated/scene.h"
#include "common/core/progress.h"
#include "common/files/rig.h"
#include "common/transport/conditions.h"

namespace dermap {

struct PatchReflectance {
  std::vector<Band> bands;                 // the filters, by ascending wavelength
  std::vector<std::vector<PlaneF>> nodes;  // for each band, at the FilterNodes of common/transport
  std::vector<PlaneF> Mean() const;        // through the filters: weighted by their curves, as the truth is
  ImagingConditions conditions;
};

// The bands of a rig: its filters, by ascending wavelength.
std::vector<Band> BandsOfRig(const RigConfig& rig);
// Conditions under which the rig's reflectance is meant: lit through the window, seen at 30 degrees.
ImagingConditions ConditionsOfRig(const RigConfig& rig);

PatchReflectance RenderPatch(const Scene& scene, const RigConfig& rig, const ProgressFunction& progress = {});

}  // namespace dermap
