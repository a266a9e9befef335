// SPDX-License-Identifier: Apache-2.0
// Normalisation of one band: skin over Spectralon, the flash's drift by the gray card [D08 6.1], the window.
#include "calibrate/band_frames.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calibrate/failure.h"
#include "calibrate/frame_checks.h"
#include "calibrate/frame_picture.h"
#include "calibrate/spectralon.h"
#include "calibrate/statistics.h"
#include "calibrate/stray_light.h"
#include "common/core/error.h"

namespace dermap {
namespace {

constexpr double kWindowMargin_px = 16.0;  // around the window's corners, at least
constexpr double kBrightTarget = 0.2;      // reflectance: tape from edge to edge is darker
constexpr double kWindowMargin = 0.08;     // of the window's side: tape enough to tell the stray light

std::vector<SignalFrame> ReadRole(const SessionContext& context, FrameRole role, double wavelength_nm) {
  std::vector<SignalFrame> frames;
  for (const FrameRecord& record : context.session.frames) {
    if (record.role != role || record.wavelength_nm != wavelength_nm) continue;
    frames.push_back(ReadSignal(record, context.read, context.blacks));
    CheckLit(frames.back(), context.gray_card, context.blacks.FullScale(*frames.back().black));
  }
  return frames;
}

void AddNotes(const std::vector<std::string>& from, std::vector<std::string>& to) {
  for (const auto& note : from) {
    if (std::find(to.begin(), to.end(), note) == to.end()) to.push_back(note);
  }
}

void AddTransferPoints(const SignalFrame& skin, const SignalFrame& spectralon, int spectralon_frames,
                       const PixelRegion& card, BandFrames& out) {
  const auto append = [](std::vector<PhotonTransferPoint>& to,
                         const std::vector<PhotonTransferPoint>& points) {
    to.insert(to.end(), points.begin(), points.end());
  };
  if (skin.record.iso == spectralon.record.iso) {
    append(out.pairs, PhotonTransfer(skin, spectralon, spectralon_frames, card));
  } else {
    append(out.singles, PhotonTransferOfOne(skin, card));
    if (spectralon_frames == 1) append(out.singles, PhotonTransferOfOne(spectralon, card));
  }
}

// Shares of saturated and of masked photosites within the window.
void CountMasked(const Mosaic& mosaic, const Window& window, BandCalibration& record) {
  const Homography unit_from_camera = window.camera_from_unit.Inverse();
  int inside = 0, saturated = 0, masked = 0;
  for (int y = 0; y < mosaic.height(); ++y) {
    for (int x = 0; x < mosaic.width(); ++x) {
      const Point p =
          unit_from_camera(mosaic.lens.IdealFromPhotosites({mosaic.x0 + x + 0.5, mosaic.y0 + y + 0.5}));
      if (p.x < 0 || p.y < 0 || p.x > 1 || p.y > 1) continue;
      ++inside;
      if ((mosaic.mask(x, y) & kPhotositeSaturated) != 0) ++saturated;
      if (mosaic.mask(x, y) != 0) ++masked;
    }
  }
  record.saturated_share = std::max(record.saturated_share, double(saturated) / std::max(1, inside));
  record.masked_share = std::max(record.masked_share, double(masked) / std::max(1, inside));
}

// Moves the signals, which are of the frame's size, out of their frames: Spectralon's must be given back.
SkinMosaic MakeMosaic(const SessionContext& context, SignalFrame& skin, SignalFrame& spectralon,
                      int spectralon_frames) {
  SkinMosaic out;
  out.mosaic.period = skin.period;
  out.mosaic.skin = std::move(skin.signal);
  out.mosaic.spectralon = std::move(spectralon.signal);
  out.mosaic.mask = std::move(skin.mask);
  for (std::size_t i = 0; i < out.mosaic.mask.size(); ++i)
    out.mosaic.mask.data()[i] |= spectralon.mask.data()[i];
  const RigOptics& optics = context.session.rig.optics;
  const double width = out.mosaic.width(), height = out.mosaic.height();
  out.mosaic.lens = {0.5 * width, 0.5 * height, 0.5 * std::hypot(width, height), optics.distortion_k1,
                     optics.distortion_k2};
  out.skin_iso = skin.record.iso;
  out.spectralon_iso = spectralon.record.iso;
  out.spectralon_frames = spectralon_frames;
  if (skin.black == spectralon.black) {
    out.shared_black = 1.0 / skin.black->frames;
  } else {
    out.skin_black = 1.0 / skin.black->frames;
    out.spectralon_black = 1.0 / spectralon.black->frames;
  }
  return out;
}

// Means of the window's middle, for what the steps did.
struct MiddleMeans {
  double skin = 0.0, spectralon = 0.0;
  double skin_square = 0.0,
         spectralon_square = 0.0;  // weighted by the signals themselves: Spectralon's strong ones
};

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

// The window, or what stands in its place.
Window WindowOf(const SessionContext& context, const SkinMosaic& whole, const std::string& file) {
  try {
    return FindWindow(whole.mosaic, context.gray_card, context.session.rig.window_mm, file);
  } catch (const CaptureFailure& failure) {
    const MiddleMeans means = MeansOf(whole.mosaic);
    const bool bright = whole.mosaic.scale * means.skin > kBrightTarget * means.spectralon;
    if (!bright || !EvenlyBright(whole.mosaic.skin, context.gray_card)) throw;
    throw CaptureFailure(
        file +
            ": there is no window in this skin frame, but an evenly bright target, as in a Spectralon frame; "
            "expected skin through a window in black tape: were two frames swapped, or was the tape "
            "forgotten? "
            "Restore them or capture this frame again",
        failure.picture());
  }
}

// Returns the whole Spectralon signal.
PlaneF CropToWindow(const Window& window, Mosaic& mosaic) {
  double left = 1e30, top = 1e30, right = -1e30, bottom = -1e30;
  for (const Point& corner : window.corners) {
    const Point p = mosaic.lens.PhotositesFromIdeal(corner);
    left = std::min(left, p.x), right = std::max(right, p.x);
    top = std::min(top, p.y), bottom = std::max(bottom, p.y);
  }
  const double margin = std::max(kWindowMargin_px, kWindowMargin * window.largest_side_px);
  Mosaic crop = Crop(mosaic, left - margin, top - margin, right + margin, bottom + margin);
  std::swap(mosaic, crop);
  return std::move(crop.spectralon);
}

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

// What the black frames and the mask of hot photosites did.
void AddFrameSteps(const SessionContext& context, const SignalFrame& skin, const MiddleMeans& means,
                   BandCalibration& record) {
  const double black = skin.black->level_dn;
  const double with = means.skin / means.spectralon;
  const double without = (means.skin + black) / (means.spectralon + black);
  StepRecord subtracted{Step::kBlack, context.blacks.options().subtract_black, with / without - 1.0, 0.0, ""};
  if (!subtracted.applied) subtracted.note = "left out: the file's own black level was subtracted";
  subtracted.note += subtracted.note.empty() ? Short(black) + " DN" : "";
  record.steps.push_back(subtracted);
  const bool hot = context.blacks.options().mask_hot;
  record.steps.push_back(
      {Step::kHotPhotosites, hot, 0.0, 0.0,
       hot ? Short(100 * context.blacks.hot_share()) + " % of the sensor masked" : "left out"});
  record.steps.push_back(LinearityStep(context, skin, means));
}

// Stray light off the mosaic; the gray card's ratio without it.
double CorrectStrayLight(const SessionContext& context, const Window& window, const FrameMeans& frames,
                         double certificate, const MiddleMeans& means, SkinMosaic& skin,
                         BandCalibration& record) {
  const auto& tape = context.session.rig.optics.tape_reflectance;
  // The tape's reflectance is meant as the camera sees it, behind its polarizer; Spectralon's signal is not
  // its mean.
  const auto& polarization = context.session.rig.optics.polarization;
  const double seen = polarization ? SpectralonSignal(*polarization, record.band.wavelength_nm) : 1.0;
  const StrayLight found =
      EstimateStrayLight(skin.mosaic, window, frames, skin.card, certificate * seen, tape.value_or(Known{}));
  StepRecord step{Step::kStrayLight, false, 0.0, 0.0, ""};
  if (tape && skin.mosaic.period != 2) {
    step.note = "not possible with this filter pattern: a lattice holds several colours";
    record.steps.push_back(step);
    return skin.card.ratio;
  }
  if (!tape) {
    step.note = "the rig states no tape_reflectance; the tape seems to reflect " + Short(found.tape) +
                ", its own reflectance and the lens's stray light together";
    record.steps.push_back(step);
    return skin.card.ratio;
  }
  const auto effect = [&](double share) {
    double off_skin = 0.0, off_white = 0.0;
    for (int i = 0; i < kLatticeCount; ++i) {
      off_skin += share * frames.skin[i] / kLatticeCount;
      off_white += share * frames.spectralon[i] / kLatticeCount;
    }
    return (means.skin - off_skin) / means.skin * means.spectralon / (means.spectralon - off_white) - 1.0;
  };
  step.sigma = std::abs(effect(found.share.value + found.share.sigma) - effect(found.share.value));
  if (context.skip.count(Step::kStrayLight) != 0) {
    step.note = "left out";
    step.sigma = std::abs(effect(found.share.value));
    record.steps.push_back(step);
    return skin.card.ratio;
  }
  step.applied = true;
  step.effect = effect(found.share.value) + skin.card.ratio / found.card_ratio - 1.0;
  step.note =
      Short(100 * found.share.value) + " +- " + Short(100 * found.share.sigma) + " % of the frame's mean";
  RemoveStrayLight(found.share.value, frames, skin.mosaic);
  record.steps.push_back(step);
  return found.card_ratio;
}

// The scale that makes the mosaic's ratio a reflectance: drift, certificate, polarization.
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

// One skin frame beside the Spectralon: window, stray light, scale.
SkinMosaic PrepareSkin(const SessionContext& context, SignalFrame& skin, SignalFrame& spectralon,
                       int spectralon_frames, const Known& certificate, BandCalibration& record) {
  const GrayCardRatio card = CompareGrayCard(skin, spectralon, context.gray_card);
  const double drift = card.ratio * spectralon.record.iso / skin.record.iso;
  AddNotes(CheckCard(skin, spectralon, card, drift, context.gray_card), record.notes);
  const FrameMeans frames{LatticeMeans(skin), LatticeMeans(spectralon)};
  if (record.picture.empty()) {
    FramePicture picture = PictureOf(skin.signal);
    record.picture = std::move(picture.picture);
    record.picture_scale = picture.scale;
  }
  SkinMosaic whole = MakeMosaic(context, skin, spectralon, spectralon_frames);
  whole.card = card;
  whole.mosaic.scale = certificate.value / card.ratio;
  const Window window = WindowOf(context, whole, skin.record.file);
  spectralon.signal = CropToWindow(window, whole.mosaic);
  MarkDead(whole.mosaic.spectralon, whole.mosaic.period, whole.mosaic.mask);
  record.windows.push_back(window);
  record.steps.clear();  // of the last skin frame; all frames of a band share them but for the drift
  const MiddleMeans means = MeansOf(whole.mosaic);
  AddFrameSteps(context, skin, means, record);
  const double ratio = CorrectStrayLight(context, window, frames, certificate.value, means, whole, record);
  SetScale(context, ratio, certificate, whole, record);
  CountMasked(whole.mosaic, window, record);
  return whole;
}

}  // namespace

std::vector<Band> BandsOfSession(const Session& session) {
  std::vector<Band> bands;
  for (const FrameRecord& record : session.frames) {
    if (record.role != FrameRole::kSkin) continue;
    const bool known = std::any_of(bands.begin(), bands.end(),
                                   [&](const Band& b) { return b.wavelength_nm == record.wavelength_nm; });
    if (!known) bands.push_back({record.wavelength_nm, record.fwhm_nm});
  }
  if (bands.empty()) {
    throw InputError(session.directory.string() +
                     ": the session has no skin frame; expected at least one a filter: "
                     "resume the capture");
  }
  std::sort(bands.begin(), bands.end(),
            [](const Band& a, const Band& b) { return a.wavelength_nm < b.wavelength_nm; });
  return bands;
}

BandFrames PrepareBand(const SessionContext& context, const Band& band, const Known& certificate) {
  BandFrames out;
  BandCalibration& record = out.record;
  record.band = band;
  record.certified_reflectance = certificate.value;
  auto whites = ReadRole(context, FrameRole::kSpectralon, band.wavelength_nm);
  if (whites.empty()) {
    throw InputError(context.session.directory.string() + ": there is no Spectralon frame for " +
                     Short(band.wavelength_nm) +
                     " nm, but a skin frame; every filter needs both: resume the capture");
  }
  for (const SignalFrame& white : whites) {
    record.spectralon_files.push_back(white.record.file);
    CheckSpectralon(white, context.gray_card);
  }
  const auto white_frames = static_cast<int>(whites.size());
  record.spectralon_colours = LatticeMeans(whites[0]);
  record.lattice_colours = context.blacks.sensor().colours;
  SignalFrame spectralon = MeanSpectralon(std::move(whites), context.gray_card);
  AddNotes(spectralon.notes, record.notes);
  for (const FrameRecord& frame : context.session.frames) {
    if (frame.role != FrameRole::kSkin || frame.wavelength_nm != band.wavelength_nm) continue;
    SignalFrame skin = ReadSignal(frame, context.read, context.blacks);
    CheckLit(skin, context.gray_card, context.blacks.FullScale(*skin.black));
    record.skin_files.push_back(frame.file);
    AddNotes(skin.notes, record.notes);
    AddTransferPoints(skin, spectralon, white_frames, context.gray_card, out);
    out.skins.push_back(PrepareSkin(context, skin, spectralon, white_frames, certificate, record));
  }
  return out;
}

}  // namespace dermap
