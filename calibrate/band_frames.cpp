// SPDX-License-Identifier: Apache-2.0
// Normalisation of one band: skin over Spectralon, the flash's drift by the gray card [D08 6.1], the window.
#include "calibrate/band_frames.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calibrate/band_steps.h"
#include "calibrate/failure.h"
#include "calibrate/frame_checks.h"
#include "calibrate/frame_picture.h"
#include "calibrate/spectralon.h"
#include "calibrate/statistics.h"
#include "common/core/error.h"
#include "common/core/kernel.h"

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

// Photosites within the window.
double AreaOf(const Window& window, const Lens& lens) {
  double twice = 0.0;
  for (std::size_t i = 0; i < window.corners.size(); ++i) {
    const Point a = lens.PhotositesFromIdeal(window.corners[i]);
    const Point b = lens.PhotositesFromIdeal(window.corners[(i + 1) % window.corners.size()]);
    twice += a.x * b.y - b.x * a.y;
  }
  return std::max(1.0, 0.5 * std::abs(twice));
}

// Shares of saturated and of masked photosites within the window.
void CountMasked(const Mosaic& mosaic, const Window& window, BandCalibration& record) {
  const Homography unit_from_camera = window.camera_from_unit.Inverse();
  int saturated = 0, masked = 0;
  for (int y = 0; y < mosaic.height(); ++y) {
    for (int x = 0; x < mosaic.width(); ++x) {
      if (mosaic.mask(x, y) == 0) continue;
      const Point p =
          unit_from_camera(mosaic.lens.IdealFromPhotosites({mosaic.x0 + x + 0.5, mosaic.y0 + y + 0.5}));
      if (p.x < 0 || p.y < 0 || p.x > 1 || p.y > 1) continue;
      if ((mosaic.mask(x, y) & kPhotositeSaturated) != 0) ++saturated;
      ++masked;
    }
  }
  const double inside = AreaOf(window, mosaic.lens);
  record.saturated_share = std::max(record.saturated_share, std::min(1.0, saturated / inside));
  record.masked_share = std::max(record.masked_share, std::min(1.0, masked / inside));
}

DERMAP_KERNEL void OrInto(const std::uint8_t* from, std::size_t count, std::uint8_t* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] |= from[i];
}

// Moves the signals, which are of the frame's size, out of their frames: Spectralon's must be given back.
SkinMosaic MakeMosaic(const SessionContext& context, SignalFrame& skin, SignalFrame& spectralon,
                      int spectralon_frames) {
  SkinMosaic out;
  out.mosaic.period = skin.period;
  out.mosaic.skin = std::move(skin.signal);
  out.mosaic.spectralon = std::move(spectralon.signal);
  out.mosaic.mask = std::move(skin.mask);
  OrInto(spectralon.mask.data(), out.mosaic.mask.size(), out.mosaic.mask.data());
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

// One skin frame beside the Spectralon: window, stray light, scale.
SkinMosaic PrepareSkin(const SessionContext& context, SignalFrame& skin, SignalFrame& spectralon,
                       const OfKinds& spectralon_means, int spectralon_frames, const Known& certificate,
                       BandCalibration& record) {
  const GrayCardRatio card = CompareGrayCard(skin, spectralon, context.gray_card);
  const double drift = card.ratio * spectralon.record.iso / skin.record.iso;
  AddNotes(CheckCard(skin, spectralon, card, drift, context.gray_card), record.notes);
  const FrameMeans frames{KindMeans(skin), spectralon_means};
  if (record.picture.empty()) {
    FramePicture picture = PictureOf(skin.signal);
    record.picture = std::move(picture.picture);
    record.picture_scale = picture.scale;
  }
  SkinMosaic whole = MakeMosaic(context, skin, spectralon, spectralon_frames);
  whole.card = card;
  whole.mosaic.scale = certificate.value / card.ratio;
  const auto& polarization = context.session.rig.optics.polarization;
  if (polarization && context.skip.count(Step::kLeak) == 0)
    whole.mosaic.surface =
        polarization->leak.value / SpectralonSignal(*polarization, record.band.wavelength_nm);
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
  SignalFrame spectralon = MeanSpectralon(std::move(whites), context.gray_card);
  const OfKinds means = KindMeans(spectralon);
  // A lattice of a longer pattern has no colour of its own.
  if (spectralon.period == 2) std::copy_n(means.begin(), kLatticeCount, record.spectralon_colours.begin());
  record.lattice_colours = context.blacks.sensor().colours;
  AddNotes(spectralon.notes, record.notes);
  for (const FrameRecord& frame : context.session.frames) {
    if (frame.role != FrameRole::kSkin || frame.wavelength_nm != band.wavelength_nm) continue;
    SignalFrame skin = ReadSignal(frame, context.read, context.blacks);
    CheckLit(skin, context.gray_card, context.blacks.FullScale(*skin.black));
    record.skin_files.push_back(frame.file);
    AddNotes(skin.notes, record.notes);
    AddTransferPoints(skin, spectralon, white_frames, context.gray_card, out);
    out.skins.push_back(PrepareSkin(context, skin, spectralon, means, white_frames, certificate, record));
  }
  return out;
}

}  // namespace dermap
