// SPDX-License-Identifier: Apache-2.0
// Every rig is drawn from the study's seed and its own number, so any one can be run again alone.
#include "studies/calibration_study.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "acquire/schedule.h"
#include "acquire/simulated/dng_writer.h"
#include "acquire/simulated/optical_bench.h"
#include "acquire/simulated/random_field.h"
#include "calibrate/calibrate.h"
#include "common/core/error.h"
#include "common/core/parallel.h"
#include "common/files/atomic_file.h"

namespace dermap {
namespace {

constexpr double kBiasLimit = 0.002;
constexpr double kMidGrayLimit = 0.001;
constexpr double kChi2Low = 0.9;
constexpr double kChi2High = 1.1;
constexpr double kAlignmentLimit_px = 0.1;
constexpr int kFieldMargin_px = 8;  // of a patch's field: the lens blurs its neighbours into it
constexpr int kGrid = 9;            // points a side at which bands are compared
constexpr double kGridBorder = 0.08;

// Four rows of four; those darker than tape lie inside, since beside tape they would have no edge.
const std::vector<double> kPatches{0.50, 0.35, 0.80, 0.18, 0.95, 0.02, 0.10, 0.50,
                                   0.18, 0.06, 0.30, 0.80, 0.35, 0.95, 0.50, 0.18};

double Between(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * Uniform(random);
}

// What all rigs share: the filters, and skin rendered once.
struct Stage {
  RigConfig skin_rig, patch_rig;
  PlanConfig plan;
  Scene skin, patches;
  PatchReflectance skin_patch;
};

RigConfig WithBands(RigConfig rig, const std::vector<double>& wavelengths_nm) {
  std::erase_if(rig.slots, [&](const WheelSlot& slot) {
    return !slot.opaque && std::find(wavelengths_nm.begin(), wavelengths_nm.end(), slot.wavelength_nm) ==
                               wavelengths_nm.end();
  });
  return rig;
}

Stage MakeStage(const ProgressFunction& progress) {
  Stage stage;
  const RigConfig rig = ReadRig(ConfigDirectory() / "rigs/simulated_8band.toml");
  stage.skin_rig = WithBands(rig, {450, 540, 580, 650});
  stage.patch_rig = WithBands(rig, {480, 610});
  stage.plan = ReadPlan(ConfigDirectory() / "plans/standard.toml");
  stage.skin = ReadScene(ConfigDirectory() / "scenes/light_freckles.toml", rig.window_mm);
  stage.patches = ReadScene(ConfigDirectory() / "scenes/gray_50.toml", rig.window_mm);
  stage.patches.pattern = TestPattern{};
  stage.patches.pattern->kind = TestPattern::Kind::kSteps;
  stage.patches.pattern->values = kPatches;
  stage.skin_patch = RenderPatch(stage.skin, stage.skin_rig, progress);
  return stage;
}

// The rig's bench and the numbers to be recorded; `rig` gets what its owner would have measured.
BenchConfig DrawBench(std::mt19937_64& random, CalibrationStudyRig& drawn, RigConfig& rig) {
  BenchConfig bench;
  bench.flash_drift = drawn.flash_drift = Between(random, 0.0, 0.05);
  bench.vignetting = drawn.vignetting = Between(random, 0.05, 0.4);
  bench.flash_unevenness = drawn.unevenness = Between(random, 0.0, 0.2);
  bench.motion_shift_mm = drawn.motion_mm = Between(random, 0.0, 1.5);
  bench.motion_rotation_deg = drawn.rotation_deg = Between(random, 0.0, 3.0);
  bench.stretch = drawn.stretch = Between(random, 0.0, 0.005);
  bench.stretch_mm = Between(random, 0.0, 0.015);
  bench.psf_sigma_px = drawn.blur_px = Between(random, 0.4, 0.9);
  drawn.exposure = Between(random, 0.5, 1.0);
  bench.white_electrons *= drawn.exposure;
  bench.nonlinearity = Between(random, -0.01, 0.01);
  bench.distortion_k1 = Between(random, -0.01, 0.01);
  bench.polarizer_sign = Uniform(random) < 0.5 ? -1 : 1;
  // At a scale at which the window stays within the frame and off the card, however far the subject moves.
  bench.scale_px_per_mm = Between(random, 30.0, 33.0);
  bench.window_center_px = {Between(random, 174.0, 182.0), Between(random, 174.0, 185.0)};
  rig.view_angle_deg = drawn.tilt_deg = Between(random, 27.0, 33.0);
  rig.optics.nonlinearity = Known{bench.nonlinearity, 0.0005};
  rig.optics.distortion_k1 = bench.distortion_k1;
  rig.optics.polarization = PolarizationConfig{};
  rig.optics.polarization->sign = bench.polarizer_sign;
  return bench;
}

Session SessionOf(const RigConfig& rig, const PlanConfig& standard) {
  Session session;
  session.rig = rig;
  session.plan = standard;
  std::erase_if(session.plan.exposures, [&](const auto& e) { return FindSlot(rig, e.slot) == nullptr; });
  session.directory = "study";
  session.complete = true;
  session.frames = MakeSchedule(session.rig, session.plan);
  for (FrameRecord& record : session.frames) record.file = FrameFileName(record, ".dng");
  return session;
}

Shot ShotOf(const FrameRecord& record) {
  return {record.role, record.slot, record.exposure_ms, record.iso, record.number};
}

CalibrationResult Calibrate(const OpticalBench& bench, const Session& session) {
  const FrameReader read = [&](const FrameRecord& record) {
    BayerFrame frame;
    frame.values = bench.Expose(ShotOf(record));
    frame.colours = {'R', 'G', 'G', 'B'};
    frame.black_level = bench.scene().bench.black_level_dn;
    frame.white_level = kDngWhiteLevel;
    return frame;
  };
  return CalibrateFrames(session, read, {});
}

void JudgePatches(const CalibrationResult& result, CalibrationStudyRig& rig) {
  const int columns = 4;
  const int rows = static_cast<int>(kPatches.size()) / columns;
  const int size = result.stack.valid.width();
  for (const PlaneF& plane : result.stack.reflectance) {
    for (std::size_t field = 0; field < kPatches.size(); ++field) {
      const int column = static_cast<int>(field) % columns, row = static_cast<int>(field) / columns;
      double sum = 0.0;
      int count = 0;
      for (int y = row * size / rows + kFieldMargin_px; y < (row + 1) * size / rows - kFieldMargin_px; ++y) {
        for (int x = column * size / columns + kFieldMargin_px;
             x < (column + 1) * size / columns - kFieldMargin_px; ++x) {
          if (result.stack.valid(x, y) == 0.0f || std::isnan(plane(x, y))) continue;
          sum += plane(x, y);
          ++count;
        }
      }
      const double error = std::abs(sum / std::max(1, count) - kPatches[field]);
      rig.bias = std::max(rig.bias, error);
      if (kPatches[field] == 0.18 || kPatches[field] == 0.5)
        rig.bias_mid_gray = std::max(rig.bias_mid_gray, error);
    }
  }
}

// Where the skin at a point of the patch was found, against where it is: patch pixels.
Point2 PlaceError(const OpticalBench& bench, const Session& session, const CalibrationResult& result,
                  const BandCalibration& band, Point unit) {
  const auto frame = std::find_if(session.frames.begin(), session.frames.end(), [&](const FrameRecord& f) {
    return f.role == FrameRole::kSkin && f.wavelength_nm == band.band.wavelength_nm;
  });
  const double size = result.stack.valid.width();
  const PatchMap map{band.windows[0].camera_from_unit, band.alignment.warp, size};
  const BenchConfig& config = bench.scene().bench;
  const Lens lens{0.5 * config.width_px, 0.5 * config.height_px,
                  0.5 * std::hypot(config.width_px, config.height_px), session.rig.optics.distortion_k1, 0.0};
  const Point found = lens.PhotositesFromIdeal(map(unit));
  const double window_mm = session.rig.window_mm;
  const Point2 skin = PatchFromBench(bench.PoseOfShot(ShotOf(*frame)), window_mm,
                                     bench.view().BenchFromPixel({found.x - 0.5, found.y - 0.5}));
  return {(skin.x / window_mm - unit.x) * size, (skin.y / window_mm - unit.y) * size};
}

void JudgeAlignment(const OpticalBench& bench, const Session& session, const CalibrationResult& result,
                    CalibrationStudyRig& rig) {
  std::vector<double> square(result.bands.size(), 0.0);
  double common = 0.0;
  for (int j = 0; j < kGrid * kGrid; ++j) {
    const auto place = [](int i) { return kGridBorder + (1.0 - 2.0 * kGridBorder) * i / (kGrid - 1.0); };
    const Point unit{place(j % kGrid), place(j / kGrid)};
    std::vector<Point2> errors;
    Point2 mean;
    for (const BandCalibration& band : result.bands) {
      if (band.dropped) continue;
      errors.push_back(PlaceError(bench, session, result, band, unit));
      mean.x += errors.back().x, mean.y += errors.back().y;
    }
    mean.x /= double(errors.size()), mean.y /= double(errors.size());
    common += (mean.x * mean.x + mean.y * mean.y) / (kGrid * kGrid);
    for (std::size_t b = 0; b < errors.size(); ++b) {
      square[b] += (std::pow(errors[b].x - mean.x, 2) + std::pow(errors[b].y - mean.y, 2)) / (kGrid * kGrid);
    }
  }
  rig.alignment_error_px = std::sqrt(*std::max_element(square.begin(), square.end()));
  rig.window_error_px = std::sqrt(common);
}

// The truth as a pixel averages it, to second order: what a Gaussian of these variances makes of it.
PlaneF Averaged(const PlaneF& truth, double variance_x, double variance_y) {
  PlaneF out = truth;
  for (int y = 1; y + 1 < truth.height(); ++y) {
    for (int x = 1; x + 1 < truth.width(); ++x) {
      const double across = truth(x + 1, y) + truth(x - 1, y) - 2.0 * truth(x, y);
      const double down = truth(x, y + 1) + truth(x, y - 1) - 2.0 * truth(x, y);
      out(x, y) += static_cast<float>(0.5 * (variance_x * across + variance_y * down));
    }
  }
  return out;
}

double Chi2(const ReflectanceStack& stack, std::size_t band, const PlaneF& truth) {
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t i = 0; i < stack.valid.size(); ++i) {
    const float r = stack.reflectance[band].data()[i];
    if (stack.valid.data()[i] == 0.0f || std::isnan(r)) continue;
    sum += std::pow((r - truth.data()[i]) / stack.sigma[band].data()[i], 2);
    count += 1.0;
  }
  return sum / std::max(1.0, count);
}

void JudgeSkin(const std::vector<PlaneF>& truth, const std::vector<Band>& bands,
               const CalibrationResult& result, CalibrationStudyRig& rig) {
  constexpr double kDrawn =
      1.0 / 6.0;  // variance that the bench's own linear interpolation of the patch adds
  const ReflectanceStack& stack = result.stack;
  std::size_t k = 0;
  for (const BandCalibration& band : result.bands) {
    rig.dropped_bands += band.dropped ? 1 : 0;
    if (band.dropped) continue;
    std::size_t t = 0;
    while (bands[t].wavelength_nm != band.band.wavelength_nm) ++t;
    const double share = 1.0 / static_cast<double>(stack.bands.size());
    const PlaneF seen = Averaged(truth[t], band.blur_px.x * band.blur_px.x + kDrawn,
                                 band.blur_px.y * band.blur_px.y + kDrawn);
    rig.chi2_per_dof += share * Chi2(stack, k, seen);
    rig.chi2_sharp += share * Chi2(stack, k, truth[t]);
    ++k;
  }
}

CalibrationStudyRig RunRig(const Stage& stage, std::uint64_t seed, int number) {
  CalibrationStudyRig rig;
  auto random = RandomStream(seed, "calibration study", static_cast<std::uint64_t>(number));
  RigConfig skin_rig = stage.skin_rig;
  const BenchConfig bench_config = DrawBench(random, rig, skin_rig);
  rig.seed = random() & 0x7FFFFFFF;
  RigConfig patch_rig = stage.patch_rig;
  patch_rig.optics = skin_rig.optics;
  patch_rig.view_angle_deg = skin_rig.view_angle_deg;
  try {
    Scene patches = stage.patches;
    patches.bench = bench_config;
    patches.seed = rig.seed;
    const OpticalBench patch_bench(patch_rig, patches);
    JudgePatches(Calibrate(patch_bench, SessionOf(patch_rig, stage.plan)), rig);
    Scene skin = stage.skin;
    skin.bench = bench_config;
    skin.seed = rig.seed;
    const OpticalBench skin_bench(skin_rig, skin, stage.skin_patch);
    const Session session = SessionOf(skin_rig, stage.plan);
    const CalibrationResult result = Calibrate(skin_bench, session);
    JudgeSkin(stage.skin_patch.Mean(), stage.skin_patch.bands, result, rig);
    JudgeAlignment(skin_bench, session, result, rig);
  } catch (const Error& error) {
    rig.failure = error.what();
  }
  return rig;
}

// `best`: the value to be near to.
MedianAndWorst Summary(const std::vector<CalibrationStudyRig>& rigs,
                       double (*value)(const CalibrationStudyRig&), double best = 0.0) {
  std::vector<double> values;
  for (const auto& rig : rigs) {
    if (rig.failure.empty()) values.push_back(value(rig));
  }
  if (values.empty()) return {std::nan(""), std::nan("")};
  std::sort(values.begin(), values.end());
  const auto far = [&](double a, double b) { return std::abs(a - best) < std::abs(b - best); };
  return {values[values.size() / 2], *std::max_element(values.begin(), values.end(), far)};
}

std::string Csv(const CalibrationStudy& study) {
  std::ostringstream out;
  out << "# dermap study calibration --rigs " << study.options.rigs << " --seed " << study.options.seed
      << "; reflectances as fractions, lengths in mm or pixels of the patch\n"
         "rig,seed,flash_drift,vignetting,unevenness,tilt_deg,motion_mm,rotation_deg,stretch,exposure,blur_"
         "px,"
         "bias,bias_mid_gray,chi2_per_dof,chi2_sharp,alignment_error_px,window_error_px,dropped_bands,"
         "failed\n";
  int number = 0;
  for (const auto& r : study.rigs) {
    char line[400];
    std::snprintf(
        line, sizeof line,
        "%d,%llu,%.4f,%.3f,%.3f,%.2f,%.3f,%.2f,%.4f,%.3f,%.3f,%.6f,%.6f,%.4f,%.4f,%.4f,%.4f,%d,%d\n",
        number++, static_cast<unsigned long long>(r.seed), r.flash_drift, r.vignetting, r.unevenness,
        r.tilt_deg, r.motion_mm, r.rotation_deg, r.stretch, r.exposure, r.blur_px, r.bias, r.bias_mid_gray,
        r.chi2_per_dof, r.chi2_sharp, r.alignment_error_px, r.window_error_px, r.dropped_bands,
        r.failure.empty() ? 0 : 1);
    out << line;
  }
  return out.str();
}

}  // namespace

bool CalibrationStudy::Holds() const {
  return failures == 0 && bias.worst < kBiasLimit && bias_mid_gray.worst < kMidGrayLimit &&
         chi2_per_dof.median >= kChi2Low && chi2_per_dof.median <= kChi2High &&
         chi2_per_dof.worst >= kChi2Low && chi2_per_dof.worst <= kChi2High &&
         alignment_error_px.worst < kAlignmentLimit_px;
}

CalibrationStudy RunCalibrationStudy(const CalibrationStudyOptions& options,
                                     const ProgressFunction& progress) {
  const auto start = std::chrono::steady_clock::now();
  CalibrationStudy study;
  study.options = options;
  const Stage stage = MakeStage({});
  for (int i = 0; i < options.rigs; ++i) {
    study.rigs.push_back(RunRig(stage, options.seed, i));
    if (!study.rigs.back().failure.empty()) ++study.failures;
    if (progress) progress((i + 1.0) / options.rigs);
  }
  study.bias = Summary(study.rigs, [](const auto& r) { return r.bias; });
  study.bias_mid_gray = Summary(study.rigs, [](const auto& r) { return r.bias_mid_gray; });
  study.chi2_per_dof = Summary(
      study.rigs, [](const auto& r) { return r.chi2_per_dof; }, 1.0);
  study.chi2_sharp = Summary(
      study.rigs, [](const auto& r) { return r.chi2_sharp; }, 1.0);
  study.alignment_error_px = Summary(study.rigs, [](const auto& r) { return r.alignment_error_px; });
  study.window_error_px = Summary(study.rigs, [](const auto& r) { return r.window_error_px; });
  study.dropped_bands = Summary(study.rigs, [](const auto& r) { return double(r.dropped_bands); });
  study.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return study;
}

void WriteCalibrationStudy(const std::filesystem::path& folder, const CalibrationStudy& study) {
  const auto entry = [](const MedianAndWorst& m) {
    return nlohmann::json{{"median", m.median}, {"worst", m.worst}};
  };
  nlohmann::json json{{"rigs", study.options.rigs},
                      {"seed", study.options.seed},
                      {"seconds", study.seconds},
                      {"failures", study.failures},
                      {"holds", study.Holds()},
                      {"bias", entry(study.bias)},
                      {"bias_mid_gray", entry(study.bias_mid_gray)},
                      {"chi2_per_dof", entry(study.chi2_per_dof)},
                      {"chi2_sharp", entry(study.chi2_sharp)},
                      {"alignment_error_px", entry(study.alignment_error_px)},
                      {"window_error_px", entry(study.window_error_px)},
                      {"dropped_bands", entry(study.dropped_bands)},
                      {"limits",
                       {{"bias", kBiasLimit},
                        {"bias_mid_gray", kMidGrayLimit},
                        {"chi2_per_dof", {kChi2Low, kChi2High}},
                        {"alignment_error_px", kAlignmentLimit_px}}}};
  for (const auto& rig : study.rigs) {
    if (!rig.failure.empty()) json["errors"].push_back(rig.failure);
  }
  FileBatch files;
  WriteFileAtomically(folder / "calibration.csv", Csv(study));
  WriteFileAtomically(folder / "calibration.json", json.dump(2) + "\n");
  files.Commit();
}

}  // namespace dermap
