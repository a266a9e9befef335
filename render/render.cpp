// SPDX-License-Identifier: Apache-2.0
// From maps and options to a spectral picture.
#include "render/render.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "common/core/error.h"
#include "common/files/picture.h"
#include "render/edit.h"
#include "render/relight.h"

namespace dermap {
namespace {

// [D08 7]: "within 1% pixel error of 151 samples spaced every 2nm".
constexpr std::array<double, 8> kPaperWavelengths_nm{400, 435, 470, 505, 540, 575, 610, 645};

std::vector<Band> ChooseBands(const MapsFile& file, const RenderOptions& options,
                              std::vector<std::string>& notes) {
  std::vector<double> wavelengths_nm = options.wavelengths_nm;
  if (wavelengths_nm.empty()) {
    if (!file.bands.empty()) return file.bands;
    wavelengths_nm.assign(kPaperWavelengths_nm.begin(), kPaperWavelengths_nm.end());
    notes.emplace_back(
        "The maps name no bands; the eight wavelengths of [D08 7], 400 to 645 nm, were rendered.");
  }
  std::sort(wavelengths_nm.begin(), wavelengths_nm.end());
  const auto twice = std::adjacent_find(wavelengths_nm.begin(), wavelengths_nm.end());
  if (twice != wavelengths_nm.end()) {
    throw InputError(fmt::format("The wavelength {:g} nm is asked for twice; name each one once.", *twice));
  }
  std::vector<Band> bands;
  for (const double wavelength_nm : wavelengths_nm) bands.push_back({wavelength_nm, 0.0});
  return bands;
}

// Planes that the forward model can take: all there, finite, within the bounds.
void CheckPlane(PlaneF& plane, std::string_view name, double lower, double upper, const ParameterMaps& maps,
                std::vector<std::string>& notes) {
  if (plane.empty() || !plane.SameShape(maps.width(), maps.height())) {
    throw InputError(
        fmt::format("The map {} is {} x {} pixels, the others {} x {}; all must have the same size.", name,
                    plane.width(), plane.height(), maps.width(), maps.height()));
  }
  std::size_t clamped = 0;
  for (float& value : plane.values()) {
    if (!std::isfinite(value)) {
      throw InputError(fmt::format(
          "The map {} holds a pixel that is no finite number; fill such pixels before a render.", name));
    }
    const double kept = std::clamp<double>(value, lower, upper);
    clamped += std::abs(kept - value) > 1e-6 * upper;  // a float's rounding is no news
    value = static_cast<float>(kept);
  }
  if (clamped > 0) {
    notes.push_back(fmt::format("{} of {} pixels of {} lay outside {:g} to {:g} and were clamped.", clamped,
                                plane.size(), name, lower, upper));
  }
}

void CheckMaps(ParameterMaps& maps, std::vector<std::string>& notes) {
  for (int i = 0; i < kParameterCount; ++i) {
    const ParameterInfo& info = kParameters[static_cast<std::size_t>(i)];
    CheckPlane(maps.planes[static_cast<std::size_t>(i)], info.name, info.lower, info.upper, maps, notes);
  }
  for (PlaneF& plane : maps.junction_absorbance) {
    CheckPlane(plane, kJunctionName, 0.0, kMaxJunctionAbsorbance, maps, notes);
  }
}

// Inks have one absorbance a band of the fit; for other bands they are joined linearly, constant beyond the
// ends.
void ResampleJunction(ParameterMaps& maps, const std::vector<Band>& from, const std::vector<Band>& to,
                      std::vector<std::string>& notes) {
  auto& junction = maps.junction_absorbance;
  if (junction.size() <= 1) return;
  if (junction.size() != from.size()) {
    throw InputError(
        fmt::format("The maps hold {} planes of {} for {} bands; one, or one a band, is expected.",
                    junction.size(), kJunctionName, from.size()));
  }
  std::vector<PlaneF> result;
  bool beyond = false;
  for (const Band& band : to) {
    const auto above = std::lower_bound(from.begin(), from.end(), band.wavelength_nm,
                                        [](const Band& b, double nm) { return b.wavelength_nm < nm; });
    const std::size_t right = std::min<std::size_t>(above - from.begin(), from.size() - 1);
    const std::size_t left = above == from.begin() || above == from.end() ? right : right - 1;
    beyond =
        beyond || above == from.end() || (above == from.begin() && band.wavelength_nm < above->wavelength_nm);
    PlaneF plane = junction[left];
    if (left != right) {
      const double share = (band.wavelength_nm - from[left].wavelength_nm) /
                           (from[right].wavelength_nm - from[left].wavelength_nm);
      for (std::size_t i = 0; i < plane.size(); ++i) {
        plane.data()[i] += static_cast<float>(share) * (junction[right].data()[i] - plane.data()[i]);
      }
    }
    result.push_back(std::move(plane));
  }
  if (beyond) {
    notes.emplace_back("Beyond the bands of the fit the junction's absorbance is that of the nearest band.");
  }
  junction = std::move(result);
}

ImagingConditions ChooseConditions(const MapsFile& file, const RenderOptions& options) {
  ImagingConditions conditions;
  conditions.pixel_size_mm = options.pixel_size_mm.value_or(file.pixel_size_mm.value_or(0.0));
  if (!(conditions.pixel_size_mm > 0.0) || !std::isfinite(conditions.pixel_size_mm)) {
    throw InputError("The maps do not say how large a pixel is; give --pixel-size-mm.");
  }
  conditions.illumination = file.illumination;
  conditions.tape = file.tape;
  conditions.geometry = file.geometry;
  return conditions;
}

std::string JoinedEdits(const std::vector<std::string>& edits) {
  std::string text;
  for (const std::string& edit : edits) text += (text.empty() ? "" : "; ") + edit;
  return text;
}

}  // namespace

RenderResult RenderMaps(const MapsFile& file, const RenderOptions& options, const Chromophores& chromophores,
                        const std::filesystem::path& spectra_dir, const ProgressFunction& progress) {
  RenderResult result;
  std::vector<MapEdit> edits;
  for (const std::string& edit : options.edits) edits.push_back(ParseEdit(edit));
  const auto source = MakeProfileSource(options.profiles);
  const std::vector<Band> bands = ChooseBands(file, options, result.notes);
  const ImagingConditions conditions = ChooseConditions(file, options);

  ParameterMaps maps = file.maps;
  CheckMaps(maps, result.notes);
  ResampleJunction(maps, file.bands, bands, result.notes);
  for (const MapEdit& edit : edits) {
    result.notes.push_back(ApplyEdit(maps, edit, options.tissue.junction_absorbance));
  }
  const LitPatch patch{maps.width(), maps.height(), conditions.pixel_size_mm};
  const LightPattern light = MakeLight(options.light, patch, bands);
  result.notes.insert(result.notes.end(), light.notes.begin(), light.notes.end());

  const ForwardModel model(chromophores, *source, options.tissue, bands, conditions, options.forward,
                           progress);
  const auto start = std::chrono::steady_clock::now();
  result.image.reflectance = model.Render(maps, light.planes, &result.forward);
  if (options.forward.engine != Engine::kLowRank) result.forward.clear();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  result.image.bands = bands;
  result.image.pixel_size_mm = conditions.pixel_size_mm;
  result.image.illumination = conditions.illumination;
  result.image.tape = conditions.tape;
  result.image.geometry = conditions.geometry;
  // A fit by the same tables, the default's, has no error of calibration or tables to fear.
  if (options.profiles == RenderOptions{}.profiles) result.image.shared_error = 0.0;
  result.image.notes = {{"light", light.description}, {"profiles", options.profiles}};
  if (!edits.empty()) result.image.notes["edits"] = JoinedEdits(options.edits);

  std::vector<double> wavelengths_nm;
  for (const Band& band : bands) wavelengths_nm.push_back(band.wavelength_nm);
  result.exposure = DisplayExposure(result.image.reflectance);
  result.colour =
      ColourObserver(spectra_dir).Picture(wavelengths_nm, result.image.reflectance, result.exposure);
  return result;
}

void WriteRender(const std::filesystem::path& path, const RenderResult& result) {
  WriteReflectanceStack(path, result.image);
  std::filesystem::path picture = path;
  WritePng(picture.replace_extension(".png"), result.colour);
}

}  // namespace dermap
