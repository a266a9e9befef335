// SPDX-License-Identifier: Apache-2.0
// Unfinished fit folders.
#include "fit/resume.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <span>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/maps.h"
#include "fit/candidate.h"
#include "fit/options.h"
#include "fit/prepare.h"

namespace dermap {
namespace {

std::string Text(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

std::string DataOf(const ReflectanceStack& stack) {
  std::vector<float> values;
  const auto add = [&](const PlaneF& plane) {
    values.insert(values.end(), plane.values().begin(), plane.values().end());
  };
  for (const PlaneF& plane : stack.reflectance) add(plane);
  for (const PlaneF& plane : stack.sigma) add(plane);
  for (const auto valid : stack.valid.values()) values.push_back(static_cast<float>(valid));
  return Sha256(std::as_bytes(std::span(values)));
}

std::string BandsOf(const ReflectanceStack& stack) {
  std::string text;
  for (const Band& band : stack.bands)
    text += (text.empty() ? "" : ", ") + Text(band.wavelength_nm) + " nm +- " + Text(band.fwhm_nm / 2.0);
  return text;
}

std::string TissueOf(const TissueConfig& tissue) {
  std::string text;
  for (const double value :
       {tissue.epidermis_thickness_mm, tissue.n_epidermis, tissue.n_dermis, tissue.n_outside,
        tissue.oxygenation_epidermis, tissue.oxygenation_dermis, tissue.junction_absorbance,
        tissue.scattering_amplitude, tissue.scattering_slope, tissue.anisotropy})
    text += (text.empty() ? "" : ", ") + Text(value);
  return text;
}

std::string PriorOf(const FitOptions& options) {
  if (!options.prior) return "none";
  std::vector<double> values(options.prior->mean.begin(), options.prior->mean.end());
  for (const ParameterMatrix* matrix : {&options.prior->covariance, &options.prior->detail_covariance})
    for (const ParameterVector& row : *matrix) values.insert(values.end(), row.begin(), row.end());
  return std::to_string(options.prior->fits()) + " fits, " + Sha256(std::as_bytes(std::span(values)));
}

const nlohmann::json& Entry(const nlohmann::json& json, const char* key, const std::string& file) {
  const auto found = json.find(key);
  if (found == json.end())
    throw InputError(file + " has no '" + key + "', which --resume needs; remedy: fit anew without --resume");
  return *found;
}

}  // namespace

SettingList SettingsOf(const ReflectanceStack& stack, const FitOptions& options) {
  const std::optional<double> pixel = options.pixel_size_mm ? options.pixel_size_mm : stack.pixel_size_mm;
  return {
      {"data", DataOf(stack)},
      {"bands", BandsOf(stack)},
      {"pixel_size_mm", pixel ? Text(*pixel) : "unknown"},
      {"method", std::string(NameOf(options.method))},
      {"metric", std::string(NameOf(options.metric))},
      {"profiles", options.profiles},
      {"engine", std::string(EngineName(options.forward.engine))},
      {"beneath_tape", std::string(NameOf(options.forward.beneath_tape))},
      {"tolerance", Text(options.tolerance)},
      {"shared_error", Text(SharedErrorOf(stack, options))},
      {"free", options.free_parameters.empty() ? "auto" : NamesOf(options.free_parameters)},
      {"tissue", TissueOf(options.tissue)},
      {"prior", PriorOf(options)},
  };
}

UnfinishedFit ReadUnfinishedFit(const std::filesystem::path& directory) {
  const std::string file = (directory / "fit.json").string();
  const nlohmann::json json = nlohmann::json::parse(ReadTextFile(file), nullptr, false);
  if (!json.is_object()) throw InputError(file + " is not valid JSON; remedy: fit anew without --resume");
  UnfinishedFit fit;
  fit.directory = directory;
  try {
    if (Entry(json, "finished", file).get<bool>())
      throw InputError(file +
                       " is of a fit that is finished, so there is nothing to go on with; remedy: leave "
                       "out --resume to fit anew");
    for (const auto& [key, value] : Entry(json, "settings", file).items())
      fit.settings.emplace_back(key, value.get<std::string>());
    fit.seconds = Entry(json, "seconds", file).get<double>();
    fit.renders = Entry(json, "renders", file).get<int>();
  } catch (const nlohmann::json::exception&) {
    throw InputError(file +
                     " is damaged: finished, settings, seconds or renders is not what a fit writes; "
                     "remedy: fit anew without --resume");
  }
  fit.maps = ReadMaps(directory / "maps.exr").maps;
  return fit;
}

int SizeToResume(const UnfinishedFit& before, const FitOptions& options, int longer) {
  const int size = std::max(before.maps.width(), before.maps.height());
  const int asked = options.size > 0 ? std::min(options.size, longer) : size;
  if (size != asked || size > longer)
    throw InputError("The fit in " + before.directory.string() + " has maps of " + std::to_string(size) +
                     " pixels along the longer side, but " + std::to_string(std::min(asked, longer)) +
                     " are asked for; remedy: leave out --size, or --resume");
  return size;
}

void CheckSameSettings(const UnfinishedFit& before, const SettingList& now) {
  for (const auto& [key, value] : now) {
    std::string old = "missing";
    for (const auto& [old_key, old_value] : before.settings)
      if (old_key == key) old = old_value;
    if (old == value) continue;
    throw InputError(
        "The fit in " + before.directory.string() + " cannot be resumed: its " + key +
        (key == "data" ? " are not those of this stack" : " was '" + old + "', but is '" + value + "' now") +
        "; remedy: the same stack and flags as before, or fit anew without --resume");
  }
}

}  // namespace dermap
