// SPDX-License-Identifier: Apache-2.0
// Linear interpolation of sampled spectra, and a strict reader for their CSV files.
#include "common/spectra/sampled_spectrum.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>
#include <utility>

#include "common/core/error.h"

namespace dermap {
namespace {

std::string_view Trim(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const auto first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::vector<std::string_view> SplitAtCommas(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t begin = 0;;) {
    const auto comma = line.find(',', begin);
    fields.push_back(Trim(line.substr(begin, comma - begin)));
    if (comma == std::string_view::npos) return fields;
    begin = comma + 1;
  }
}

// Where in a file we are, for messages.
struct Place {
  const std::filesystem::path& path;
  int line;
  std::string Text() const { return fmt::format("{}, line {}", path.string(), line); }
};

double ParseNumber(std::string_view field, const Place& place) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc{} || end != field.data() + field.size() || !std::isfinite(value)) {
    throw InputError(
        fmt::format("{}: found '{}' where a number is expected; correct that field.", place.Text(), field));
  }
  return value;
}

std::size_t FindColumn(const std::vector<std::string_view>& names, const std::string& column,
                       const Place& place) {
  if (names.empty() || names.front() != "wavelength_nm") {
    throw InputError(
        fmt::format("{}: the header's first column is '{}' where 'wavelength_nm' is expected; name it so.",
                    place.Text(), names.empty() ? std::string_view{} : names.front()));
  }
  const auto found = std::find(names.begin() + 1, names.end(), column);
  if (found == names.end()) {
    throw InputError(fmt::format("{}: there is no column '{}' (found: {}); add it or name one of these.",
                                 place.Text(), column, fmt::join(names, ", ")));
  }
  return static_cast<std::size_t>(found - names.begin());
}

}  // namespace

SampledSpectrum::SampledSpectrum(std::vector<double> wavelengths_nm, std::vector<double> values)
    : wavelengths_nm_(std::move(wavelengths_nm)), values_(std::move(values)) {
  if (wavelengths_nm_.size() != values_.size()) {
    throw InputError(fmt::format("A spectrum has {} wavelengths but {} values; give as many of each.",
                                 wavelengths_nm_.size(), values_.size()));
  }
  if (wavelengths_nm_.size() < 2) throw InputError("A spectrum needs two samples at least; add some.");
  for (std::size_t i = 1; i < wavelengths_nm_.size(); ++i) {
    if (!(wavelengths_nm_[i] > wavelengths_nm_[i - 1])) {
      throw InputError(
          fmt::format("A spectrum's wavelengths must ascend, but {} nm is followed by {} nm; sort them.",
                      wavelengths_nm_[i - 1], wavelengths_nm_[i]));
    }
  }
}

double SampledSpectrum::At(double wavelength_nm) const {
  if (wavelengths_nm_.empty() || !(wavelength_nm >= first_nm() && wavelength_nm <= last_nm())) {
    throw InputError(
        wavelengths_nm_.empty()
            ? fmt::format("A spectrum without samples was asked for {} nm; read it first.", wavelength_nm)
            : fmt::format("A spectrum sampled from {} to {} nm was asked for {} nm; stay within it.",
                          first_nm(), last_nm(), wavelength_nm));
  }
  const auto above = std::upper_bound(wavelengths_nm_.begin(), wavelengths_nm_.end() - 1, wavelength_nm);
  const auto i = static_cast<std::size_t>(above - wavelengths_nm_.begin());
  const double share =
      (wavelength_nm - wavelengths_nm_[i - 1]) / (wavelengths_nm_[i] - wavelengths_nm_[i - 1]);
  return (1.0 - share) * values_[i - 1] + share * values_[i];
}

SampledSpectrum ReadSpectrumCsv(const std::filesystem::path& path, const std::string& column) {
  std::ifstream file(path);
  if (!file) {
    throw InputError(fmt::format("{}: cannot be opened, where a spectrum (CSV) is expected; check the path.",
                                 path.string()));
  }
  std::vector<double> wavelengths_nm, values;
  std::size_t column_count = 0, wanted = 0;
  std::string line;
  for (Place place{path, 1}; std::getline(file, line); ++place.line) {
    const std::string_view text = Trim(line);
    if (text.empty() || text.front() == '#') continue;
    const auto fields = SplitAtCommas(text);
    if (column_count == 0) {
      wanted = FindColumn(fields, column, place);
      column_count = fields.size();
      continue;
    }
    if (fields.size() != column_count) {
      throw InputError(fmt::format("{}: found {} fields where the header has {}; complete the line.",
                                   place.Text(), fields.size(), column_count));
    }
    wavelengths_nm.push_back(ParseNumber(fields[0], place));
    values.push_back(ParseNumber(fields[wanted], place));
  }
  try {
    return SampledSpectrum(std::move(wavelengths_nm), std::move(values));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}, column '{}': {}", path.string(), column, error.what()));
  }
}

}  // namespace dermap
