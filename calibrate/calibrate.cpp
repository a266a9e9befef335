// SPDX-License-Identifier: Apache-2.0
// Order of the stage: black frames, then every band by itself, then noise, resampling and alignment of all
// together.
#include "calibrate/calibrate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <mutex>

#include "calibrate/assemble.h"
#include "calibrate/band_frames.h"
#include "calibrate/filter_order.h"
#include "calibrate/kept_frames.h"
#include "calibrate/spectralon.h"
#include "calibrate/statistics.h"
#include "common/core/error.h"
#include "common/core/parallel.h"

namespace dermap {
namespace {

constexpr std::size_t kMostKept = 256U << 20U;  // bytes of frames that are kept from one step for the next

// Where the time goes.
class StageClock {
 public:
  explicit StageClock(std::vector<StageSeconds>& stages) : stages_(stages) {}
  void Done(const std::string& stage) {
    const auto now = Clock::now();
    stages_.push_back({stage, std::chrono::duration<double>(now - last_).count()});
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::vector<StageSeconds>& stages_;
  Clock::time_point last_ = Clock::now();
};

// Steps done, from several threads, as a fraction that only grows.
class Steps {
 public:
  Steps(int total, const ProgressFunction& progress) : total_(total), progress_(progress) {}
  void Done() {
    if (!progress_) return;
    const std::lock_guard lock(mutex_);
    progress_(std::min(1.0, double(++done_) / total_));
  }

 private:
  std::mutex mutex_;
  int done_ = 0;
  int total_;
  const ProgressFunction& progress_;
};

std::map<int, NoiseModel> NoiseOfSession(const BlackFrames& blacks, const std::vector<BandFrames>& bands,
                                         std::vector<std::string>& notes) {
  std::vector<PhotonTransferPoint> pairs = PhotonTransferOfBlack(blacks);
  std::vector<PhotonTransferPoint> singles;
  for (const BandFrames& band : bands) {
    pairs.insert(pairs.end(), band.pairs.begin(), band.pairs.end());
    singles.insert(singles.end(), band.singles.begin(), band.singles.end());
  }
  std::map<int, NoiseModel> models = FitNoise(pairs);
  for (const auto& [iso, model] : FitNoise(singles)) {
    if (!models.emplace(iso, model).second) continue;
    notes.push_back(
        "noise at ISO " + std::to_string(iso) +
        " was estimated from single frames, the gray card's texture counted in: sigma is an upper bound");
  }
  if (models.empty()) {
    throw InputError(
        "the gray card has too few usable photosites to tell the noise; expected a card that is lit and not "
        "saturated: check gray_card_region in the rig's file");
  }
  return models;
}

MosaicNoise NoiseOf(const SkinMosaic& skin, const std::map<int, NoiseModel>& models) {
  return {ModelOf(models, skin.skin_iso),
          ModelOf(models, skin.spectralon_iso),
          skin.spectralon_frames,
          skin.shared_black,
          skin.skin_black,
          skin.spectralon_black};
}

std::vector<PhotositeNoise> PhotositeNoiseOf(const BandFrames& band,
                                             const std::map<int, NoiseModel>& models) {
  std::vector<PhotositeNoise> noise;
  for (const SkinMosaic& skin : band.skins)
    noise.push_back(NoiseOfPhotosites(skin.mosaic, NoiseOf(skin, models)));
  return noise;
}

std::vector<PatchSource> SourcesOf(const BandFrames& band, const std::vector<PhotositeNoise>& noise,
                                   int patch_px) {
  std::vector<PatchSource> sources;
  for (std::size_t k = 0; k < band.skins.size(); ++k) {
    const PatchMap map{band.record.windows[k].camera_from_unit, band.record.alignment.warp, double(patch_px)};
    sources.push_back({&band.skins[k].mosaic, map, &noise[k]});
  }
  return sources;
}

// For finding the alignment.
PatchBand DraftOf(const BandFrames& band, const std::map<int, NoiseModel>& models, int patch_px) {
  const auto noise = PhotositeNoiseOf(band, models);
  ResampledPatch patch = ResamplePatch(SourcesOf(band, noise, patch_px), patch_px, true);
  return {std::move(patch.reflectance), std::move(patch.sigma)};
}

// From the photosites again, so that nothing is interpolated twice.
PatchBand ResampleBand(BandFrames& band, const std::map<int, NoiseModel>& models, int patch_px) {
  const auto noise = PhotositeNoiseOf(band, models);
  const auto sources = SourcesOf(band, noise, patch_px);
  ResampledPatch patch = ResamplePatch(sources, patch_px);
  band.record.correlation = CorrelationOfNoise(sources[0], patch_px);
  band.record.blur_px = BlurOfPatch(sources[0], band.record.windows[0].blur_px, patch_px);
  return {std::move(patch.reflectance), std::move(patch.sigma)};
}

void Align(std::vector<BandFrames>& bands, const std::vector<PatchBand>& patches,
           const CalibrationOptions& options) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    if (!bands[i].record.dropped) kept.push_back(i);
  }
  // A band that lies elsewhere spoils what the others are held against: the farthest goes, the rest begins
  // anew.
  while (true) {
    std::vector<PlaneF> reflectance, sigma;
    std::vector<double> window_sigma_px;
    for (const std::size_t i : kept) {
      reflectance.push_back(patches[i].reflectance);
      sigma.push_back(patches[i].sigma);
      const Window& window = bands[i].record.windows[0];
      window_sigma_px.push_back(window.edge_uncertainty_px * options.patch_px / window.smallest_side_px);
    }
    auto found = AlignBands(reflectance, sigma, window_sigma_px, options.alignment);
    const auto off = [](const BandAlignment& a) { return a.clearly_off ? a.found_shift_px : 0.0; };
    const auto farthest = std::max_element(found.begin(), found.end(),
                                           [&](const auto& a, const auto& b) { return off(a) < off(b); });
    // Of two bands nobody can say which lies elsewhere: both go.
    const bool one_off = farthest != found.end() && farthest->clearly_off && kept.size() > 2;
    const auto at = farthest - found.begin();
    for (std::size_t k = 0; k < kept.size(); ++k) {
      if (one_off && static_cast<std::ptrdiff_t>(k) != at) continue;
      BandCalibration& record = bands[kept[k]].record;
      record.alignment = std::move(found[k]);
      const std::string& note = record.alignment.note;
      if (!note.empty()) record.notes.push_back((record.alignment.clearly_off ? "left out: " : "") + note);
      record.dropped = record.alignment.clearly_off;
    }
    if (!one_off) return;
    kept.erase(kept.begin() + at);
  }
}

}  // namespace

const NoiseModel& ModelOf(const std::map<int, NoiseModel>& models, int iso) {
  const auto found = models.find(iso);
  if (found != models.end()) return found->second;
  return std::min_element(models.begin(), models.end(),
                          [&](const auto& a, const auto& b) {
                            return std::abs(std::log(double(a.first) / iso)) <
                                   std::abs(std::log(double(b.first) / iso));
                          })
      ->second;
}

CalibrationResult CalibrateFrames(const Session& session, const FrameReader& read,
                                  const CalibrationOptions& options, const ProgressFunction& progress) {
  CalibrationResult result;
  StageClock clock(result.seconds);
  result.session = session.directory.filename().string();
  result.edge_mask_px = options.edge_mask_px;
  const std::vector<Band> bands = BandsOfSession(session);
  NoteMissingBands(session, bands, result.notes);
  const auto count = static_cast<int>(bands.size());
  SignalOptions signals;
  signals.subtract_black = options.skip.count(Step::kBlack) == 0;
  signals.mask_hot = options.skip.count(Step::kHotPhotosites) == 0;
  BlackFrames blacks(session, read, signals);
  result.hot_share = blacks.hot_share();
  clock.Done("black");
  const SampledSpectrum certificate = ReadCertificate(session.rig);
  const PixelRegion card = GrayCardRegion(session.rig, blacks.sensor().width, blacks.sensor().height);
  KeptFrames kept(read, kMostKept);
  result.linearity = FindLinearity(
      session, [&](const FrameRecord& record) { return kept.Peek(record); }, blacks, card);
  if (!result.linearity.warning.empty()) result.notes.push_back(result.linearity.warning);
  if (result.linearity.used && options.skip.count(Step::kLinearity) == 0)
    blacks.SetNonlinearity(result.linearity.used->value);
  clock.Done("linearity");
  const FrameReader take = [&](const FrameRecord& record) { return kept.Take(record); };
  const SessionContext context{session, take, blacks, card, options.skip, result.linearity};
  Steps steps(3 * count, progress);
  std::vector<BandFrames> frames(bands.size());
  ParallelFor(count, [&](int i) {
    const Known& known = session.rig.optics.certificate;
    const double white =
        CertifiedReflectance(certificate, bands[i]) * known.value * options.spectralon_factor;
    frames[i] = PrepareBand(context, bands[i], {white, known.sigma});
    steps.Done();
  });
  clock.Done("frames");
  CheckFilterOrder(session.rig, blacks.sensor().colours, frames);
  DropStrangeWindows(frames);
  result.noise = NoiseOfSession(blacks, frames, result.notes);
  std::vector<PatchBand> patches(bands.size());
  ParallelFor(count, [&](int i) {
    if (options.align) patches[i] = DraftOf(frames[i], result.noise, options.patch_px);
    SetDriftUncertainty(frames[i].skins, result.noise, frames[i].record);
    steps.Done();
  });
  clock.Done("draft");
  if (options.align) Align(frames, patches, options);
  DropUnalignable(frames);
  clock.Done("align");
  ParallelFor(count, [&](int i) {
    patches[i] = ResampleBand(frames[i], result.noise, options.patch_px);
    steps.Done();
  });
  clock.Done("resample");
  Assemble(frames, patches, session, options, result);
  clock.Done("assemble");
  return result;
}

CalibrationResult CalibrateSession(const Session& session, const CalibrationOptions& options,
                                   const ProgressFunction& progress) {
  if (options.verify_hashes) {
    ParallelFor(static_cast<int>(session.frames.size()), [&](int i) {
      Session one;
      one.directory = session.directory;
      one.frames = {session.frames[static_cast<std::size_t>(i)]};
      VerifyFrames(one);
    });
  }
  const FrameReader read = [&](const FrameRecord& record) {
    return ReadBayerFrame(session.directory / record.file);
  };
  return CalibrateFrames(session, read, options, progress);
}

}  // namespace dermap
