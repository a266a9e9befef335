// SPDX-License-Identifier: Apache-2.0
// Columns by name, numbers within their ranges, and the same table with results behind.
#include "common/files/optics_grid.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/text.h"

namespace dermap {
namespace {

struct Column {
  const char* name;
  double least, greatest;
  bool required;
};
enum ColumnIndex { kWavelength, kMuAEpidermis, kMuADermis, kJunction, kMuSEpidermis, kMuSDermis, kThickness };
// docs/formats.md repeats these ranges.
constexpr std::array kColumns{
    Column{"wavelength_nm", 350.0, 1000.0, true},
    Column{"mu_a_epidermis_per_mm", 0.0, 1000.0, true},
    Column{"mu_a_dermis_per_mm", 0.0, 1000.0, true},
    Column{"junction_absorbance", 0.0, 20.0, false},
    Column{"mu_s_reduced_epidermis_per_mm", 0.01, 1000.0, false},
    Column{"mu_s_reduced_dermis_per_mm", 0.01, 1000.0, false},
    Column{"epidermis_thickness_mm", 0.001, 10.0, false},
};
constexpr Column kRadius{"--radial-mm", 0.01, 20.0, false};

std::string NearestName(const std::string& name) {
  return std::min_element(kColumns.begin(), kColumns.end(),
                          [&](const Column& a, const Column& b) {
                            return EditDistance(a.name, name) < EditDistance(b.name, name);
                          })
      ->name;
}

// Where each known column stands in the table, or -1.
using Places = std::array<int, kColumns.size()>;
Places FindColumns(const std::filesystem::path& path, const CsvRow& header) {
  Places places;
  places.fill(-1);
  const std::string where = fmt::format("{} line {}", path.string(), header.line);
  for (std::size_t field = 0; field < header.fields.size(); ++field) {
    const std::string& name = header.fields[field];
    const auto column =
        std::find_if(kColumns.begin(), kColumns.end(), [&](const Column& c) { return name == c.name; });
    if (column == kColumns.end()) {
      throw InputError(fmt::format(
          "{}: there is no column '{}'; did you mean {}? Expected {}.", where, Shorten(name, 60),
          NearestName(name), "wavelength_nm,mu_a_epidermis_per_mm,mu_a_dermis_per_mm and optional ones"));
    }
    int& place = places[column - kColumns.begin()];
    if (place >= 0)
      throw InputError(fmt::format("{}: the column {} stands there twice; remove one.", where, name));
    place = static_cast<int>(field);
  }
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    if (kColumns[i].required && places[i] < 0) {
      throw InputError(fmt::format("{}: the column {} is missing; add it.", where, kColumns[i].name));
    }
  }
  return places;
}

class RowReader {
 public:
  RowReader(const std::filesystem::path& path, const Places& places, const CsvRow& row)
      : where_(fmt::format("{} line {}", path.string(), row.line)), places_(places), row_(row) {}

  bool Has(ColumnIndex column) const { return places_[column] >= 0; }
  double Number(ColumnIndex index) const {
    const Column& column = kColumns[index];
    const std::string& text = row_.fields[places_[index]];
    const double value = CsvNumber(where_, column.name, text);
    if (value < column.least || value > column.greatest) {
      throw InputError(fmt::format("{}: {} is {}; expected {} to {}.", where_, column.name, Shorten(text, 40),
                                   FormatNumber(column.least), FormatNumber(column.greatest)));
    }
    return value;
  }
  double NumberOr(ColumnIndex column, double value) const { return Has(column) ? Number(column) : value; }

 private:
  std::string where_;
  const Places& places_;
  const CsvRow& row_;
};

}  // namespace

OpticsGrid ReadOpticsGrid(const std::filesystem::path& path, const TissueConfig& config) {
  OpticsGrid grid{ReadCsv(path), {}};
  const Places places = FindColumns(path, grid.table.header);
  if (grid.table.rows.empty()) {
    throw InputError(path.string() + " has a line of column names but no rows; expected one skin a row.");
  }
  grid.rows.reserve(grid.table.rows.size());
  for (const CsvRow& row : grid.table.rows) {
    const RowReader read(path, places, row);
    const double wavelength_nm = read.Number(kWavelength);
    grid.rows.push_back(
        {.mu_a_epidermis = read.Number(kMuAEpidermis),
         .mu_a_dermis = read.Number(kMuADermis),
         .junction_absorbance = read.NumberOr(kJunction, config.junction_absorbance),
         .mu_s_reduced_epidermis =
             read.NumberOr(kMuSEpidermis, ReducedScatteringEpidermis(wavelength_nm, config)),
         .mu_s_reduced_dermis = read.NumberOr(kMuSDermis, ReducedScatteringDermis(wavelength_nm, config)),
         .epidermis_thickness_mm = read.NumberOr(kThickness, config.epidermis_thickness_mm)});
  }
  return grid;
}

std::vector<TypedRadius> ParseRadii(const std::string& text) {
  std::vector<TypedRadius> radii;
  std::string_view left = text;
  while (true) {
    const std::size_t end = std::min(left.find(','), left.size());
    const std::string typed(Trim(left.substr(0, end)));
    const double radius_mm = CsvNumber(kRadius.name, "a radius", typed);
    if (radius_mm < kRadius.least || radius_mm > kRadius.greatest) {
      throw InputError(fmt::format("{}: a radius is {}; expected {} to {} mm.", kRadius.name, typed,
                                   FormatNumber(kRadius.least), FormatNumber(kRadius.greatest)));
    }
    radii.push_back({typed, radius_mm});
    if (end == left.size()) return radii;
    left.remove_prefix(end + 1);
  }
}

void WriteOpticsGrid(const std::filesystem::path& path, const OpticsGrid& grid,
                     const std::vector<SkinResponses>& responses, const std::vector<TypedRadius>& radii,
                     const SkinRequest& request) {
  std::string text;
  const auto begin_line = [&](const CsvRow& row) {
    for (const std::string& field : row.fields) text += CsvField(field) + ',';
  };
  begin_line(grid.table.header);
  text += "reflectance,R1,T1,R2";
  const bool with_stack = request.thin_dermis_mm > 0.0;
  if (request.single) text += ",single";
  if (with_stack) text += ",stack_reflectance,stack_transmittance";
  for (const TypedRadius& radius : radii) text += ",R(" + radius.text + ')';
  text += '\n';
  for (std::size_t i = 0; i < responses.size(); ++i) {
    const SkinResponses& r = responses[i];
    begin_line(grid.table.rows[i]);
    text += fmt::format("{:.8g},{:.8g},{:.8g},{:.8g}", r.reflectance, r.r1, r.t1, r.r2);
    if (request.single) text += fmt::format(",{:.8g}", r.single);
    if (with_stack) text += fmt::format(",{:.8g},{:.8g}", r.stack_reflectance, r.stack_transmittance);
    for (const double value : r.radial_per_mm2) text += fmt::format(",{:.8g}", value);
    text += '\n';
  }
  WriteFileAtomically(path, text);
}

}  // namespace dermap
