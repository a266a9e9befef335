// SPDX-License-Identifier: Apache-2.0
// By the slope of ln R between neighbouring bands.
#include "calibrate/effective_wavelength.h"

#include <algorithm>
#include <cmath>

#include "calibrate/filter_order.h"
#include "calibrate/statistics.h"

namespace dermap {
namespace {

// d ln R / d nm at a band.
struct Slope {
  double middle, uncertainty;
};

// Drawn towards none as far as the bands leave it open: a slope that is as uncertain as it is large does no
// good when it is believed whole.
Slope Believed(double slope, double uncertainty) {
  const double belief = slope * slope / (slope * slope + uncertainty * uncertainty + 1e-30);
  return {belief * slope, std::abs(uncertainty) * std::sqrt(belief)};
}

// From a band and its neighbours: the parabola's slope, or the line's at the ends.
Slope LogSlope(const ReflectanceStack& stack, std::size_t band, std::size_t pixel) {
  const auto log_r = [&](std::size_t b) {
    return std::log(std::max(1e-3, double(stack.reflectance[b].data()[pixel])));
  };
  const auto between = [&](std::size_t a, std::size_t b) {
    return (log_r(b) - log_r(a)) / (stack.bands[b].wavelength_nm - stack.bands[a].wavelength_nm);
  };
  if (stack.bands.size() < 2) return {0.0, 0.0};
  if (band == 0) return Believed(between(0, 1), between(0, 1));
  if (band + 1 == stack.bands.size()) return Believed(between(band - 1, band), between(band - 1, band));
  const double left = between(band - 1, band);
  const double right = between(band, band + 1);
  const double width_left = stack.bands[band].wavelength_nm - stack.bands[band - 1].wavelength_nm;
  const double width_right = stack.bands[band + 1].wavelength_nm - stack.bands[band].wavelength_nm;
  return Believed((left * width_right + right * width_left) / (width_left + width_right),
                  0.5 * std::abs(left - right));
}

}  // namespace

void CorrectEffectiveWavelengths(const Session& session, const StepSet& skip, std::vector<BandFrames>& bands,
                                 ReflectanceStack& stack) {
  const auto curves = ReadSpectralCurves(session.rig);
  std::vector<PlaneF> corrected = stack.reflectance;
  std::size_t k = 0;
  for (BandFrames& frames : bands) {
    BandCalibration& record = frames.record;
    if (record.dropped) continue;
    StepRecord step{Step::kEffectiveWavelength, false, 0.0, 0.0,
                    "the rig states no camera_csv and flash_csv"};
    if (curves && record.lattice_colours[0] != 'X' && record.lattice_colours[0] != 'W') {
      record.effective_wavelength_nm =
          EffectiveWavelength(*curves, record.band, record.spectralon_colours, record.lattice_colours);
      const double shift = record.effective_wavelength_nm - record.band.wavelength_nm;
      step.applied = skip.count(Step::kEffectiveWavelength) == 0;
      std::vector<float> effects, doubts;
      for (std::size_t i = 0; i < corrected[k].size(); ++i) {
        const Slope slope = LogSlope(stack, k, i);
        if (!std::isfinite(slope.middle)) continue;
        effects.push_back(static_cast<float>(-shift * slope.middle));
        doubts.push_back(static_cast<float>(std::abs(shift) * slope.uncertainty));
        if (step.applied) corrected[k].data()[i] *= 1.0f + effects.back();
      }
      const double effect = effects.empty() ? 0.0 : Median(std::move(effects));
      step.effect = step.applied ? effect : 0.0;
      step.sigma = step.applied ? Median(std::move(doubts)) : std::abs(effect);
      step.note =
          std::string(step.applied ? "" : "left out: ") + "seen " + Short(shift) + " nm off its centre";
    }
    record.steps.push_back(step);
    ++k;
  }
  stack.reflectance = std::move(corrected);
}

}  // namespace dermap
