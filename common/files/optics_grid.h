// SPDX-License-Identifier: Apache-2.0
// The tables that `dermap optics` reads and writes: one homogeneous skin a row.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/files/csv_table.h"
#include "common/optics/homogeneous_skin.h"

namespace dermap {

struct OpticsGrid {
  CsvTable table;  // as it was read
  std::vector<SkinRow> rows;
};

// Columns in any order: wavelength_nm, mu_a_epidermis_per_mm and mu_a_dermis_per_mm are required;
// junction_absorbance, mu_s_reduced_epidermis_per_mm, mu_s_reduced_dermis_per_mm and epidermis_thickness_mm
// may be absent and then follow from `config`. Throws InputError that names file, line and column.
OpticsGrid ReadOpticsGrid(const std::filesystem::path& path, const TissueConfig& config);

// A radius as it was typed and in mm: "R(0.03)" is the name of its column.
struct TypedRadius {
  std::string text;
  double radius_mm;
};
// "0.03,0.1,0.5". Throws InputError.
std::vector<TypedRadius> ParseRadii(const std::string& text);

// The columns of the grid, and behind them reflectance,R1,T1,R2, what else was requested, and R(...).
void WriteOpticsGrid(const std::filesystem::path& path, const OpticsGrid& grid,
                     const std::vector<SkinResponses>& responses, const std::vector<TypedRadius>& radii,
                     const SkinRequest& request);

}  // namespace dermap
