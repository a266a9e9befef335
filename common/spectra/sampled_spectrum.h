// SPDX-License-Identifier: Apache-2.0
// Spectra sampled at wavelengths in nm, linear in between, read from the CSV files of config/spectra/.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace dermap {

class SampledSpectrum {
 public:
  SampledSpectrum() = default;
  // Wavelengths in nm, strictly ascending, as many as values; throws InputError otherwise.
  SampledSpectrum(std::vector<double> wavelengths_nm, std::vector<double> values);

  // Linear interpolation; throws InputError outside the sampled range (extrapolation would be silent error).
  double At(double wavelength_nm) const;

  double first_nm() const { return wavelengths_nm_.front(); }
  double last_nm() const { return wavelengths_nm_.back(); }
  const std::vector<double>& wavelengths_nm() const { return wavelengths_nm_; }
  const std::vector<double>& values() const { return values_; }

 private:
  std::vector<double> wavelengths_nm_;
  std::vector<double> values_;
};

// Reads `column` of a CSV: '#' lines (quantity, unit, source), one header line whose first name is
// wavelength_nm, then numbers. Throws InputError naming file and line.
SampledSpectrum ReadSpectrumCsv(const std::filesystem::path& path, const std::string& column);

}  // namespace dermap
