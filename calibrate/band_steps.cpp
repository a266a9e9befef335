// SPDX-License-Identifier: Apache-2.0
// Linearity, stray light, drift, certificate and polarization of one band [D08 6.1, 6.4].
#include "calibrate/band_steps.h"

#include <algorithm>
#include <cmath>

#include "calibrate/statistics.h"

namespace dermap {
namespace {

StepRecord LinearityStep(const SessionContext& context, const SignalFrame& skin, const MiddleMeans& means) {
  StepRecord step{Step::kLinearity, false, 0.0, 0.0, context.linearity.note};
  const auto& known = context.linearity.used;
  if (!known) return step;
  const double scale = context.blacks.FullScale(*skin.black);
  const double difference = (means.skin_square - means.spectralon_square) / scale;
  step.applied = context.skip.count(Step::kLinearity) == 0;
  if (!step.applied) step.note = "left out: " + step.note;
  step.effect = step.applied ? known->value * difference : 0.0;
  step.sigma = step.applied ? known->sigma * std::abs(difference) : std::abs(known->value * difference);
  return step;
}

// Each frame's offset drifts by itself; where black frames are left out, it is as far off as the file's level
// is.
StepRecord BlackStep(const SessionContext& context, const SignalFrame& skin, const MiddleMeans& means) {
  const double black = skin.black->level_dn;
  const double with = means.skin / means.spectralon;
  const double without = (means.skin + black) / (means.spectralon + black);
  const double drift = kBlackDrift_dn * std::hypot(1.0 / means.skin, 1.0 / means.spectralon);
  StepRecord step{Step::kBlack, context.blacks.options().subtract_black, with / without - 1.0, drift,
                  Short(black) + " DN"};
  if (step.applied) return step;
  const double stated = context.blacks.sensor().black_level;
  step.note = "left out: the level that the file states was subtracted, " + Short(stated) + " DN";
  step.sigma = std::hypot(drift, (black - stated) * (1.0 / means.skin - 1.0 / means.spectralon));
  return step;
}

}  // namespace

MiddleMeans MeansOf(const Mosaic& mosaic) {
  MiddleMeans sum;
  for (int y = mosaic.height() / 4; y < mosaic.height() * 3 / 4; ++y) {
    for (int x = mosaic.width() / 4; x < mosaic.width() * 3 / 4; ++x) {
      if (mosaic.mask(x, y) != 0) continue;
      sum.skin += mosaic.skin(x, y);
      sum.spectralon += mosaic.spectralon(x, y);
      sum.skin_square += double(mosaic.skin(x, y)) * mosaic.spectralon(x, y);
      sum.spectralon_square += double(mosaic.spectralon(x, y)) * mosaic.spectralon(x, y);
    }
  }
  const double count = std::max(1.0, double(mosaic.width()) * mosaic.height() / 4.0);
  return {sum.skin / count, sum.spectralon / count, sum.skin_square / sum.spectralon,
          sum.spectralon_square / sum.spectralon};
}

void AddFrameSteps(const SessionContext& context, const SignalFrame& skin, const MiddleMeans& means,
                   BandCalibration& record) {
  record.steps.push_back(BlackStep(context, skin, means));
  const bool hot = context.blacks.options().mask_hot;
  record.steps.push_back(
      {Step::kHotPhotosites, hot, 0.0, 0.0,
       hot ? Short(100 * context.blacks.hot_share()) + " % of the sensor masked" : "left out"});
  record.steps.push_back(LinearityStep(context, skin, means));
}

double CorrectStrayLight(const SessionContext& context, const Window& window, const FrameMeans& frames,
                         double certificate, const MiddleMeans& means, SkinMosaic& skin,
                         BandCalibration& record) {
  const auto& tape = context.session.rig.optics.tape_reflectance;
  const auto& stated = context.session.rig.optics.stray_light;
  // The tape's reflectance is meant as the camera sees it, behind its polarizer; Spectralon's signal is not
  // its mean.
  const auto& polarization = context.session.rig.optics.polarization;
  const double seen = polarization ? SpectralonSignal(*polarization, record.band.wavelength_nm) : 1.0;
  const StrayLight found = EstimateStrayLight(skin.mosaic, window, frames, skin.card, certificate * seen,
                                              tape, stated.value_or(kUsualStrayLight));
  StepRecord step{Step::kStrayLight, false, 0.0, 0.0, ""};
  if (!tape && !stated) {
    step.note = "the rig states neither stray_light nor tape_reflectance; the tape seems to reflect " +
                Short(found.tape) + ", its own reflectance and the lens's stray light together";
    record.steps.push_back(step);
    return skin.card.ratio;
  }
  const auto effect = [&](double share) {
    double off_skin = 0.0, off_white = 0.0;
    const int kinds = skin.mosaic.period * skin.mosaic.period;
    for (int i = 0; i < kinds; ++i) {
      off_skin += share * frames.skin[i] / kinds;
      off_white += share * frames.spectralon[i] / kinds;
    }
    const double of_card = skin.card.ratio / CardRatioWithout(share, frames, skin.card);
    return of_card * (means.skin - off_skin) / means.skin * means.spectralon /
               (means.spectralon - off_white) -
           1.0;
  };
  step.sigma = std::abs(effect(found.share.value + found.share.sigma) - effect(found.share.value));
  if (context.skip.count(Step::kStrayLight) != 0) {
    step.note = "left out";
    step.sigma = std::abs(effect(found.share.value));
    record.steps.push_back(step);
    return skin.card.ratio;
  }
  step.applied = true;
  step.effect = effect(found.share.value);
  step.note =
      Short(100 * found.share.value) + " +- " + Short(100 * found.share.sigma) + " % of the frame's mean";
  RemoveStrayLight(found.share.value, frames, skin.mosaic);
  record.steps.push_back(step);
  return found.card_ratio;
}

void SetScale(const SessionContext& context, double card_ratio, const Known& certificate, SkinMosaic& skin,
              BandCalibration& record) {
  const double iso = double(skin.skin_iso) / skin.spectralon_iso;
  const double drift = card_ratio / iso;
  record.gray_card_drift.push_back(drift);
  const bool follow = context.skip.count(Step::kFlashDrift) == 0;
  record.steps.push_back({Step::kFlashDrift, follow, follow ? 1.0 / drift - 1.0 : 0.0,
                          follow ? 0.0 : std::abs(drift - 1.0), follow ? "" : "left out"});
  const bool certified = context.skip.count(Step::kCertificate) == 0;
  record.steps.push_back({Step::kCertificate, certified, certified ? certificate.value - 1.0 : 0.0,
                          certified ? certificate.sigma : std::abs(certificate.value - 1.0),
                          certified ? "" : "left out: Spectralon counts as 1"});
  skin.mosaic.scale = (certified ? certificate.value : 1.0) / (follow ? card_ratio : iso);
  const auto& polarization = context.session.rig.optics.polarization;
  StepRecord step{Step::kPolarization, false, 0.0, 0.0, "the rig states none"};
  if (polarization) {
    const Known factor = PolarizationFactor(*polarization, record.band.wavelength_nm);
    step.applied = context.skip.count(Step::kPolarization) == 0;
    step.effect = step.applied ? factor.value - 1.0 : 0.0;
    step.sigma = step.applied ? factor.sigma / factor.value : std::abs(factor.value - 1.0);
    step.note = step.applied ? "" : "left out";
    if (step.applied) skin.mosaic.scale *= factor.value;
  }
  record.steps.push_back(step);
}

}  // namespace dermap
