// SPDX-License-Identifier: Apache-2.0
// Rig after rig into the journal, and what they come to.
#include "studies/calibration_study.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "studies/point_journal.h"

namespace dermap {
namespace {

constexpr int kVersion = 5;  // of what is drawn and judged: older points are not gone on with

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

}  // namespace

bool CalibrationStudy::Holds() const {
  return failures == 0 && bias.worst < kBiasLimit && bias_mid_gray.worst < kMidGrayLimit &&
         chi2_per_dof.median >= kChi2Low && chi2_per_dof.median <= kChi2High &&
         chi2_per_dof.worst >= kChi2Low && chi2_per_dof.worst <= kChi2High &&
         alignment_error_px.worst < kAlignmentLimit_px;
}

CalibrationStudy RunCalibrationStudy(const std::filesystem::path& folder,
                                     const CalibrationStudyOptions& options,
                                     const ProgressFunction& progress) {
  CalibrationStudy study;
  study.options = options;
  CalibrationStage stage;
  std::vector<PlannedPoint> plan;
  for (int i = 0; i < options.rigs; ++i)
    plan.push_back({"rig " + std::to_string(i), 1.0, [&, i] { return ToJson(stage.Run(options.seed, i)); }});
  const nlohmann::json settings{{"study", "calibration"}, {"version", kVersion}, {"seed", options.seed}};
  const PointRun run = RunPoints(folder, "calibration", settings, plan, progress);
  study.resumed = run.resumed;
  ReadRecords(run, [&](const nlohmann::json& record) {
    study.rigs.push_back(CalibrationStudyRigFromJson(record));
    const CalibrationStudyRig& rig = study.rigs.back();
    if (!rig.failure.empty()) {
      ++study.failures;
      return;
    }
    if (rig.chi2_per_dof >= kChi2Low && rig.chi2_per_dof <= kChi2High) ++study.within_chi2;
    if (rig.alignment_error_px < kAlignmentLimit_px) ++study.within_alignment;
  });
  study.stray_light_error = Summary(study.rigs, [](const auto& r) { return r.stray_light_error; });
  study.leak_error = Summary(study.rigs, [](const auto& r) { return r.leak_error; });
  study.bias = Summary(study.rigs, [](const auto& r) { return r.bias; });
  study.bias_mid_gray = Summary(study.rigs, [](const auto& r) { return r.bias_mid_gray; });
  study.error_once = Summary(study.rigs, [](const auto& r) { return r.error_once; });
  study.error_mid_gray_once = Summary(study.rigs, [](const auto& r) { return r.error_mid_gray_once; });
  study.chi2_once = Summary(
      study.rigs, [](const auto& r) { return r.chi2_once; }, 1.0);
  for (const auto& rig : study.rigs) {
    if (rig.failure.empty())
      study.chi2_once_mean += rig.chi2_once / double(static_cast<int>(study.rigs.size()) - study.failures);
  }
  study.chi2_per_dof = Summary(
      study.rigs, [](const auto& r) { return r.chi2_per_dof; }, 1.0);
  study.chi2_sharp = Summary(
      study.rigs, [](const auto& r) { return r.chi2_sharp; }, 1.0);
  study.alignment_error_px = Summary(study.rigs, [](const auto& r) { return r.alignment_error_px; });
  study.window_error_px = Summary(study.rigs, [](const auto& r) { return r.window_error_px; });
  study.dropped_bands = Summary(study.rigs, [](const auto& r) { return double(r.dropped_bands); });
  return study;
}

}  // namespace dermap
