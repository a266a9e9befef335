// SPDX-License-Identifier: Apache-2.0
// Rows are checked as they are read; each is then two layers of its own.
#include "common/optics/optics_grid.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <istream>
#include <optional>
#include <ostream>

#include "common/core/error.h"
#include "common/core/parallel.h"
#include "common/optics/layers.h"
#include "common/optics/radial_profile.h"

namespace dermap {
namespace {

struct Column {
  std::string_view name;
  double OpticsRow::*member;
  double lower, upper;
  bool required;
};
constexpr std::array<Column, 7> kColumns{{
    {"wavelength_nm", &OpticsRow::wavelength_nm, 350.0, 1000.0, true},
    {"mu_a_epidermis_per_mm", &OpticsRow::mu_a_epidermis, 0.0, 1000.0, true},
    {"mu_a_dermis_per_mm", &OpticsRow::mu_a_dermis, 0.0, 1000.0, true},
    {"junction_absorbance", &OpticsRow::junction_absorbance, 0.0, 100.0, false},
    {"mu_s_reduced_epidermis_per_mm", &OpticsRow::mu_s_reduced_epidermis, 0.01, 1000.0, false},
    {"mu_s_reduced_dermis_per_mm", &OpticsRow::mu_s_reduced_dermis, 0.01, 1000.0, false},
    {"epidermis_thickness_mm", &OpticsRow::epidermis_thickness_mm, 0.001, 10.0, false},
}};

std::vector<std::string> Fields(const std::string& line) {
  std::vector<std::string> fields;
  std::size_t start = 0;
  while (start <= line.size()) {
    const std::size_t end = std::min(line.find(',', start), line.size());
    std::string field = line.substr(start, end - start);
    const auto first = field.find_first_not_of(" \t\r"), last = field.find_last_not_of(" \t\r");
    fields.push_back(first == std::string::npos ? "" : field.substr(first, last - first + 1));
    start = end + 1;
  }
  return fields;
}

// Index of each known column among the file's; -1 where it is absent.
std::array<int, kColumns.size()> ColumnsOf(const std::vector<std::string>& header, const std::string& where) {
  std::array<int, kColumns.size()> at;
  at.fill(-1);
  for (std::size_t i = 0; i < header.size(); ++i) {
    const auto known =
        std::find_if(kColumns.begin(), kColumns.end(), [&](const Column& c) { return c.name == header[i]; });
    if (known == kColumns.end()) {
      std::string names;
      for (const Column& c : kColumns) names += (names.empty() ? "" : ", ") + std::string(c.name);
      throw InputError(
          fmt::format("{}: there is no column '{}'; the columns are {}.", where, header[i], names));
    }
    int& index = at[known - kColumns.begin()];
    if (index >= 0)
      throw InputError(fmt::format("{}: column '{}' is there twice; keep one.", where, header[i]));
    index = static_cast<int>(i);
  }
  for (std::size_t c = 0; c < kColumns.size(); ++c) {
    if (kColumns[c].required && at[c] < 0) {
      throw InputError(fmt::format("{}: column '{}' is missing; add it.", where, kColumns[c].name));
    }
  }
  return at;
}

double NumberIn(const std::string& field, const Column& column, const std::string& where) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size() || !std::isfinite(value)) {
    throw InputError(fmt::format("{}: {} is '{}', which is no number.", where, column.name, field));
  }
  if (value < column.lower || value > column.upper) {
    throw InputError(fmt::format("{}: {} is {}, but must lie in {} to {}.", where, column.name, value,
                                 column.lower, column.upper));
  }
  return value;
}

OpticsRow RowFrom(const std::vector<std::string>& fields, const std::array<int, kColumns.size()>& at,
                  const std::string& where, const TissueConfig& config) {
  OpticsRow row;
  row.wavelength_nm = NumberIn(fields[at[0]], kColumns[0], where);
  row.junction_absorbance = config.junction_absorbance;
  row.mu_s_reduced_epidermis = ReducedScatteringEpidermis(row.wavelength_nm, config);
  row.mu_s_reduced_dermis = ReducedScatteringDermis(row.wavelength_nm, config);
  row.epidermis_thickness_mm = config.epidermis_thickness_mm;
  for (std::size_t c = 0; c < kColumns.size(); ++c) {
    if (at[c] >= 0) row.*kColumns[c].member = NumberIn(fields[at[c]], kColumns[c], where);
  }
  return row;
}

EpidermisOptics EpidermisOf(const OpticsRow& row, const TissueConfig& config) {
  return {.layer = {.mu_a = row.mu_a_epidermis,
                    .mu_s_reduced = row.mu_s_reduced_epidermis,
                    .n = config.n_epidermis},
          .thickness_mm = row.epidermis_thickness_mm,
          .n_above = config.n_outside,
          .n_below = config.n_dermis,
          .dermis = {.mu_a = row.mu_a_dermis, .mu_s_reduced = row.mu_s_reduced_dermis}};
}

DermisOptics DermisOf(const OpticsRow& row, const TissueConfig& config) {
  return {.layer = {.mu_a = row.mu_a_dermis, .mu_s_reduced = row.mu_s_reduced_dermis, .n = config.n_dermis},
          .n_above = config.n_epidermis,
          .epidermis = {.mu_a = row.mu_a_epidermis, .mu_s_reduced = row.mu_s_reduced_epidermis},
          .epidermis_thickness_mm = row.epidermis_thickness_mm};
}

OpticsResult Evaluate(const ProfileSource& source, const TissueConfig& config, const OpticsRow& row,
                      const RadialProfile& radial) {
  static constexpr double kTotal[] = {0.0};
  const EpidermisOptics upper = EpidermisOf(row, config);
  const DermisOptics lower = DermisOf(row, config);
  std::span<const double> k(kTotal);
  if (!radial.radii_mm().empty()) {
    k = RadialProfile::Frequencies_per_mm(
        std::max(upper.layer.mu_a + upper.layer.mu_s_reduced, lower.layer.mu_a + lower.layer.mu_s_reduced));
  }
  const EpidermisTransforms epidermis = source.Epidermis(upper, k);
  const DermisTransforms dermis = source.Dermis(lower, k);
  OpticsResult result;
  result.reflectance = TwoLayerReflectance(epidermis, dermis, row.junction_absorbance)[0];
  result.r1 = epidermis.r_forward[0];
  result.t1 = epidermis.t_forward[0] + epidermis.t_ballistic;
  result.r2 = dermis.r_diffuse[0];
  if (!radial.radii_mm().empty())
    result.radial = radial.At(upper, epidermis, dermis, row.junction_absorbance);
  return result;
}

}  // namespace

std::vector<OpticsRow> ReadOpticsGrid(std::istream& in, const std::string& name, const TissueConfig& config) {
  std::vector<OpticsRow> rows;
  std::optional<std::array<int, kColumns.size()>> columns;
  std::size_t column_count = 0;
  int line_number = 0;
  for (std::string line; std::getline(in, line);) {
    ++line_number;
    const std::string where = fmt::format("{} line {}", name, line_number);
    if (line.find_first_not_of(" \t\r,") == std::string::npos || line[0] == '#') continue;
    const std::vector<std::string> fields = Fields(line);
    if (!columns) {
      columns = ColumnsOf(fields, where);
      column_count = fields.size();
      continue;
    }
    if (fields.size() != column_count) {
      throw InputError(fmt::format("{}: {} values where the header names {} columns.", where, fields.size(),
                                   column_count));
    }
    rows.push_back(RowFrom(fields, *columns, where, config));
  }
  if (!columns || rows.empty()) {
    throw InputError(
        fmt::format("{}: there is no row in it; expected a line with the names of the columns, then one "
                    "line of numbers for each skin.",
                    name));
  }
  return rows;
}

std::vector<OpticsResult> EvaluateOpticsGrid(const ProfileSource& source, const TissueConfig& config,
                                             std::span<const OpticsRow> rows,
                                             std::span<const double> radii_mm) {
  Validate(config);
  if (config.anisotropy != 0.0) {
    throw InputError(fmt::format(
        "[tissue] anisotropy is {}, but profiles know only isotropic (reduced) scattering; set it to 0.",
        config.anisotropy));
  }
  const RadialProfile radial(radii_mm);
  std::vector<OpticsResult> results(rows.size());
  ParallelFor(static_cast<int>(rows.size()),
              [&](int i) { results[i] = Evaluate(source, config, rows[i], radial); });
  return results;
}

void WriteOpticsGrid(std::ostream& out, std::span<const OpticsRow> rows,
                     std::span<const OpticsResult> results, std::span<const double> radii_mm) {
  for (const Column& column : kColumns) out << column.name << ',';
  out << "reflectance,R1,T1,R2";
  for (const double radius : radii_mm) out << fmt::format(",R({})", radius);
  out << '\n';
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (const Column& column : kColumns) out << fmt::format("{},", rows[i].*column.member);
    const OpticsResult& r = results[i];
    out << fmt::format("{:.7g},{:.7g},{:.7g},{:.7g}", r.reflectance, r.r1, r.t1, r.r2);
    for (const double value : r.radial) out << fmt::format(",{:.6g}", value);
    out << '\n';
  }
}

}  // namespace dermap
