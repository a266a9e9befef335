// SPDX-License-Identifier: Apache-2.0
// The results of a fit of spectra as a table and as JSON.
#include "fit/spectra/write_spectra.h"

#include <spdlog/fmt/fmt.h>

#include <nlohmann/json.hpp>

#include "common/files/atomic_file.h"
#include "common/files/csv_table.h"

namespace dermap {
namespace {

std::string Names(const std::vector<SkinParameter>& parameters) {
  std::string names;
  for (const SkinParameter p : parameters) {
    names += fmt::format("{}{}", names.empty() ? "" : " ", InfoOf(p).name);
  }
  return names;
}

nlohmann::ordered_json ModelJson(const ModelFit& fit) {
  nlohmann::ordered_json json{{"model", fit.model.name},
                              {"rms", fit.rms},
                              {"bic", fit.bic},
                              {"discrepancy", fit.discrepancy},
                              {"converged", fit.converged}};
  for (int i = 0; i < kSkinParameterCount; ++i) {
    json["parameters"][std::string(kSkinParameters[i].name)] = {{"value", fit.skin[i]},
                                                                {"sigma", fit.sigma[i]}};
  }
  for (const SkinParameter p : fit.model.free) json["free"].push_back(InfoOf(p).name);
  json["at_bound"] = nlohmann::ordered_json::array();
  for (const SkinParameter p : fit.at_bound) json["at_bound"].push_back(InfoOf(p).name);
  json["not_identifiable"] = nlohmann::ordered_json::array();
  for (const SkinParameter p : fit.not_identifiable) json["not_identifiable"].push_back(InfoOf(p).name);
  return json;
}

nlohmann::ordered_json SpectrumJson(const SpectraFit& fit, std::size_t i) {
  const MeasuredSpectra::Row& row = fit.spectra.rows[i];
  nlohmann::ordered_json json;
  for (std::size_t k = 0; k < row.labels.size(); ++k)
    json["labels"][fit.spectra.label_names[k]] = row.labels[k];
  json["chosen"] = ModelJson(fit.fits[i].best());
  json["effective_count"] = fit.fits[i].effective_count;
  for (const ModelFit& candidate : fit.fits[i].candidates) json["candidates"].push_back(ModelJson(candidate));
  json["measured"] = row.reflectance;
  json["predicted"] = fit.fits[i].best().predicted;
  return json;
}

}  // namespace

std::string SpectraCsv(const SpectraFit& fit) {
  std::string text;
  for (const std::string& name : fit.spectra.label_names) text += CsvField(name) + ',';
  text += "model,rms,bic,converged,at_bound,not_identifiable";
  for (const SkinParameterInfo& info : kSkinParameters)
    text += fmt::format(",{},sigma_{}", info.name, info.name);
  text += '\n';
  for (std::size_t i = 0; i < fit.fits.size(); ++i) {
    const ModelFit& best = fit.fits[i].best();
    for (const std::string& label : fit.spectra.rows[i].labels) text += CsvField(label) + ',';
    text += fmt::format("{},{:.6g},{:.6g},{},{},{}", best.model.name, best.rms, best.bic,
                        best.converged ? 1 : 0, Names(best.at_bound), Names(best.not_identifiable));
    for (int p = 0; p < kSkinParameterCount; ++p)
      text += fmt::format(",{:.6g},{:.6g}", best.skin[p], best.sigma[p]);
    text += '\n';
  }
  return text;
}

nlohmann::ordered_json SpectraJson(const SpectraFit& fit, bool with_spectra) {
  const SpectraOptions& options = fit.options;
  nlohmann::ordered_json json{
      {"count", fit.fits.size()},
      {"median_rms", fit.MedianRms()},
      {"converged", fit.Converged()},
      {"seconds", fit.seconds},
      {"wavelengths_nm", fit.spectra.wavelengths_nm},
      {"mean_residual", fit.MeanResidual()},
      {"instrument",
       {{"fwhm_nm", options.instrument.fwhm_nm},
        {"measured_diameter_mm", 2.0 * options.instrument.aperture.measured_radius_mm},
        {"illuminated_diameter_mm", 2.0 * options.instrument.aperture.illuminated_radius_mm},
        {"specular_included", options.instrument.specular_included},
        {"noise_absolute", options.noise.absolute},
        {"noise_relative", options.noise.relative}}},
      {"tissue",
       {{"n_epidermis", options.tissue.n_epidermis},
        {"n_dermis", options.tissue.n_dermis},
        {"anisotropy", options.tissue.anisotropy},
        {"junction_absorbance", options.tissue.junction_absorbance}}}};
  const std::vector<int> counts = fit.ChosenCounts();
  const auto rms = fit.RmsByModel();
  const std::vector<SkinModel> models = SkinModels(fit.options.tissue);
  for (std::size_t i = 0; i < models.size(); ++i) {
    if (rms[i].empty()) continue;
    nlohmann::ordered_json model{{"model", models[i].name},
                                 {"description", models[i].description},
                                 {"chosen", counts[i]},
                                 {"median_rms", MedianOf(rms[i])}};
    for (const SkinParameter p : models[i].free) model["free"].push_back(InfoOf(p).name);
    json["models"].push_back(std::move(model));
  }
  for (std::size_t i = 0; with_spectra && i < fit.fits.size(); ++i)
    json["spectra"].push_back(SpectrumJson(fit, i));
  return json;
}

void WriteSpectra(const std::filesystem::path& folder, const SpectraFit& fit, const std::string& name) {
  WriteFileAtomically(folder / "spectra.csv", std::string_view(SpectraCsv(fit)));
  WriteFileAtomically(
      folder / "spectra.json",
      std::string_view(SpectraJson(fit, true).dump(1, ' ', false, nlohmann::json::error_handler_t::replace) +
                       "\n"));
  WriteFileAtomically(folder / "report.html", std::string_view(SpectraReport(fit, name)));
}

}  // namespace dermap
