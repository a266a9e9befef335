// SPDX-License-Identifier: Apache-2.0
// Finds the wavelengths in a table and checks what stands below them.
#include "fit/spectra/spectra_table.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include "common/core/error.h"
#include "common/files/csv_table.h"
#include "common/files/text.h"

namespace dermap {
namespace {

constexpr std::size_t kFewestBands = 8;  // one more than the largest model has free parameters
constexpr double kLargestReflectance = 1.5;
constexpr std::array<std::string_view, 10> kPrefixes{"reflectance", "refl", "lambda", "band", "wl",
                                                     "nm",          "r",    "x",      "w",    "t."};

// 450 from "450", "R450", "r_450", "Reflectance 450 nm"; nullopt for a name that is no wavelength.
std::optional<double> WavelengthOf(const std::string& name) {
  const std::string lower = LowerCase(name);
  std::string_view text = lower;
  for (const std::string_view prefix : kPrefixes) {
    if (text.starts_with(prefix)) {
      text.remove_prefix(prefix.size());
      break;
    }
  }
  while (!text.empty() && (text.front() == '_' || text.front() == ' ' || text.front() == '('))
    text.remove_prefix(1);
  if (text.ends_with(')')) text.remove_suffix(1);
  if (text.ends_with("nm")) text.remove_suffix(2);
  text = Trim(text);
  double nm = 0.0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), nm);
  if (failure != std::errc() || end != text.data() + text.size() || !(nm >= 200.0 && nm <= 3000.0)) return {};
  return nm;
}

double Reflectance(const std::string& where, const std::string& what, const std::string& text,
                   bool per_cent) {
  if (Trim(text).empty()) {
    throw InputError(fmt::format("{}: the reflectance at {} is missing; fill it in or leave that {} out.",
                                 where, what, "spectrum or wavelength"));
  }
  const double value = CsvNumber(where, "the reflectance at " + what, text) * (per_cent ? 0.01 : 1.0);
  if (value > kLargestReflectance) {
    throw InputError(fmt::format("{}: the reflectance at {} is {}; expected a fraction from 0 to {}{}", where,
                                 what, Shorten(text, 40), kLargestReflectance,
                                 per_cent ? "." : ": these look like per cent, which --percent reads."));
  }
  if (value < -0.1) {
    throw InputError(fmt::format("{}: the reflectance at {} is {}; expected a fraction from 0 to {}.", where,
                                 what, Shorten(text, 40), kLargestReflectance));
  }
  return value;
}

void CheckAscending(const std::string& where, const std::vector<double>& nm) {
  for (std::size_t i = 1; i < nm.size(); ++i) {
    if (nm[i] > nm[i - 1]) continue;
    throw InputError(fmt::format("{}: after {} nm comes {} nm; expected ascending wavelengths, each once.",
                                 where, FormatNumber(nm[i - 1]), FormatNumber(nm[i])));
  }
}

// Cuts to the range that is asked for.
void Restrict(MeasuredSpectra& spectra, const SpectraFormat& format, const std::string& where) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < spectra.wavelengths_nm.size(); ++i) {
    const double nm = spectra.wavelengths_nm[i];
    if (nm >= format.from_nm && nm <= format.to_nm) kept.push_back(i);
  }
  if (kept.size() < kFewestBands) {
    throw InputError(fmt::format(
        "{}: found {} wavelengths from {} to {} nm; expected at least {}, since up to 7 parameters are "
        "fitted.",
        where, kept.size(), FormatNumber(format.from_nm), FormatNumber(format.to_nm), kFewestBands));
  }
  const auto cut = [&](std::vector<double>& values) {
    if (values.empty()) return;
    std::vector<double> some;
    for (const std::size_t i : kept) some.push_back(values[i]);
    values = std::move(some);
  };
  cut(spectra.wavelengths_nm);
  for (MeasuredSpectra::Row& row : spectra.rows) {
    cut(row.reflectance);
    cut(row.sigma);
  }
}

MeasuredSpectra FromRows(const CsvTable& table, const std::string& file, bool per_cent) {
  MeasuredSpectra spectra;
  const std::vector<std::string>& header = table.header.fields;
  std::vector<std::size_t> bands, labels;
  for (std::size_t i = 0; i < header.size(); ++i) {
    const std::optional<double> nm = WavelengthOf(header[i]);
    (nm ? bands : labels).push_back(i);
    if (nm) spectra.wavelengths_nm.push_back(*nm);
  }
  const std::string where = fmt::format("{} line {}", file, table.header.line);
  if (bands.empty()) {
    throw InputError(
        fmt::format("{}: no column is named by a wavelength, the first is '{}'; expected names such as 450, "
                    "R450 or 450 nm, or "
                    "wavelength_nm as the first name where every column is a spectrum.",
                    where, Shorten(header.front(), 40)));
  }
  CheckAscending(where, spectra.wavelengths_nm);
  if (labels.empty()) spectra.label_names.emplace_back("spectrum");
  for (const std::size_t i : labels) spectra.label_names.push_back(header[i]);
  for (const CsvRow& line : table.rows) {
    MeasuredSpectra::Row row;
    const std::string at = fmt::format("{} line {}", file, line.line);
    if (labels.empty()) row.labels.push_back(std::to_string(spectra.rows.size() + 1));
    for (const std::size_t i : labels) row.labels.push_back(line.fields[i]);
    for (const std::size_t i : bands) {
      row.reflectance.push_back(Reflectance(at, header[i], line.fields[i], per_cent));
    }
    spectra.rows.push_back(std::move(row));
  }
  return spectra;
}

MeasuredSpectra FromColumns(const CsvTable& table, const std::string& file, bool per_cent) {
  MeasuredSpectra spectra;
  const std::vector<std::string>& header = table.header.fields;
  spectra.label_names = {"spectrum"};
  spectra.rows.resize(header.size() - 1);
  for (std::size_t i = 1; i < header.size(); ++i) spectra.rows[i - 1].labels = {header[i]};
  for (const CsvRow& line : table.rows) {
    const std::string at = fmt::format("{} line {}", file, line.line);
    spectra.wavelengths_nm.push_back(CsvNumber(at, "the wavelength", line.fields[0]));
    CheckAscending(at, spectra.wavelengths_nm);
    for (std::size_t i = 1; i < header.size(); ++i) {
      spectra.rows[i - 1].reflectance.push_back(Reflectance(
          at, fmt::format("{} nm of {}", line.fields[0], Shorten(header[i], 40)), line.fields[i], per_cent));
    }
  }
  return spectra;
}

bool NamesWavelengths(const std::string& name) {
  const std::string lower = LowerCase(name);
  return lower == "wavelength_nm" || lower == "wavelength" || lower == "wavelengths" || lower == "lambda" ||
         lower == "lambda_nm" || lower == "nm";
}

}  // namespace

MeasuredSpectra ReadSpectra(const std::filesystem::path& path, const SpectraFormat& format) {
  const CsvTable table = ReadCsv(path);
  const std::string file = path.string();
  if (format.layout != "auto" && format.layout != "rows" && format.layout != "columns") {
    throw InputError(fmt::format("The layout is '{}'; expected auto, rows or columns.", format.layout));
  }
  if (table.rows.empty()) {
    throw InputError(file + " has a line of column names but no rows; expected a spectrum a row.");
  }
  const bool columns = format.layout == "columns" ||
                       (format.layout == "auto" && NamesWavelengths(table.header.fields.front()));
  if (columns && table.header.fields.size() < 2) {
    throw InputError(file +
                     " has wavelengths but no spectrum; expected a column for each spectrum behind them.");
  }
  MeasuredSpectra spectra =
      columns ? FromColumns(table, file, format.per_cent) : FromRows(table, file, format.per_cent);
  Restrict(spectra, format, file);
  return spectra;
}

MeasuredSpectra SpectraOfStack(const ReflectanceStack& stack, const SpectraFormat& format,
                               std::string_view name) {
  MeasuredSpectra spectra;
  spectra.label_names = {"x", "y"};
  for (const Band& band : stack.bands) spectra.wavelengths_nm.push_back(band.wavelength_nm);
  for (int y = 0; y < stack.height(); ++y) {
    for (int x = 0; x < stack.width(); ++x) {
      if (!stack.valid.empty() && !(stack.valid(x, y) > 0.5F)) continue;
      MeasuredSpectra::Row row{{std::to_string(x), std::to_string(y)}, {}, {}};
      for (const PlaneF& plane : stack.reflectance) row.reflectance.push_back(plane(x, y));
      for (const PlaneF& plane : stack.sigma) row.sigma.push_back(plane(x, y));
      const auto finite = [](double value) { return std::isfinite(value); };
      if (std::all_of(row.reflectance.begin(), row.reflectance.end(), finite))
        spectra.rows.push_back(std::move(row));
    }
  }
  if (spectra.rows.empty()) {
    throw InputError(
        fmt::format("{} has no pixel that is valid in every band; expected at least one.", name));
  }
  Restrict(spectra, format, std::string(name));
  return spectra;
}

}  // namespace dermap
