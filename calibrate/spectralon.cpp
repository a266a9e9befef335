// SPDX-License-Identifier: Apache-2.0
// Reference frames of the white panel [D08 6.1].
#include "calibrate/spectralon.h"

#include <cassert>
#include <cmath>

#include "calibrate/statistics.h"
#include "common/core/error.h"
#include "common/tissue/tissue.h"

namespace dermap {
namespace {

constexpr double kWidthsOfFilter = 2.0;  // of its full width at half maximum; 2e-5 of a Gaussian lies beyond
constexpr int kStepsOfFilter = 80;
constexpr double kMostReflectance = 1.2;  // a certificate in percent is not taken for one in shares

}  // namespace

SampledSpectrum ReadCertificate(const RigConfig& rig) {
  const std::filesystem::path path =
      rig.spectralon_csv.is_absolute() ? rig.spectralon_csv : ConfigDirectory() / rig.spectralon_csv;
  SampledSpectrum certificate = ReadSpectrumCsv(path, "reflectance");
  for (const double value : certificate.values()) {
    if (value > 0.0 && value <= kMostReflectance) continue;
    throw InputError(path.string() + ": a reflectance of " + Short(value) +
                     "; expected shares above 0 and up to " + Short(kMostReflectance) +
                     ": divide percent by 100");
  }
  return certificate;
}

double CertifiedReflectance(const SampledSpectrum& certificate, const Band& band) {
  if (band.wavelength_nm < certificate.first_nm() || band.wavelength_nm > certificate.last_nm()) {
    throw InputError(
        "the panel's certificate reaches from " + Short(certificate.first_nm()) + " to " +
        Short(certificate.last_nm()) + " nm, and the session has a band at " + Short(band.wavelength_nm) +
        " nm; expected a certificate of all bands: name another one as spectralon_csv of the rig");
  }
  if (band.fwhm_nm <= 0.0) return certificate.At(band.wavelength_nm);
  double sum = 0.0;
  double total = 0.0;
  for (int i = -kStepsOfFilter; i <= kStepsOfFilter; ++i) {
    const double widths = kWidthsOfFilter * i / kStepsOfFilter;
    const double nm = band.wavelength_nm + widths * band.fwhm_nm;
    if (nm < certificate.first_nm() || nm > certificate.last_nm()) continue;
    const double weight = std::exp(-4.0 * std::log(2.0) * widths * widths);
    sum += weight * certificate.At(nm);
    total += weight;
  }
  return total > 0.0 ? sum / total : certificate.At(band.wavelength_nm);
}

SignalFrame MeanSpectralon(std::vector<SignalFrame> frames, const PixelRegion& gray_card) {
  assert(!frames.empty());
  std::vector<float> to_first{1.0f};
  for (std::size_t k = 1; k < frames.size(); ++k)
    to_first.push_back(static_cast<float>(1.0 / CompareGrayCard(frames[k], frames[0], gray_card).ratio));
  SignalFrame mean = std::move(frames[0]);
  if (frames.size() == 1) return mean;
  for (std::size_t k = 1; k < frames.size(); ++k) {
    for (std::size_t i = 0; i < mean.signal.size(); ++i) {
      mean.signal.data()[i] += to_first[k] * frames[k].signal.data()[i];
      mean.mask.data()[i] |= frames[k].mask.data()[i];
    }
    mean.notes.insert(mean.notes.end(), frames[k].notes.begin(), frames[k].notes.end());
  }
  for (float& value : mean.signal.values()) value /= static_cast<float>(frames.size());
  return mean;
}

}  // namespace dermap
