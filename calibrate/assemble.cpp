// SPDX-License-Identifier: Apache-2.0
// The stack from its bands: what is left out, what is valid, and the steps that need a band's whole
// reflectance.
#include "calibrate/assemble.h"

#include <algorithm>
#include <cmath>

#include "calibrate/effective_wavelength.h"
#include "calibrate/failure.h"
#include "calibrate/frame_picture.h"
#include "calibrate/statistics.h"

namespace dermap {
namespace {

constexpr double kWindowSizes =
    0.04;  // deviation of a window's size from the bands' median: not the same window
constexpr double kSaturatedNote = 0.001;
constexpr double kAnglesNote = 0.001;     // of reflectance
constexpr double kUnsureWindow_px = 0.3;  // photosites: without structure to align by, such a band is dropped

PlaneF ValidPixels(const std::vector<PlaneF>& reflectance, double edge_mask_px) {
  const int width = reflectance[0].width();
  const int height = reflectance[0].height();
  PlaneF valid(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double edge = 0.5 + std::min({x, y, width - 1 - x, height - 1 - y});
      const bool any = std::any_of(reflectance.begin(), reflectance.end(),
                                   [&](const PlaneF& band) { return !std::isnan(band(x, y)); });
      valid(x, y) = any && edge > edge_mask_px ? 1.0f : 0.0f;
    }
  }
  return valid;
}

double MedianOfValid(const PlaneF& plane, const PlaneF& valid) {
  std::vector<float> values;
  for (std::size_t i = 0; i < plane.size(); ++i) {
    if (valid.data()[i] > 0.0f && !std::isnan(plane.data()[i])) values.push_back(plane.data()[i]);
  }
  return Median(std::move(values));
}

NoiseCorrelation MeanCorrelation(const std::vector<BandCalibration>& bands) {
  NoiseCorrelation mean{std::vector<double>(NoiseCorrelation::kReach + 1), {}, 0.0};
  mean.along_y = mean.along_x;
  const auto kept = std::count_if(bands.begin(), bands.end(), [](const auto& band) { return !band.dropped; });
  for (const BandCalibration& band : bands) {
    if (band.dropped) continue;
    const double share = 1.0 / static_cast<double>(kept);
    for (std::size_t i = 0; i < mean.along_x.size(); ++i) {
      mean.along_x[i] += share * band.correlation.along_x[i];
      mean.along_y[i] += share * band.correlation.along_y[i];
    }
    mean.diagonal += share * band.correlation.diagonal;
  }
  return mean;
}

RigAngles AnglesOf(const RigConfig& rig) {
  return {rig.light_angle_deg, rig.view_angle_deg};
}

// A stack states 0/30, as the model means it; light and camera elsewhere show skin a little darker or
// lighter.
void NoteAngles(const RigConfig& rig, std::vector<std::string>& notes) {
  const double off = AnglesFactor(AnglesOf(rig), kSkinIndex) - 1.0;
  if (std::abs(off) < kAnglesNote) return;
  notes.push_back("light at " + Short(rig.light_angle_deg) + " and camera at " + Short(rig.view_angle_deg) +
                  " degrees: skin's faces let through " + Short(100 * std::abs(off)) + " % " +
                  (off < 0.0 ? "less" : "more") +
                  " than at 0 and 30 degrees, which the stack states; this is not corrected");
}

// Surface light that leaks through the crossed polarizers, then the gel's film.
void CorrectSurface(const Session& session, const StepSet& skip, double median, PatchBand& patch,
                    BandCalibration& record) {
  const RigOptics& optics = session.rig.optics;
  StepRecord leak{Step::kLeak, false, 0.0, 0.0, "the rig states none"};
  if (optics.polarization) {
    const double seen = LeakInReflectance(*optics.polarization, record.band.wavelength_nm,
                                          skip.count(Step::kPolarization) == 0);
    const Known known{optics.polarization->leak.value * seen, optics.polarization->leak.sigma * seen};
    leak.applied = skip.count(Step::kLeak) == 0;
    leak.note = leak.applied ? "" : "left out";
    leak.effect = leak.applied ? -known.value / median : 0.0;
    leak.sigma = (leak.applied ? known.sigma : known.value) / median;
    if (leak.applied) {
      for (float& r : patch.reflectance.values()) r -= static_cast<float>(known.value);
    }
  }
  record.steps.push_back(leak);
  StepRecord gel{Step::kGel, false, 0.0, 0.0, "the rig states none"};
  if (optics.gel) {
    const Known factor = GelFactor(*optics.gel, kSkinIndex, AnglesOf(session.rig), median);
    gel.applied = skip.count(Step::kGel) == 0;
    gel.note = gel.applied ? "" : "left out";
    gel.effect = gel.applied ? factor.value - 1.0 : 0.0;
    gel.sigma = gel.applied ? factor.sigma : std::abs(factor.value - 1.0);
    for (std::size_t i = 0; gel.applied && i < patch.sigma.size(); ++i) {
      patch.reflectance.data()[i] *= static_cast<float>(factor.value);
      patch.sigma.data()[i] *= static_cast<float>(factor.value);
    }
  }
  record.steps.push_back(gel);
}

void FinishRecord(const CalibrationOptions& options, BandCalibration& record) {
  record.steps.push_back({Step::kAlignment, record.alignment.applied, 0.0, 0.0,
                          record.alignment.applied
                              ? "shift " + Short(std::hypot(record.alignment.dx_px, record.alignment.dy_px)) +
                                    " px, known to " + Short(record.alignment.uncertainty_px) + " px"
                          : options.align ? record.alignment.note
                                          : "left out"});
  double square = 0.0;
  for (const StepRecord& step : record.steps) square += step.sigma * step.sigma;
  record.systematic_sigma = std::sqrt(square);
  if (record.saturated_share > kSaturatedNote) {
    record.notes.push_back(Short(100 * record.saturated_share) +
                           " % of the window's photosites are saturated and left out: lower the ISO");
  }
}

// Of the window's cut and of where its edges were found.
double PixelSizeSigma(const Session& session, const std::vector<BandCalibration>& bands,
                      double pixel_size_mm) {
  double square = 0.0;
  double count = 0.0;
  for (const BandCalibration& band : bands) {
    for (const Window& w : band.windows) {
      square += 2.0 * std::pow(w.edge_uncertainty_px / w.smallest_side_px, 2);
      count += 1.0;
    }
  }
  const double found = std::sqrt(square) / std::max(1.0, count);
  return pixel_size_mm * std::hypot(found, session.rig.optics.window_sigma_mm / session.rig.window_mm);
}

}  // namespace

// A window of another size than the other bands' is another thing: that band is left out, by name.
void DropStrangeWindows(std::vector<BandFrames>& bands) {
  std::vector<float> sizes;
  for (const BandFrames& band : bands)
    sizes.push_back(static_cast<float>(band.record.windows[0].largest_side_px));
  const double usual = Median(sizes);
  for (BandFrames& band : bands) {
    for (const Window& window : band.record.windows) {
      if (band.record.dropped || std::abs(window.largest_side_px / usual - 1.0) <= kWindowSizes) continue;
      band.record.dropped = true;
      band.record.notes.push_back("left out: its window is " + Short(window.largest_side_px) +
                                  " photosites wide, that of the other bands " + Short(usual));
    }
  }
}

void DropUnalignable(std::vector<BandFrames>& bands) {
  for (BandFrames& band : bands) {
    BandCalibration& record = band.record;
    if (record.dropped || record.alignment.applied) continue;
    for (const Window& window : record.windows) {
      if (window.edge_uncertainty_px <= kUnsureWindow_px || record.dropped) continue;
      record.dropped = true;
      record.notes.push_back("left out: it cannot be aligned; its window is known to " +
                             Short(window.edge_uncertainty_px) +
                             " photosites only, and it shares too little structure with the other bands");
    }
  }
}

void NoteMissingBands(const Session& session, const std::vector<Band>& bands,
                      std::vector<std::string>& notes) {
  if (!session.complete)
    notes.push_back("the session is not complete: some planned frames were never captured");
  for (const WheelSlot& slot : session.rig.slots) {
    const bool planned = std::any_of(session.plan.exposures.begin(), session.plan.exposures.end(),
                                     [&](const auto& e) { return e.slot == slot.slot; });
    const bool there = std::any_of(bands.begin(), bands.end(),
                                   [&](const Band& b) { return b.wavelength_nm == slot.wavelength_nm; });
    if (planned && !slot.opaque && !there)
      notes.push_back("no skin frame at " + Short(slot.wavelength_nm) + " nm");
  }
}

void SetDriftUncertainty(const std::vector<SkinMosaic>& skins, const std::map<int, NoiseModel>& models,
                         BandCalibration& record) {
  if (skins.empty()) return;
  double worst = 0.0;
  for (const SkinMosaic& skin : skins) {
    double a = 0, b = 0, variance_a = 0, variance_b = 0;
    const NoiseModel& of_skin = ModelOf(models, skin.skin_iso);
    const NoiseModel& of_white = ModelOf(models, skin.spectralon_iso);
    for (int i = 0; i < kMostKinds; ++i) {
      a += skin.card.count[i] * skin.card.mean_a[i];
      b += skin.card.count[i] * skin.card.mean_b[i];
      variance_a += skin.card.count[i] * of_skin.Variance(skin.card.mean_a[i]);
      variance_b += skin.card.count[i] * of_white.Variance(skin.card.mean_b[i]) / skin.spectralon_frames;
    }
    worst = std::max(worst, std::sqrt(variance_a / (a * a) + variance_b / (b * b)));
  }
  for (StepRecord& step : record.steps) {
    if (step.step == Step::kFlashDrift && step.applied) step.sigma = worst;
  }
}

void Assemble(std::vector<BandFrames>& bands, std::vector<PatchBand>& patches, const Session& session,
              const CalibrationOptions& options, CalibrationResult& result) {
  ReflectanceStack& stack = result.stack;
  std::vector<PlaneF> seen;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    if (!bands[i].record.dropped) seen.push_back(patches[i].reflectance);
  }
  if (seen.empty()) {
    const BandCalibration& first = bands[0].record;
    throw CaptureFailure(session.directory.string() +
                             ": no band is left after alignment; expected windows of one size that "
                             "show one patch of skin: capture the session again",
                         OutlinedFrame(first.picture, first.picture_scale, first.windows[0].corners));
  }
  stack.valid = ValidPixels(seen, options.edge_mask_px);
  for (std::size_t i = 0; i < bands.size(); ++i) {
    if (bands[i].record.dropped) continue;
    CorrectSurface(session, options.skip, MedianOfValid(patches[i].reflectance, stack.valid), patches[i],
                   bands[i].record);
    stack.bands.push_back(bands[i].record.band);
    stack.reflectance.push_back(std::move(patches[i].reflectance));
    stack.sigma.push_back(std::move(patches[i].sigma));
  }
  CorrectEffectiveWavelengths(session, options.skip, bands, stack);
  stack.pixel_size_mm = session.rig.window_mm / options.patch_px;
  stack.illumination = Illumination::kWindow;
  stack.tape = Tape::kFree;
  stack.geometry = Geometry::kFactor0_30;
  NoteAngles(session.rig, result.notes);
  std::size_t k = 0;
  for (BandFrames& band : bands) {
    if (!band.record.dropped) {
      band.record.median_reflectance = MedianOfValid(stack.reflectance[k], stack.valid);
      band.record.median_noise = MedianOfValid(stack.sigma[k], stack.valid);
      ++k;
    }
    FinishRecord(options, band.record);
    result.bands.push_back(std::move(band.record));
  }
  result.pixel_size_sigma_mm = PixelSizeSigma(session, result.bands, stack.pixel_size_mm.value());
  result.correlation = MeanCorrelation(result.bands);
  const auto lags = [](const std::vector<double>& from_zero) {
    return std::vector<float>(from_zero.begin() + 1, from_zero.end());
  };
  stack.noise_correlation_x = lags(result.correlation.along_x);
  stack.noise_correlation_y = lags(result.correlation.along_y);
}

}  // namespace dermap
