// SPDX-License-Identifier: Apache-2.0
// Ratios that do not vary.
#include "fit/copied_bands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dermap {
namespace {

constexpr double kSame = 3e-6;     // relative: rounding of single precision and of a factor
constexpr double kVaries = 1e-3;   // relative: a picture of less tells nothing
constexpr int kFewestPixels = 16;  // that both bands have

// Of values: largest over smallest, less 1.
struct Spread {
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  void Add(double value) {
    least = std::min(least, value);
    most = std::max(most, value);
  }
  double relative() const { return most / least - 1.0; }
};

bool IsCopy(const FitData& data, int a, int b) {
  Spread picture, ratio;
  int count = 0;
  for (std::size_t i = 0; i < data.measured[a].size(); ++i) {
    if (!data.Has(a, i) || !data.Has(b, i)) continue;
    const double here = data.measured[a].data()[i], there = data.measured[b].data()[i];
    if (!(here > 0.0) || !(there > 0.0)) continue;
    picture.Add(here);
    ratio.Add(there / here);
    if (ratio.relative() > kSame) return false;
    ++count;
  }
  return count >= kFewestPixels && picture.relative() > kVaries;
}

void LeaveOut(int band, FitData& data) {
  constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();
  std::fill(data.measured[band].values().begin(), data.measured[band].values().end(), kMissing);
  std::fill(data.sigma[band].values().begin(), data.sigma[band].values().end(), kMissing);
}

}  // namespace

void LeaveOutCopies(FitData& data, std::vector<std::string>& decisions) {
  std::vector<char> out(data.bands.size(), 0);
  for (int a = 0; a < data.band_count(); ++a)
    for (int b = a + 1; b < data.band_count(); ++b) {
      if (!IsCopy(data, a, b)) continue;
      const double first = data.bands[a].wavelength_nm, second = data.bands[b].wavelength_nm;
      const bool repeated = first == second;
      out[b] = 1;
      if (!repeated) out[a] = 1;
      decisions.push_back(
          repeated
              ? fmt::format("The band {:g} nm is in the stack twice with the same picture; one was left out.",
                            first)
              : fmt::format(
                    "The bands {:g} and {:g} nm hold the same picture, so one of them is a copy (a file "
                    "taken for two, or a wheel that stood still?); both were left out.",
                    first, second));
    }
  for (std::size_t b = 0; b < out.size(); ++b)
    if (out[b]) LeaveOut(static_cast<int>(b), data);
}

}  // namespace dermap
