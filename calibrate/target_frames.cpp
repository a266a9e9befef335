// SPDX-License-Identifier: Apache-2.0
// One band after the other, so that no more than its own frames are in memory.
#include "calibrate/target_frames.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "calibrate/band_frames.h"
#include "calibrate/corrections.h"
#include "calibrate/failure.h"
#include "calibrate/frame_checks.h"
#include "calibrate/frame_picture.h"
#include "calibrate/spectralon.h"
#include "calibrate/statistics.h"
#include "common/core/error.h"

namespace dermap {
namespace {

constexpr double kClear = 0.04;           // of the window's side: targets stand still within half of that
constexpr double kReach = 0.12;           // tape is wider than this
constexpr double kMostSaturated = 0.001;  // of a frame's photosites: their light is not counted

struct Context {
  const Session& session;
  const FrameReader& read;
  const BlackFrames& blacks;
  PixelRegion card;
};

SignalFrame ReadLit(const Context& context, const FrameRecord& record) {
  SignalFrame frame = ReadSignal(record, context.read, context.blacks);
  CheckLit(frame, context.card, context.blacks.FullScale(*frame.black));
  if (frame.saturated_share <= kMostSaturated) return frame;
  throw CaptureFailure(record.file + ": " + Short(100 * frame.saturated_share) +
                           " % of the photosites are saturated; expected at most " +
                           Short(100 * kMostSaturated) +
                           " %, since all light of the frame counts: lower the ISO for this filter and "
                           "capture again",
                       FailurePicture(frame.signal, context.card));
}

SignalFrame SpectralonOf(const Context& context, const Band& band) {
  std::vector<SignalFrame> whites;
  for (const FrameRecord& record : context.session.frames) {
    if (record.role != FrameRole::kSpectralon || record.wavelength_nm != band.wavelength_nm) continue;
    whites.push_back(ReadLit(context, record));
    CheckSpectralon(whites.back(), context.card);
  }
  if (whites.empty()) {
    throw InputError(context.session.directory.string() + ": there is no Spectralon frame for " +
                     Short(band.wavelength_nm) + " nm, but a target; every filter needs both: capture it");
  }
  return MeanSpectralon(std::move(whites), context.card);
}

Mosaic MosaicOf(const Context& context, const SignalFrame& target, const SignalFrame& white) {
  Mosaic mosaic;
  mosaic.skin = target.signal;
  mosaic.spectralon = white.signal;
  mosaic.mask = target.mask;
  for (std::size_t i = 0; i < mosaic.mask.size(); ++i) mosaic.mask.data()[i] |= white.mask.data()[i];
  mosaic.period = target.period;
  const RigOptics& optics = context.session.rig.optics;
  const double width = mosaic.width(), height = mosaic.height();
  mosaic.lens = {0.5 * width, 0.5 * height, 0.5 * std::hypot(width, height), optics.distortion_k1,
                 optics.distortion_k2};
  MarkDead(mosaic.spectralon, mosaic.period, mosaic.mask);
  return mosaic;
}

// Of the whole frame against the gray card: flash and ISO taken out.
double Brightness(const TargetFrame& frame) {
  double sum = 0.0;
  for (const double mean : frame.means.skin) sum += mean;
  return sum / frame.card.ratio;
}

BandTargets ReadBand(const Context& context, const Band& band, double certificate) {
  const SignalFrame white = SpectralonOf(context, band);
  const OfKinds white_means = KindMeans(white);
  const auto& polarization = context.session.rig.optics.polarization;
  BandTargets out{band, certificate, {}};
  if (polarization) out.white *= SpectralonSignal(*polarization, band.wavelength_nm);
  std::vector<Mosaic> mosaics;
  for (const FrameRecord& record : context.session.frames) {
    if (record.role != FrameRole::kSkin || record.wavelength_nm != band.wavelength_nm) continue;
    const SignalFrame target = ReadLit(context, record);
    const GrayCardRatio card = CompareGrayCard(target, white, context.card);
    CheckCard(target, white, card, card.ratio * white.record.iso / record.iso, context.card);
    out.frames.push_back({record.file, {KindMeans(target), white_means}, card, {}, {}});
    mosaics.push_back(MosaicOf(context, target, white));
    mosaics.back().scale = certificate / card.ratio;
  }
  const auto brightest = std::ranges::max_element(out.frames, {}, Brightness);
  const Window window = FindWindow(mosaics[static_cast<std::size_t>(brightest - out.frames.begin())],
                                   context.card, context.session.rig.window_mm, brightest->file);
  for (std::size_t i = 0; i < mosaics.size(); ++i) {
    TargetFrame& frame = out.frames[i];
    frame.tape = SumTape(mosaics[i], window, frame.means, kClear, kReach);
    frame.middle = SumMiddle(mosaics[i], window, frame.means);
  }
  return out;
}

}  // namespace

std::vector<BandTargets> ReadTargets(const Session& session, const FrameReader& read,
                                     const BlackFrames& blacks, const PixelRegion& card) {
  const Context context{session, read, blacks, card};
  const SampledSpectrum certificate = ReadCertificate(session.rig);
  std::vector<BandTargets> targets;
  for (const Band& band : BandsOfSession(session)) {
    const double white = CertifiedReflectance(certificate, band) * session.rig.optics.certificate.value;
    targets.push_back(ReadBand(context, band, white));
  }
  return targets;
}

Session JoinSessions(const Session& first, const Session& second) {
  if (first.rig.name != second.rig.name || first.rig.gray_card_region != second.rig.gray_card_region) {
    throw InputError(second.directory.string() + " was captured on the rig '" + second.rig.name + "', " +
                     first.directory.string() + " on '" + first.rig.name +
                     "'; expected two sessions of one rig");
  }
  Session joined = first;
  const int last = first.frames.empty() ? 0 : first.frames.back().number;
  for (FrameRecord frame : second.frames) {
    frame.number += last;
    frame.file = (std::filesystem::absolute(second.directory) / frame.file).string();
    joined.frames.push_back(std::move(frame));
  }
  return joined;
}

}  // namespace dermap
