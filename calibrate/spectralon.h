// SPDX-License-Identifier: Apache-2.0
// The Spectralon panel: what its certificate says for a band, and the mean of its frames.
#pragma once

#include <vector>

#include "calibrate/gray_card.h"
#include "common/files/rig.h"
#include "common/spectra/sampled_spectrum.h"
#include "common/transport/conditions.h"

namespace dermap {

// The rig's certificate: a CSV with the column `reflectance`, relative to the configuration folder unless
// absolute.
SampledSpectrum ReadCertificate(const RigConfig& rig);

// Mean of the certificate over the band's filter (Gaussian, cut at two widths from its centre).
double CertifiedReflectance(const SampledSpectrum& certificate, const Band& band);

// Mean of repeats, each brought to the flash of the first by the gray card; masks are joined.
SignalFrame MeanSpectralon(std::vector<SignalFrame> frames, const PixelRegion& gray_card);

}  // namespace dermap
