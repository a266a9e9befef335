// SPDX-License-Identifier: Apache-2.0
// Rendering the patch, node by node.
#include "acquire/simulated/patch_reflectance.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "common/core/error.h"
#include "common/transport/band_optics.h"

namespace dermap {
namespace {

// Renders one band at the wavelengths of its filter, each of them a band without width.
std::vector<PlaneF> RenderNodes(const Scene& scene, const Band& band, const ImagingConditions& conditions,
                                const Chromophores& chromophores, const ProfileSource& source) {
  std::vector<Band> lines;
  for (const FilterNode& node : FilterNodes(band)) lines.push_back({node.wavelength_nm, 0.0});
  const ForwardModel model(chromophores, source, scene.tissue, lines, conditions, ForwardOptions{});
  return model.Render(scene.maps);
}

}  // namespace

std::vector<PlaneF> PatchReflectance::Mean() const {
  std::vector<PlaneF> mean;
  for (std::size_t b = 0; b < bands.size(); ++b) {
    const auto filter = FilterNodes(bands[b]);
    PlaneF plane(nodes[b][0].width(), nodes[b][0].height());
    for (std::size_t n = 0; n < filter.size(); ++n) {
      const auto source = nodes[b][n].values();
      for (std::size_t i = 0; i < source.size(); ++i) {
        plane.values()[i] += static_cast<float>(filter[n].weight) * source[i];
      }
    }
    mean.push_back(std::move(plane));
  }
  return mean;
}

std::vector<Band> BandsOfRig(const RigConfig& rig) {
  std::vector<Band> bands;
  for (const WheelSlot& slot : rig.slots) {
    if (!slot.opaque) bands.push_back({slot.wavelength_nm, slot.fwhm_nm});
  }
  std::sort(bands.begin(), bands.end(),
            [](const Band& a, const Band& b) { return a.wavelength_nm < b.wavelength_nm; });
  return bands;
}

ImagingConditions ConditionsOfRig(const RigConfig& rig) {
  return {rig.window_mm / kPatchSize_px, Illumination::kWindow, Tape::kFree, Geometry::kFactor0_30};
}

PatchReflectance RenderPatch(const Scene& scene, const RigConfig& rig, const ProgressFunction& progress) {
  PatchReflectance patch;
  patch.bands = BandsOfRig(rig);
  patch.conditions = ConditionsOfRig(rig);
  if (patch.bands.empty())
    throw InputError("Rig \"" + rig.name + "\" has no filter; at least one slot must not be opaque.");
  if (scene.pattern) {
    const PlaneF plane = RenderPattern(*scene.pattern, rig.window_mm);
    for (const Band& band : patch.bands) patch.nodes.emplace_back(FilterNodes(band).size(), plane);
    return patch;
  }
  const Chromophores chromophores(ConfigDirectory() / "spectra");
  const auto source = MakeProfileSource(scene.profiles);
  for (const Band& band : patch.bands) {
    patch.nodes.push_back(RenderNodes(scene, band, patch.conditions, chromophores, *source));
    if (progress) progress(static_cast<double>(patch.nodes.size()) / static_cast<double>(patch.bands.size()));
  }
  return patch;
}

}  // namespace dermap
