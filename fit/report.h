// SPDX-License-Identifier: Apache-2.0
// The report of a fit for people: report.html, one file that opens anywhere without a network, and PNG
// previews.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/files/maps.h"
#include "fit/fit_result.h"

namespace dermap {

struct ReportInput {
  const FitResult& fit;
  std::string name;                                  // of the stack, for people
  std::filesystem::path spectra_dir;                 // config/spectra: colour matching functions
  const MapsFile* truth = nullptr;                   // simulated samples know it; any size
  std::optional<std::filesystem::path> calibration;  // the sidecar; see CalibrationSidecar
};

// STACK.calibration.json beside the stack, where there is one.
std::optional<std::filesystem::path> CalibrationSidecar(const std::filesystem::path& stack);

// Writes the page atomically. A sidecar or picture that cannot be read becomes a sentence on the page, not an
// error: the fit itself is good. Throws StorageError where the page cannot be written.
void WriteReport(const std::filesystem::path& path, const ReportInput& input);

// C_m.png, C_m.sigma.png, ..., chi2.png and colour.png in the fit folder.
void WriteMapPreviews(const std::filesystem::path& directory, const FitResult& fit,
                      const std::filesystem::path& spectra_dir);

}  // namespace dermap
