// SPDX-License-Identifier: Apache-2.0
// The candidates of model choice.
#include "fit/spectra/measured_skin.h"

#include <spdlog/fmt/fmt.h>

#include <string>
#include <utility>

#include "common/core/error.h"

namespace dermap {
namespace {

using enum SkinParameter;

double& At(SkinVector& skin, SkinParameter p) {
  return skin[static_cast<int>(p)];
}

// What is not free: no blood in the epidermis and no carotene, rather than average ones that nothing
// supports.
SkinVector Bare(const TissueConfig& tissue) {
  SkinVector skin{};
  for (int i = 0; i < kSkinParameterCount; ++i) skin[i] = kSkinParameters[i].mean;
  At(skin, kThickness) = tissue.epidermis_thickness_mm;
  At(skin, kOxygenation) = tissue.oxygenation_dermis;
  At(skin, kAmplitude) = tissue.scattering_amplitude;
  At(skin, kSlope) = tissue.scattering_slope;
  At(skin, kC_he) = 0.0;
  At(skin, kC_bc) = 0.0;
  return skin;
}

SkinVector Published() {
  SkinVector skin = Bare({});
  At(skin, kC_he) = InfoOf(kC_he).mean;
  At(skin, kC_bc) = InfoOf(kC_bc).mean;
  At(skin, kThickness) = 0.25;  // [D08 5.2]
  return skin;
}

}  // namespace

TissueConfig MeasuredTissue() {
  TissueConfig tissue;
  tissue.epidermis_thickness_mm = InfoOf(kThickness).mean;
  tissue.anisotropy = 0.8;
  return tissue;
}

std::vector<SkinModel> SkinModels(const TissueConfig& tissue) {
  const std::vector<SkinParameter> core{kC_m, kBeta_m, kC_hd, kOxygenation, kAmplitude};
  std::vector<SkinModel> models{
      {"published",
       "as published: five concentrations, 0.25 mm of epidermis",
       {kC_m, kBeta_m, kC_he, kC_bc, kC_hd},
       Published()},
      {"core", "thin epidermis; melanins, blood, oxygenation, amplitude of scattering", core, Bare(tissue)}};
  const auto add = [&](std::string_view name, std::string_view description,
                       std::initializer_list<SkinParameter> more) {
    SkinModel model{name, description, core, Bare(tissue)};
    model.free.insert(model.free.end(), more);
    models.push_back(std::move(model));
  };
  add("vessels", "core and the packing of blood in vessels", {kVesselRadius});
  add("capillaries", "core and blood near the surface", {kC_he});
  add("slope", "core and the slope of scattering", {kSlope});
  add("thickness", "core and the epidermis's thickness", {kThickness});
  add("vessels+capillaries", "vessels and blood near the surface", {kVesselRadius, kC_he});
  add("vessels+slope", "vessels and the slope of scattering", {kVesselRadius, kSlope});
  add("vessels+thickness", "vessels and the epidermis's thickness", {kVesselRadius, kThickness});
  add("vessels+carotene", "vessels and carotene", {kVesselRadius, kC_bc});
  add("vessels+baseline", "vessels and the tissue's own absorption", {kVesselRadius, kBaseline});
  add("vessels+surface", "vessels and light from the surface", {kVesselRadius, kSurface});
  add("capillaries+slope", "capillaries and the slope of scattering", {kC_he, kSlope});
  return models;
}

const std::vector<std::string_view>& SkinModelNames() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> all;
    for (const SkinModel& model : SkinModels({})) all.push_back(model.name);
    return all;
  }();
  return names;
}

SkinModel SkinModelFromName(std::string_view name, const TissueConfig& tissue) {
  std::string known;
  for (SkinModel& model : SkinModels(tissue)) {
    if (model.name == name) return std::move(model);
    known += fmt::format("{}{}", known.empty() ? "" : ", ", model.name);
  }
  throw InputError(
      fmt::format("There is no model '{}' of measured skin; expected auto or one of {}.", name, known));
}

}  // namespace dermap
