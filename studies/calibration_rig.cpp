// SPDX-License-Identifier: Apache-2.0
// What is drawn of a rig, and its two sessions: patches of known reflectance, and skin.
#include "studies/calibration_rig.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "acquire/schedule.h"
#include "acquire/simulated/dng_writer.h"
#include "acquire/simulated/optical_bench.h"
#include "acquire/simulated/random_field.h"
#include "calibrate/calibrate.h"
#include "calibrate/measure_stray_light.h"
#include "common/core/error.h"
#include "studies/calibration_judge.h"

namespace dermap {
namespace {

constexpr int kPatchSessions = 3;  // their noise is no bias
constexpr double kMostStrayLight = 0.02, kMostLeak = 0.02;
// Of the session that measures both: targets on a stand, a white one and one of black glass, from within
// which next to nothing comes back: how little is known to this.
constexpr double kWhiteTarget = 0.8, kBlackTargetSigma = 1e-4;
constexpr double kStandShift_mm = 0.05, kStandRotation_deg = 0.2;
constexpr int kBlackTargetFrames = 1000;  // their numbers begin behind this

// Four rows of four; those darker than tape lie inside, since beside tape they would have no edge.
const std::vector<double> kPatches{0.50, 0.35, 0.80, 0.18, 0.95, 0.02, 0.10, 0.50,
                                   0.18, 0.06, 0.30, 0.80, 0.35, 0.95, 0.50, 0.18};

double Between(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * Uniform(random);
}

RigConfig WithBands(RigConfig rig, const std::vector<double>& wavelengths_nm) {
  std::erase_if(rig.slots, [&](const WheelSlot& slot) {
    return !slot.opaque && std::find(wavelengths_nm.begin(), wavelengths_nm.end(), slot.wavelength_nm) ==
                               wavelengths_nm.end();
  });
  return rig;
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
  rig.optics.nonlinearity.reset();
  rig.optics.distortion_k1 = bench.distortion_k1;
  rig.optics.polarization = PolarizationConfig{};
  rig.optics.polarization->sign = bench.polarizer_sign;
  drawn.nonlinearity_stated = Uniform(random) < 0.5;
  if (drawn.nonlinearity_stated) rig.optics.nonlinearity = Known{bench.nonlinearity, 0.0005};
  return bench;
}

// `repeat`: the same once more, with other numbers of shots, by which flash, motion and noise are drawn.
Session SessionOf(const RigConfig& rig, const PlanConfig& standard, int repeat = 0) {
  Session session;
  session.rig = rig;
  session.plan = standard;
  std::erase_if(session.plan.exposures, [&](const auto& e) { return FindSlot(rig, e.slot) == nullptr; });
  session.directory = "study";
  session.complete = true;
  session.frames = MakeSchedule(session.rig, session.plan);
  const auto first = repeat * static_cast<int>(session.frames.size());
  for (FrameRecord& record : session.frames) {
    record.number += first;
    record.file = FrameFileName(record, ".dng");
  }
  return session;
}

BayerFrame FrameOf(const OpticalBench& bench, const FrameRecord& record) {
  BayerFrame frame;
  frame.values = bench.Expose(ShotOf(record));
  frame.colours = {'R', 'G', 'G', 'B'};
  frame.black_level = bench.scene().bench.black_level_dn;
  frame.white_level = kDngWhiteLevel;
  return frame;
}

CalibrationResult Calibrate(const OpticalBench& bench, const Session& session) {
  return CalibrateFrames(session, [&](const FrameRecord& record) { return FrameOf(bench, record); }, {});
}

Scene TargetScene(const Scene& patches, BenchConfig bench, double reflectance, std::uint64_t seed) {
  Scene scene = patches;
  scene.pattern = TestPattern{TestPattern::Kind::kFlat, reflectance, reflectance};
  bench.motion_shift_mm = kStandShift_mm;
  bench.motion_rotation_deg = kStandRotation_deg;
  bench.stretch = bench.stretch_mm = 0.0;
  scene.bench = bench;
  scene.seed = seed;
  return scene;
}

// What the rig's owner measures of lens and polarizers, by tape and a sensor that is not that of the patches.
void MeasureLens(std::mt19937_64& random, const Scene& patches, const BenchConfig& bench,
                 const PlanConfig& plan, CalibrationStudyRig& drawn, RigConfig& rig) {
  const auto seed = static_cast<std::uint64_t>(random() & 0x7FFFFFFF);
  const double black = kBlackTargetSigma * std::abs(Normal(random));
  const OpticalBench white_bench(rig, TargetScene(patches, bench, kWhiteTarget, seed));
  const OpticalBench black_bench(rig, TargetScene(patches, bench, black, seed));
  Session session = SessionOf(rig, plan);
  const std::vector<FrameRecord> white_frames = session.frames;
  for (FrameRecord frame : white_frames) {
    if (frame.role != FrameRole::kSkin) continue;
    frame.number += kBlackTargetFrames;
    session.frames.push_back(frame);
  }
  const FrameReader read = [&](const FrameRecord& record) {
    return FrameOf(record.number > kBlackTargetFrames ? black_bench : white_bench, record);
  };
  const StrayLightMeasurement found = MeasureStrayLight(session, read, Known{0.0, kBlackTargetSigma});
  rig.optics.stray_light = found.share;
  rig.optics.polarization->leak = *found.leak;
  drawn.stray_light_error = found.share.value - bench.stray_light;
  drawn.stray_light_sigma = found.share.sigma;
  drawn.leak_error = found.leak->value - bench.polarizer_leak;
  drawn.leak_sigma = found.leak->sigma;
}

}  // namespace

struct CalibrationStage::Parts {
  RigConfig skin_rig, patch_rig;
  PlanConfig plan;
  Scene skin, patches;
  PatchReflectance skin_patch;
  Parts();
};

CalibrationStage::Parts::Parts() {
  const RigConfig rig = ReadRig(ConfigDirectory() / "rigs/simulated_8band.toml");
  skin_rig = WithBands(rig, {450, 540, 580, 650});
  patch_rig = WithBands(rig, {480, 610});
  plan = ReadPlan(ConfigDirectory() / "plans/standard.toml");
  skin = ReadScene(ConfigDirectory() / "scenes/light_freckles.toml", rig.window_mm);
  patches = ReadScene(ConfigDirectory() / "scenes/gray_50.toml", rig.window_mm);
  patches.pattern = TestPattern{};
  patches.pattern->kind = TestPattern::Kind::kSteps;
  patches.pattern->values = kPatches;
  skin_patch = RenderPatch(skin, skin_rig, {});
}

CalibrationStage::CalibrationStage() = default;
CalibrationStage::~CalibrationStage() = default;

CalibrationStudyRig CalibrationStage::Run(std::uint64_t seed, int number) {
  if (!parts_) parts_ = std::make_unique<Parts>();
  const Parts& stage = *parts_;
  CalibrationStudyRig rig;
  auto random = RandomStream(seed, "calibration study", static_cast<std::uint64_t>(number));
  RigConfig skin_rig = stage.skin_rig;
  BenchConfig bench_config = DrawBench(random, rig, skin_rig);
  rig.seed = random() & 0x7FFFFFFF;
  auto lens_random = RandomStream(seed, "calibration study lens", static_cast<std::uint64_t>(number));
  bench_config.stray_light = rig.stray_light = Between(lens_random, 0.0, kMostStrayLight);
  bench_config.polarizer_leak = rig.leak = Between(lens_random, 0.0, kMostLeak);
  RigConfig patch_rig = stage.patch_rig;
  patch_rig.optics = skin_rig.optics;
  patch_rig.view_angle_deg = skin_rig.view_angle_deg;
  try {
    MeasureLens(lens_random, stage.patches, bench_config, stage.plan, rig, patch_rig);
    skin_rig.optics = patch_rig.optics;
    Scene patches = stage.patches;
    patches.bench = bench_config;
    patches.seed = rig.seed;
    const OpticalBench patch_bench(patch_rig, patches);
    std::vector<std::vector<PatchError>> errors;
    for (int k = 0; k < kPatchSessions; ++k)
      errors.push_back(PatchErrors(Calibrate(patch_bench, SessionOf(patch_rig, stage.plan, k)), kPatches));
    JudgePatches(errors, kPatches, rig);
    Scene skin = stage.skin;
    skin.bench = bench_config;
    skin.seed = rig.seed;
    const OpticalBench skin_bench(skin_rig, skin, stage.skin_patch);
    const Session session = SessionOf(skin_rig, stage.plan);
    const CalibrationResult result = Calibrate(skin_bench, session);
    JudgeSkin(skin_bench, session, result, rig);
    JudgeAlignment(skin_bench, session, result, rig);
  } catch (const Error& error) {
    rig.failure = error.what();
  }
  return rig;
}

nlohmann::json ToJson(const CalibrationStudyRig& r) {
  return {{"seed", r.seed},
          {"flash_drift", r.flash_drift},
          {"vignetting", r.vignetting},
          {"unevenness", r.unevenness},
          {"tilt_deg", r.tilt_deg},
          {"motion_mm", r.motion_mm},
          {"rotation_deg", r.rotation_deg},
          {"stretch", r.stretch},
          {"exposure", r.exposure},
          {"blur_px", r.blur_px},
          {"nonlinearity_stated", r.nonlinearity_stated},
          {"stray_light", r.stray_light},
          {"stray_light_error", r.stray_light_error},
          {"stray_light_sigma", r.stray_light_sigma},
          {"leak", r.leak},
          {"leak_error", r.leak_error},
          {"leak_sigma", r.leak_sigma},
          {"bias", r.bias},
          {"bias_mid_gray", r.bias_mid_gray},
          {"error_once", r.error_once},
          {"error_mid_gray_once", r.error_mid_gray_once},
          {"chi2_once", r.chi2_once},
          {"chi2_per_dof", r.chi2_per_dof},
          {"chi2_sharp", r.chi2_sharp},
          {"alignment_error_px", r.alignment_error_px},
          {"window_error_px", r.window_error_px},
          {"dropped_bands", r.dropped_bands},
          {"failure", r.failure}};
}

CalibrationStudyRig CalibrationStudyRigFromJson(const nlohmann::json& j) {
  CalibrationStudyRig r;
  j.at("seed").get_to(r.seed);
  j.at("flash_drift").get_to(r.flash_drift);
  j.at("vignetting").get_to(r.vignetting);
  j.at("unevenness").get_to(r.unevenness);
  j.at("tilt_deg").get_to(r.tilt_deg);
  j.at("motion_mm").get_to(r.motion_mm);
  j.at("rotation_deg").get_to(r.rotation_deg);
  j.at("stretch").get_to(r.stretch);
  j.at("exposure").get_to(r.exposure);
  j.at("blur_px").get_to(r.blur_px);
  j.at("nonlinearity_stated").get_to(r.nonlinearity_stated);
  j.at("stray_light").get_to(r.stray_light);
  j.at("stray_light_error").get_to(r.stray_light_error);
  j.at("stray_light_sigma").get_to(r.stray_light_sigma);
  j.at("leak").get_to(r.leak);
  j.at("leak_error").get_to(r.leak_error);
  j.at("leak_sigma").get_to(r.leak_sigma);
  j.at("bias").get_to(r.bias);
  j.at("bias_mid_gray").get_to(r.bias_mid_gray);
  j.at("error_once").get_to(r.error_once);
  j.at("error_mid_gray_once").get_to(r.error_mid_gray_once);
  j.at("chi2_once").get_to(r.chi2_once);
  j.at("chi2_per_dof").get_to(r.chi2_per_dof);
  j.at("chi2_sharp").get_to(r.chi2_sharp);
  j.at("alignment_error_px").get_to(r.alignment_error_px);
  j.at("window_error_px").get_to(r.window_error_px);
  j.at("dropped_bands").get_to(r.dropped_bands);
  j.at("failure").get_to(r.failure);
  return r;
}

}  // namespace dermap
