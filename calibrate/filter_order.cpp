// SPDX-License-Identifier: Apache-2.0
// Colours by quadrature over Gaussian filters; compared as logarithms of their ratios.
#include "calibrate/filter_order.h"

#include <algorithm>
#include <cmath>

#include "calibrate/failure.h"
#include "calibrate/frame_picture.h"
#include "calibrate/statistics.h"
#include "common/tissue/tissue.h"

namespace dermap {
namespace {

constexpr int kSteps = 40;       // to either side of the centre
constexpr double kWidths = 2.0;  // of the filter's full width
constexpr double kFaint = 0.03;  // of the strongest colour: weaker ones are uncertain curves and stray light
constexpr double kAmbiguous = 0.25;  // logarithm: what curves of another camera of the model differ by
constexpr double kMostOfCurve = 1e9;
constexpr double kMuchBetter = 0.4;  // another filter's misfit against the own one's

std::filesystem::path InConfig(const std::filesystem::path& path) {
  return path.is_absolute() ? path : ConfigDirectory() / path;
}

// Relative numbers, of any unit.
SampledSpectrum ReadCurve(const std::filesystem::path& path, const std::string& column) {
  SampledSpectrum curve = ReadSpectrumCsv(InConfig(path), column);
  for (const double value : curve.values()) {
    if (value >= 0.0 && value <= kMostOfCurve) continue;
    throw InputError(path.string() + ": the column '" + column + "' holds " + Short(value) +
                     "; expected relative numbers from 0 to " + Short(kMostOfCurve));
  }
  return curve;
}

std::size_t ChannelOf(char colour) {
  return colour == 'R' ? 0 : colour == 'B' ? 2 : 1;
}

double AtOrZero(const SampledSpectrum& s, double nm) {
  return nm < s.first_nm() || nm > s.last_nm() ? 0.0 : s.At(nm);
}

// Calls add(nm, light) over the filter's curve.
template <class Add>
void OverFilter(const SpectralCurves& curves, const Band& band, char colour, const Add& add) {
  const double width = std::max(0.1, band.fwhm_nm);
  const SampledSpectrum& camera = curves.camera[ChannelOf(colour)];
  for (int i = -kSteps; i <= kSteps; ++i) {
    const double widths = kWidths * i / kSteps;
    const double nm = band.wavelength_nm + widths * width;
    const double filter = std::exp(-4.0 * std::log(2.0) * widths * widths);
    add(nm, filter * AtOrZero(curves.flash, nm) * AtOrZero(camera, nm));
  }
}

// Root mean square difference of log colours, relative to the strongest; faint ones count as equal when both
// are faint.
double Misfit(const std::array<double, kLatticeCount>& a, const std::array<double, kLatticeCount>& b) {
  const double top_a = *std::max_element(a.begin(), a.end());
  const double top_b = *std::max_element(b.begin(), b.end());
  double sum = 0.0;
  for (int i = 0; i < kLatticeCount; ++i) {
    const double la = std::log(std::max(a[i] / top_a, kFaint));
    const double lb = std::log(std::max(b[i] / top_b, kFaint));
    sum += (la - lb) * (la - lb) / kLatticeCount;
  }
  return std::sqrt(sum);
}

}  // namespace

std::optional<SpectralCurves> ReadSpectralCurves(const RigConfig& rig) {
  if (rig.optics.camera_csv.empty() || rig.optics.flash_csv.empty()) return std::nullopt;
  const auto& camera = rig.optics.camera_csv;
  return SpectralCurves{{ReadCurve(camera, "red"), ReadCurve(camera, "green"), ReadCurve(camera, "blue")},
                        ReadCurve(rig.optics.flash_csv, "relative_power")};
}

std::array<double, kLatticeCount> ColoursOfFilter(const SpectralCurves& curves, const Band& band,
                                                  const std::array<char, kLatticeCount>& colours) {
  std::array<double, kLatticeCount> light{};
  for (int i = 0; i < kLatticeCount; ++i)
    OverFilter(curves, band, colours[i], [&](double, double l) { light[i] += l; });
  return light;
}

double EffectiveWavelength(const SpectralCurves& curves, const Band& band,
                           const std::array<double, kLatticeCount>& signals,
                           const std::array<char, kLatticeCount>& colours) {
  double total = 0.0;
  double sum = 0.0;
  for (int i = 0; i < kLatticeCount; ++i) {
    double light = 0.0;
    double moment = 0.0;
    OverFilter(curves, band, colours[i], [&](double nm, double l) {
      light += l;
      moment += l * nm;
    });
    if (!(light > 0.0) || !(signals[i] > 0.0)) continue;
    total += signals[i];
    sum += signals[i] * moment / light;
  }
  return total > 0.0 ? sum / total : band.wavelength_nm;
}

void CheckFilterOrder(const RigConfig& rig, const std::array<char, kLatticeCount>& colours,
                      const std::vector<BandFrames>& bands) {
  const auto curves = ReadSpectralCurves(rig);
  const bool told =
      std::all_of(colours.begin(), colours.end(), [](char c) { return c == 'R' || c == 'G' || c == 'B'; });
  if (!curves || !told) return;
  for (const BandFrames& band : bands) {
    const auto& seen = band.record.spectralon_colours;
    const double own = Misfit(seen, ColoursOfFilter(*curves, band.record.band, colours));
    double best = own;
    double best_nm = band.record.band.wavelength_nm;
    for (const WheelSlot& slot : rig.slots) {
      if (slot.opaque) continue;
      const double other =
          Misfit(seen, ColoursOfFilter(*curves, {slot.wavelength_nm, slot.fwhm_nm}, colours));
      if (other < best) best = other, best_nm = slot.wavelength_nm;
    }
    if (own <= kAmbiguous || best > kMuchBetter * own) continue;
    const BandCalibration& record = band.record;
    throw CaptureFailure(
        record.spectralon_files[0] + " and " + record.skin_files[0] +
            ": their colours are not those of the filter at " + Short(record.band.wavelength_nm) +
            " nm but look like " + Short(best_nm) +
            " nm; expected each filter in its slot: compare the wheel with the rig's file, then restore the "
            "frames or capture the session again",
        OutlinedFrame(record.picture, record.picture_scale, record.windows[0].corners));
  }
}

}  // namespace dermap
