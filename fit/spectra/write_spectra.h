// SPDX-License-Identifier: Apache-2.0
// What a fit of spectra leaves on disk: spectra.csv, spectra.json and a page for people.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "fit/spectra/fit_spectra.h"

namespace dermap {

// Writes the three files into `folder`; in a FileBatch all or none. `name` is the input's.
void WriteSpectra(const std::filesystem::path& folder, const SpectraFit& fit, const std::string& name);

std::string SpectraCsv(const SpectraFit& fit);
// `with_spectra`: the measured, predicted and residual spectrum and every candidate of each row.
nlohmann::ordered_json SpectraJson(const SpectraFit& fit, bool with_spectra);
std::string SpectraReport(const SpectraFit& fit, const std::string& name);

}  // namespace dermap
