// SPDX-License-Identifier: Apache-2.0
// All sweeps, and where they break.
#include "studies/stability_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "studies/point_journal.h"

namespace dermap {
namespace {

constexpr int kRecordVersion = 4;  // of a point in the journal: what it holds and how it was counted
constexpr double kMostFlagged = 0.5;
constexpr int kNoises = 3;  // of a point: one draw of an error that all pixels share tells little

double Cost(FitMethod method) {
  return method == FitMethod::kFast ? 1.0 : method == FitMethod::kCeres ? 6.0 : 12.0;
}

std::vector<Sweep> Asked(std::vector<Sweep> sweeps, const std::vector<std::string>& names) {
  if (names.empty()) return sweeps;
  std::string known;
  for (const Sweep& sweep : sweeps) known += (known.empty() ? "" : ", ") + sweep.name;
  for (const std::string& name : names)
    if (std::none_of(sweeps.begin(), sweeps.end(), [&](const Sweep& s) { return s.name == name; }))
      throw InputError(fmt::format("'{}' is no sweep; expected {}", name, known));
  std::erase_if(sweeps,
                [&](const Sweep& s) { return std::find(names.begin(), names.end(), s.name) == names.end(); });
  return sweeps;
}

// The default method first: a study that is broken off has that one whole.
std::vector<FitMethod> Methods(const StabilityStudyOptions& options) {
  std::vector<FitMethod> methods;
  for (const std::string& name : options.methods) methods.push_back(FitMethodFromName(name));
  if (methods.empty() && options.quick) return {FitMethod::kFast};
  return methods.empty() ? std::vector{FitMethod::kFast, FitMethod::kDescent, FitMethod::kCeres} : methods;
}

// A method's points on a sweep, from the harmless one to one end.
std::vector<const StabilityPoint*> Branch(const StabilityStudy& study, const Sweep& sweep,
                                          const std::string& method, bool forwards) {
  std::vector<const StabilityPoint*> branch;
  const auto at = std::find(sweep.values.begin(), sweep.values.end(), sweep.harmless) - sweep.values.begin();
  const int step = forwards ? 1 : -1;
  for (int i = static_cast<int>(at); i >= 0 && i < static_cast<int>(sweep.values.size()); i += step)
    for (const StabilityPoint& p : study.points)
      if (p.sweep == sweep.name && p.method == method && p.value == sweep.values[i]) branch.push_back(&p);
  return branch;
}

bool IsRight(const StabilityPoint& p) {
  return p.refusal.empty() && p.excess <= kEdgeExcess;
}

void FindEdges(const Sweep& sweep, StabilityStudy& study) {
  for (const FitMethod method : sweep.methods) {
    const std::string name(NameOf(method));
    for (const bool forwards : {true, false}) {
      const auto branch = Branch(study, sweep, name, forwards);
      if (branch.size() < 2) continue;
      StabilityEdge edge{.sweep = sweep.name, .method = name, .axis = sweep.label, .judge = sweep.judge};
      edge.inside = branch.back()->value;
      for (std::size_t i = 1; i < branch.size() && !edge.found; ++i) {
        if (IsRight(*branch[i])) continue;
        edge.found = true;
        edge.inside = branch[i - 1]->value;
        edge.outside = branch[i]->value;
        edge.response = Response(*branch[i]);
      }
      study.edges.push_back(edge);
    }
  }
}

void RelateAll(const Sweep& sweep, StabilityStudy& study) {
  for (StabilityPoint& p : study.points) {
    if (p.sweep != sweep.name) continue;
    const auto harmless =
        std::find_if(study.points.begin(), study.points.end(), [&](const StabilityPoint& other) {
          return other.sweep == p.sweep && other.method == p.method && other.value == sweep.harmless;
        });
    if (harmless != study.points.end()) Relate(*harmless, p);
  }
}

}  // namespace

std::string Response(const StabilityPoint& point) {
  if (!point.refusal.empty()) return "refused";
  if (point.silently_wrong) return "silent";
  if (point.flagged > kMostFlagged) return "flagged";
  if (!point.converged) return "not converged";
  return "wide intervals";
}

StabilityStudy RunStabilityStudy(const std::filesystem::path& folder, const StabilityStudyOptions& options,
                                 const ProgressFunction& progress) {
  StabilityBench bench(options.quick ? 32 : 64, options.quick ? 60000 : 300000);
  const std::vector<Sweep> sweeps = Asked(StabilitySweeps(bench, options.quick), options.sweeps);
  const int noises = options.quick ? 1 : kNoises;
  std::vector<PlannedPoint> plan;
  for (const FitMethod method : Methods(options)) {
    for (const Sweep& sweep : sweeps) {
      if (std::count(sweep.methods.begin(), sweep.methods.end(), method) == 0) continue;
      const bool slow = method == FitMethod::kCeres && !sweep.small;  // one, to end within the hour
      const int fits = sweep.small ? kNoises : slow ? 1 : noises;
      for (const double value : sweep.values)
        plan.push_back({fmt::format("{} {} {:g}", sweep.name, NameOf(method), value), Cost(method) * fits,
                        [&, method, value, fits] {
                          return ToJson(MeasurePoint(sweep, method, value, bench, fits, options.seed));
                        }});
    }
  }
  StabilityStudy study;
  study.options = options;
  study.machine = MachineName();
  const nlohmann::json settings{
      {"study", "stability"}, {"version", kRecordVersion}, {"quick", options.quick}, {"seed", options.seed}};
  for (const nlohmann::json& record : RunPoints(folder, "stability", settings, plan, progress).records)
    study.points.push_back(StabilityPointFromJson(record));
  for (const Sweep& sweep : sweeps) {
    RelateAll(sweep, study);
    FindEdges(sweep, study);
  }
  for (std::size_t i = 0; i < study.points.size(); ++i) {
    const StabilityPoint& p = study.points[i];
    if (p.silently_wrong) study.silently_wrong.push_back(i);
    if (IsRight(p) && p.told_flagged > kFlaggedInside) study.flagged_inside.push_back(i);
  }
  study.verdicts = {{"points that are silently wrong", static_cast<double>(study.silently_wrong.size()), 0.0},
                    {"points that are right, yet with more than 5 % of the pixels flagged that noise leaves "
                     "identifiable",
                     static_cast<double>(study.flagged_inside.size()), 0.0},
                    {"points whose data, which are no rubbish, were refused",
                     static_cast<double>(std::count_if(study.points.begin(), study.points.end(),
                                                       [](const auto& p) { return !p.refusal.empty(); })),
                     0.0}};
  return study;
}

}  // namespace dermap
