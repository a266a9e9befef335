// SPDX-License-Identifier: Apache-2.0
// Normalisation of one band: skin over Spectralon, the flash's drift by the gray card [D08 6.1], the window.
#include "calibrate/band_frames.h"

#include <algorithm>
#include <cmath>

#include "calibrate/spectralon.h"
#include "calibrate/statistics.h"
#include "common/core/error.h"
#include "common/files/picture.h"

namespace dermap {
namespace {

constexpr double kDarkCard = 0.005;        // of full scale: no flash at all
constexpr double kDarkAgainst = 0.2;       // of the Spectralon frame's card: the flash did not fire
constexpr double kWeakFlash = 0.7;         // outside of this and its inverse the flash had not recycled
constexpr double kUnevenCard = 0.03;       // of the card's ratio: something shades it, or it moved
constexpr double kWindowMargin_px = 14.0;  // around the window's corners
constexpr int kPictureWidth = 480;

double FullScale(const SessionContext& context, const SignalFrame& frame) {
  return context.blacks.sensor().white_level -
         Median({frame.black->mean.values().begin(), frame.black->mean.values().end()});
}

[[noreturn]] void FlashFailed(const SignalFrame& frame, const std::string& found) {
  throw InputError(
      frame.record.file + ": the flash did not fire (" + found +
      "); expected a gray card as bright as in the other frames: wait for the flash to recycle, check its "
      "batteries and cable, and capture this frame again");
}

void CheckFlash(const SessionContext& context, const SignalFrame& frame) {
  const double signal = GrayCardSignal(frame, context.gray_card);
  const double share = signal / FullScale(context, frame);
  if (share < kDarkCard) FlashFailed(frame, "the gray card is at " + Short(100 * share) + " % of full scale");
}

std::vector<SignalFrame> ReadRole(const SessionContext& context, FrameRole role, double wavelength_nm) {
  std::vector<SignalFrame> frames;
  for (const FrameRecord& record : context.session.frames) {
    if (record.role != role || record.wavelength_nm != wavelength_nm) continue;
    frames.push_back(ReadSignal(record, context.read, context.blacks));
    CheckFlash(context, frames.back());
  }
  return frames;
}

void AddNotes(const std::vector<std::string>& from, std::vector<std::string>& to) {
  for (const auto& note : from) {
    if (std::find(to.begin(), to.end(), note) == to.end()) to.push_back(note);
  }
}

// Drift of the flash, and the scale that makes the mosaic's ratio a reflectance.
double DriftScale(const SessionContext& context, const SignalFrame& skin, const SignalFrame& spectralon,
                  BandCalibration& record) {
  const GrayCardRatio card = CompareGrayCard(skin, spectralon, context.gray_card);
  if (!(card.ratio > 0.0)) {
    throw InputError(
        skin.record.file +
        ": the gray card is saturated or dark throughout; expected a card that can be "
        "read in this frame and in the Spectralon frame: lower the ISO for this filter and capture again");
  }
  const double iso = double(skin.record.iso) / spectralon.record.iso;
  const double drift = card.ratio / iso;
  if (drift < kDarkAgainst) {
    FlashFailed(skin,
                "the gray card has " + Short(100 * drift) + " % of its brightness in the Spectralon frame");
  }
  if (drift < kWeakFlash || drift > 1.0 / kWeakFlash) {
    record.notes.push_back(skin.record.file + ": the flash was at " + Short(100 * drift) +
                           " % of that of the Spectralon frame; corrected, but noisier");
  }
  if (card.unevenness > kUnevenCard) {
    record.notes.push_back(skin.record.file + ": the gray card's ratio to the Spectralon frame varies by " +
                           Short(100 * card.unevenness) +
                           " % over the card: something shades it, or it moved");
  }
  record.gray_card_drift.push_back(drift);
  return record.certified_reflectance / card.ratio;
}

void AddTransferPoints(const SignalFrame& skin, const SignalFrame& spectralon, const PixelRegion& card,
                       BandFrames& out) {
  const auto append = [](std::vector<PhotonTransferPoint>& to,
                         const std::vector<PhotonTransferPoint>& points) {
    to.insert(to.end(), points.begin(), points.end());
  };
  if (skin.record.iso == spectralon.record.iso) {
    append(out.pairs, PhotonTransfer(skin, spectralon, card));
  } else {
    append(out.singles, PhotonTransferOfOne(skin, card));
    append(out.singles, PhotonTransferOfOne(spectralon, card));
  }
}

// Shares of saturated and of masked photosites within the window.
void CountMasked(const Mosaic& mosaic, const Window& window, BandCalibration& record) {
  const Homography unit_from_camera = window.camera_from_unit.Inverse();
  int inside = 0, saturated = 0, masked = 0;
  for (int y = 0; y < mosaic.height(); ++y) {
    for (int x = 0; x < mosaic.width(); ++x) {
      const Point p = unit_from_camera({mosaic.x0 + x + 0.5, mosaic.y0 + y + 0.5});
      if (p.x < 0 || p.y < 0 || p.x > 1 || p.y > 1) continue;
      ++inside;
      if ((mosaic.mask(x, y) & kPhotositeSaturated) != 0) ++saturated;
      if (mosaic.mask(x, y) != 0) ++masked;
    }
  }
  record.saturated_share = std::max(record.saturated_share, double(saturated) / std::max(1, inside));
  record.masked_share = std::max(record.masked_share, double(masked) / std::max(1, inside));
}

// The frame for people: cells of four photosites, the brightest thousandth clipped.
void TakePicture(const SignalFrame& skin, BandCalibration& record) {
  PlaneF cells(skin.signal.width() / 2, skin.signal.height() / 2);
  for (int y = 0; y < 2 * cells.height(); ++y) {
    for (int x = 0; x < 2 * cells.width(); ++x) cells(x / 2, y / 2) += skin.signal(x, y);
  }
  const int width = std::min(kPictureWidth, cells.width());
  const int height = std::max(1, cells.height() * width / cells.width());
  record.picture = ResizeByArea(cells, width, height);
  record.picture_scale = double(width) / skin.signal.width();
  const Scale scale = RobustScale(record.picture.values(), 0.1);
  for (float& v : record.picture.values()) v = static_cast<float>(std::clamp(v / scale.high, 0.0, 1.0));
}

SkinMosaic MakeMosaic(const SignalFrame& skin, const SignalFrame& spectralon, int spectralon_frames,
                      double scale) {
  SkinMosaic out;
  out.mosaic.skin = skin.signal;
  out.mosaic.spectralon = spectralon.signal;
  out.mosaic.mask = skin.mask;
  for (std::size_t i = 0; i < out.mosaic.mask.size(); ++i)
    out.mosaic.mask.data()[i] |= spectralon.mask.data()[i];
  out.mosaic.scale = scale;
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

BandFrames PrepareBand(const SessionContext& context, const Band& band, double certified_reflectance) {
  BandFrames out;
  BandCalibration& record = out.record;
  record.band = band;
  record.certified_reflectance = certified_reflectance;
  const auto whites = ReadRole(context, FrameRole::kSpectralon, band.wavelength_nm);
  if (whites.empty()) {
    throw InputError(context.session.directory.string() + ": there is no Spectralon frame for " +
                     Short(band.wavelength_nm) +
                     " nm, but a skin frame; every filter needs both: resume the capture");
  }
  const SignalFrame spectralon = MeanSpectralon(whites, context.gray_card);
  for (const SignalFrame& white : whites) record.spectralon_files.push_back(white.record.file);
  AddNotes(spectralon.notes, record.notes);
  const auto skins = ReadRole(context, FrameRole::kSkin, band.wavelength_nm);
  for (const SignalFrame& skin : skins) {
    record.skin_files.push_back(skin.record.file);
    AddNotes(skin.notes, record.notes);
    AddTransferPoints(skin, whites[0], context.gray_card, out);
    const double scale = DriftScale(context, skin, spectralon, record);
    SkinMosaic whole = MakeMosaic(skin, spectralon, static_cast<int>(whites.size()), scale);
    const Window window = FindWindow(whole.mosaic, context.gray_card, skin.record.file);
    record.windows.push_back(window);
    double left = 1e30, top = 1e30, right = -1e30, bottom = -1e30;
    for (const Point& p : window.corners) {
      left = std::min(left, p.x), right = std::max(right, p.x), top = std::min(top, p.y),
      bottom = std::max(bottom, p.y);
    }
    whole.mosaic = Crop(whole.mosaic, left - kWindowMargin_px, top - kWindowMargin_px,
                        right + kWindowMargin_px, bottom + kWindowMargin_px);
    CountMasked(whole.mosaic, window, record);
    out.skins.push_back(std::move(whole));
  }
  TakePicture(skins[0], record);
  return out;
}

}  // namespace dermap
