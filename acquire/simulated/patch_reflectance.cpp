// SPDX-License-Identifier: Apache-2.0
// Rendering the patch, node by node.
#include "acquire/simulated/patch_reflectance.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "common/core/error.h"
#include "common/files/stack.h"
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

// A plane of any size on the patch's grid, linearly between the middles of its pixels.
PlaneF Interpolated(const PlaneF& plane) {
  PlaneF patch(kPatchSize_px, kPatchSize_px);
  const double scale_x = static_cast<double>(plane.width()) / kPatchSize_px;
  const double scale_y = static_cast<double>(plane.height()) / kPatchSize_px;
  for (int y = 0; y < kPatchSize_px; ++y) {
    const double v = std::clamp((y + 0.5) * scale_y - 0.5, 0.0, plane.height() - 1.0);
    const int y0 = std::min(static_cast<int>(v), std::max(0, plane.height() - 2)),
              y1 = std::min(y0 + 1, plane.height() - 1);
    for (int x = 0; x < kPatchSize_px; ++x) {
      const double u = std::clamp((x + 0.5) * scale_x - 0.5, 0.0, plane.width() - 1.0);
      const int x0 = std::min(static_cast<int>(u), std::max(0, plane.width() - 2)),
                x1 = std::min(x0 + 1, plane.width() - 1);
      const double upper = plane(x0, y0) + (u - x0) * (plane(x1, y0) - plane(x0, y0));
      const double lower = plane(x0, y1) + (u - x0) * (plane(x1, y1) - plane(x0, y1));
      patch(x, y) = static_cast<float>(upper + (v - y0) * (lower - upper));
    }
  }
  return patch;
}

// Means of the patch's pixels in width x height cells.
PlaneF CellMeans(const PlaneF& patch, int width, int height) {
  PlaneF means(width, height);
  const int across = kPatchSize_px / width, down = kPatchSize_px / height;
  for (int y = 0; y < kPatchSize_px; ++y)
    for (int x = 0; x < kPatchSize_px; ++x)
      means(x / across, y / down) += patch(x, y) / static_cast<float>(across * down);
  return means;
}

// Smooth, and such that what falls on each pixel of the plane is what the plane says: interpolation alone
// would blur it, and skin that was known would no longer be what reflects this light.
PlaneF OnPatch(const PlaneF& plane) {
  constexpr int kCorrections = 40;  // the slowest, a checkerboard, shrinks by a quarter each time
  if (kPatchSize_px % plane.width() != 0 || kPatchSize_px % plane.height() != 0) return Interpolated(plane);
  PlaneF nodes = plane;
  for (int i = 0; i < kCorrections; ++i) {
    const PlaneF means = CellMeans(Interpolated(nodes), plane.width(), plane.height());
    for (std::size_t k = 0; k < nodes.size(); ++k) nodes.data()[k] += plane.data()[k] - means.data()[k];
  }
  return Interpolated(nodes);
}

// The scene's own stack, band by band, as a reflectance factor of the rig's geometry.
void TakeFromStack(const Scene& scene, PatchReflectance& patch) {
  const ReflectanceStack stack = ReadReflectanceStack(scene.reflectance);
  const double factor =
      ExitAngleFactor(patch.conditions.geometry, scene.tissue.n_outside, scene.tissue.n_epidermis) /
      ExitAngleFactor(stack.geometry, scene.tissue.n_outside, scene.tissue.n_epidermis);
  for (const Band& band : patch.bands) {
    const auto found = std::find_if(stack.bands.begin(), stack.bands.end(), [&](const Band& b) {
      return std::abs(b.wavelength_nm - band.wavelength_nm) < 0.5;
    });
    if (found == stack.bands.end())
      throw InputError(scene.reflectance.string() + " has no band at " + std::to_string(band.wavelength_nm) +
                       " nm, which the rig has; make it for the rig's bands.");
    PlaneF plane = OnPatch(stack.reflectance[found - stack.bands.begin()]);
    for (float& value : plane.values()) value = static_cast<float>(value * factor);
    patch.nodes.emplace_back(FilterNodes(band).size(), plane);
  }
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
  if (!scene.reflectance.empty()) {
    TakeFromStack(scene, patch);
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
