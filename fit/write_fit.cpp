// SPDX-License-Identifier: Apache-2.0
// Writing the fit folder.
#include "fit/write_fit.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "common/files/atomic_file.h"
#include "common/files/choice_record.h"
#include "common/files/maps.h"
#include "common/files/stack.h"

namespace dermap {
namespace {

MapsFile MapsOf(const FitResult& result) {
  MapsFile file;
  file.maps = result.maps;
  file.bands = result.bands;
  file.pixel_size_mm = result.conditions.pixel_size_mm;
  file.illumination = result.conditions.illumination;
  file.tape = result.conditions.tape;
  file.geometry = result.conditions.geometry;
  return file;
}

NamedPlanes SigmaPlanes(const FitResult& result) {
  NamedPlanes planes;
  for (int i = 0; i < kParameterCount; ++i)
    planes.emplace_back(std::string(kParameters[i].name), result.sigma.planes[i]);
  for (const PlaneF& plane : result.sigma.junction_absorbance)
    planes.emplace_back(std::string(kJunctionInfo.name), plane);
  return planes;
}

NamedPlanes FlagPlanes(const FitResult& result) {
  PlaneF bits(result.flags.width(), result.flags.height());
  for (std::size_t i = 0; i < bits.size(); ++i) bits.data()[i] = static_cast<float>(result.flags.data()[i]);
  return {{"flags", std::move(bits)}};
}

ReflectanceStack StackOf(const FitResult& result, const std::vector<PlaneF>& planes) {
  ReflectanceStack stack;
  stack.bands = result.bands;
  stack.reflectance = planes;
  stack.pixel_size_mm = result.conditions.pixel_size_mm;
  stack.illumination = result.conditions.illumination;
  stack.tape = result.conditions.tape;
  stack.geometry = result.conditions.geometry;
  return stack;
}

std::vector<std::string> NamesIn(const std::vector<Parameter>& parameters) {
  std::vector<std::string> names;
  for (const Parameter p : parameters) names.emplace_back(InfoOf(p).name);
  return names;
}

}  // namespace

nlohmann::ordered_json FitRecord(const FitResult& result) {
  nlohmann::ordered_json json;
  json["rms_residual"] = result.rms_residual;
  json["rms_residual_per_band"] = result.rms_residual_per_band;
  json["chi2"] = result.chi2;
  json["chi2_per_datum"] = result.chi2_per_datum;
  json["degrees_of_freedom"] = result.degrees_of_freedom;
  json["data_count"] = result.data_count;
  json["seconds"] = result.seconds;
  json["renders"] = result.renders;
  json["converged"] = result.converged;
  json["unexplained_share"] = result.unexplained_share;
  json["finished"] = result.finished;
  json["method"] = result.method;
  json["profiles"] = result.profiles;
  json["engine"] = result.engine;
  json["width"] = result.maps.width();
  json["height"] = result.maps.height();
  json["pixel_size_mm"] = result.conditions.pixel_size_mm;
  for (const Band& band : result.bands) {
    json["wavelengths_nm"].push_back(band.wavelength_nm);
    json["fwhm_nm"].push_back(band.fwhm_nm);
  }
  json["free_parameters"] = nlohmann::ordered_json::array();
  for (Parameter p : result.free_parameters) json["free_parameters"].push_back(std::string(InfoOf(p).name));
  json["candidates"] = nlohmann::ordered_json::array();
  for (const Candidate& candidate : result.candidates)
    json["candidates"].push_back({{"free", NamesIn(candidate.free)},
                                  {"absent", NamesIn(candidate.absent)},
                                  {"log_evidence", candidate.log_evidence}});
  json["decisions"] = result.decisions;
  json["settings"] = nlohmann::ordered_json::object();
  for (const auto& [key, value] : result.settings) json["settings"][key] = value;
  json["tolerance"] = result.tolerance;
  json["forward"] = ChoiceRecord(result.forward, result.bands);
  json["history"] = nlohmann::ordered_json::array();
  for (const FitIteration& step : result.history)
    json["history"].push_back({{"iteration", step.iteration},
                               {"renders", step.renders},
                               {"seconds", step.seconds},
                               {"rms_residual", step.rms_residual},
                               {"chi2", step.chi2}});
  return json;
}

void WriteFit(const std::filesystem::path& directory, const FitResult& result) {
  WriteMaps(directory / "maps.exr", MapsOf(result));
  WritePlanes(directory / "sigma.exr", SigmaPlanes(result), result.conditions.pixel_size_mm);
  WriteReflectanceStack(directory / "predicted.exr", StackOf(result, result.predicted));
  WriteReflectanceStack(directory / "residual.exr", StackOf(result, result.residual));
  WritePlanes(directory / "flags.exr", FlagPlanes(result), result.conditions.pixel_size_mm);
  WriteFileAtomically(directory / "fit.json", FitRecord(result).dump(2) + "\n");
}

}  // namespace dermap
