// SPDX-License-Identifier: Apache-2.0
// The fit folder: maps.exr, sigma.exr, predicted.exr, residual.exr, flags.exr and fit.json.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "fit/fit_result.h"

namespace dermap {

// Each file is whole or absent; fit.json comes last, so a folder that has it is complete. Throws
// StorageError.
void WriteFit(const std::filesystem::path& directory, const FitResult& result);

// The contents of fit.json.
nlohmann::ordered_json FitRecord(const FitResult& result);

}  // namespace dermap
