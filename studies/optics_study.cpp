// SPDX-License-Identifier: Apache-2.0
// Skins over mu_a given to the sources of profiles and to both judges.
#include "studies/optics_study.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <mutex>

#include "common/core/parallel.h"
#include "common/optics/homogeneous_skin.h"
#include "common/optics/layers.h"
#include "common/optics/profile_table.h"
#include "tests/reference/adding_doubling.h"
#include "tests/reference/monte_carlo.h"

namespace dermap {
namespace {

constexpr int kJudgeNodes = 12, kPeakedJudgeNodes = 16;

std::vector<double> Logarithmic(double low, double high, int count) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(low * std::pow(high / low, i / (count - 1.0)));
  return values;
}

reference::LayerStack StackOf(const SkinRow& row, double g) {
  const TissueConfig tissue;
  return {
      tissue.n_outside,
      {{.thickness_mm = row.epidermis_thickness_mm,
        .mu_a = row.mu_a_epidermis,
        .mu_s = row.mu_s_reduced_epidermis / (1.0 - g),
        .g = g,
        .n = tissue.n_epidermis,
        .absorber_below = row.junction_absorbance},
       {.mu_a = row.mu_a_dermis, .mu_s = row.mu_s_reduced_dermis / (1.0 - g), .g = g, .n = tissue.n_dermis}},
      tissue.n_dermis};
}

SkinRow RowOf(double wavelength_nm, double epidermis, double dermis, double absorbance) {
  return {.mu_a_epidermis = epidermis,
          .mu_a_dermis = dermis,
          .junction_absorbance = absorbance,
          .mu_s_reduced_epidermis = ReducedScatteringEpidermis(wavelength_nm, {}),
          .mu_s_reduced_dermis = ReducedScatteringDermis(wavelength_nm, {})};
}

SkinResponses One(const HomogeneousSkin& skin, const SkinRow& row) {
  return skin.Evaluate(std::span(&row, 1), {}).at(0);
}

// What every point asks; made once.
struct Sources {
  HomogeneousSkin exact{{.single = true}, {}};
  HomogeneousSkin multipole{{.profiles = "multipole"}, {}};
  HomogeneousSkin symmetric{{.profiles = "multipole-symmetric"}, {}};
  std::unique_ptr<ProfileSource> responses = MakeProfileSource("exact");

  OpticsPoint Ask(double wavelength_nm, double epidermis, double dermis, double absorbance) const {
    const SkinRow row = RowOf(wavelength_nm, epidermis, dermis, absorbance);
    constexpr std::array kTotal{0.0};
    const auto upper = responses->Epidermis(EpidermisOpticsOf({}, wavelength_nm, epidermis), kTotal);
    const auto lower = responses->Dermis(DermisOpticsOf({}, wavelength_nm, dermis), kTotal);
    return {.wavelength_nm = wavelength_nm,
            .mu_a_epidermis = epidermis,
            .mu_a_dermis = dermis,
            .junction_absorbance = absorbance,
            .adding_doubling = reference::NormalIncidenceTotals(StackOf(row, 0.0), kJudgeNodes).reflectance,
            .exact = One(exact, row).reflectance,
            .exact_tables = TwoLayerReflectance(upper, lower, absorbance)[0],
            .multipole = One(multipole, row).reflectance,
            .multipole_symmetric = One(symmetric, row).reflectance};
  }
};

JudgedValue Judged(const reference::Estimate& estimate) {
  return {estimate.value, estimate.standard_error};
}

void AskMonteCarlo(const SkinRow& row, const OpticsStudy& study, std::uint64_t seed,
                   OpticsCurvePoint& point) {
  reference::MonteCarloScene scene;
  scene.stack = StackOf(row, 0.0);
  const auto isotropic = reference::RunMonteCarlo(scene, {.photons = study.photons, .seed = seed});
  scene.stack = StackOf(row, study.anisotropy);
  const auto peaked = reference::RunMonteCarlo(scene, {.photons = study.peaked_photons, .seed = seed});
  point.monte_carlo = Judged(isotropic.reflectance);
  point.monte_carlo_single = Judged(isotropic.single_scattering);
  point.peaked_monte_carlo = Judged(peaked.reflectance);
}

// Largest over all points; `error` is of one point.
template <class Points, class Error>
double Worst(const Points& points, const Error& error) {
  double worst = 0.0;
  for (const auto& point : points) worst = std::max(worst, error(point));
  return worst;
}

// In per cent, where 2e-4 of the incident light counts as 1 %.
double TotalError(double value, double judge) {
  return std::abs(value - judge) / std::max(0.01 * judge, 2e-4);
}

double InErrors(double value, const JudgedValue& judge) {
  return std::abs(value - judge.value) / judge.standard_error;
}

std::vector<Verdict> Judge(const OpticsStudy& study) {
  const auto& sweep = study.sweep;
  const auto& curve = study.curve;
  const auto error_of = [&](double OpticsPoint::*value) {
    return Worst(sweep, [&](const OpticsPoint& p) { return TotalError(p.*value, p.adding_doubling); });
  };
  return {
      {"exact, row by row: largest error against adding-doubling, % (2e-4 counts as 1 %)",
       error_of(&OpticsPoint::exact), 0.1},
      {"exact, as tables hold it: largest error against adding-doubling, % (2e-4 counts as 1 %)",
       error_of(&OpticsPoint::exact_tables), 1.0},
      {"exact against Monte Carlo: largest difference, standard errors",
       Worst(curve, [](const auto& p) { return InErrors(p.isotropic.exact, p.monte_carlo); }), 4.0},
      {"the two judges against each other: largest difference, standard errors",
       Worst(curve, [](const auto& p) { return InErrors(p.isotropic.adding_doubling, p.monte_carlo); }), 4.0},
      {"exact with a forward peak: largest error against adding-doubling, %",
       Worst(curve, [](const auto& p) { return TotalError(p.peaked_exact, p.peaked_adding_doubling); }), 1.0},
      {"exact with a forward peak against Monte Carlo: largest difference, standard errors",
       Worst(curve, [](const auto& p) { return InErrors(p.peaked_exact, p.peaked_monte_carlo); }), 4.0},
      {"light scattered once, exact against Monte Carlo: largest difference, standard errors",
       Worst(curve, [](const auto& p) { return InErrors(p.single, p.monte_carlo_single); }), 4.0},
  };
}

OpticsCurvePoint CurvePoint(const Sources& sources, const HomogeneousSkin& peaked, const OpticsStudy& study,
                            double mu_a, std::uint64_t seed) {
  const double wavelength_nm = study.curve_wavelength_nm, dermis = study.curve_mu_a_dermis,
               absorbance = study.curve_junction_absorbance;
  const SkinRow row = RowOf(wavelength_nm, mu_a, dermis, absorbance);
  OpticsCurvePoint point;
  point.isotropic = sources.Ask(wavelength_nm, mu_a, dermis, absorbance);
  point.single = One(sources.exact, row).single;
  const SkinResponses with_peak = One(peaked, row);
  point.peaked_exact = with_peak.reflectance;
  point.peaked_single = with_peak.single;
  point.peaked_adding_doubling =
      reference::NormalIncidenceTotals(StackOf(row, study.anisotropy), kPeakedJudgeNodes).reflectance;
  AskMonteCarlo(row, study, seed, point);
  return point;
}

std::vector<OpticsPoint> SweptSkins(const std::vector<double>& mu_a_epidermis, bool quick) {
  const std::vector<double> wavelengths =
      quick ? std::vector{400.0, 720.0} : std::vector{400.0, 450.0, 550.0, 650.0, 720.0};
  std::vector<OpticsPoint> points;
  for (const double wavelength_nm : wavelengths) {
    for (const double dermis : Logarithmic(0.02, 30.0, quick ? 2 : 6)) {
      for (const double absorbance : {0.0, 1.2}) {
        for (const double epidermis : mu_a_epidermis) {
          points.push_back({.wavelength_nm = wavelength_nm,
                            .mu_a_epidermis = epidermis,
                            .mu_a_dermis = dermis,
                            .junction_absorbance = absorbance});
        }
      }
    }
  }
  return points;
}

}  // namespace

OpticsStudy RunOpticsStudy(const OpticsStudyOptions& options, const ProgressFunction& progress) {
  OpticsStudy study;
  study.seed = options.seed;
  study.photons = options.quick ? 20000 : 1000000;
  study.peaked_photons = options.quick ? 10000 : 300000;
  const Sources sources;
  TissueConfig peaked_tissue;
  peaked_tissue.anisotropy = study.anisotropy;
  const HomogeneousSkin peaked({.single = true}, peaked_tissue);
  const auto mu_a = Logarithmic(0.02, 80.0, options.quick ? 4 : 14);

  // Bright skins keep photons longest: the first points take most of the time.
  std::mutex reporting;
  int done = 0;
  study.curve.resize(mu_a.size());
  ParallelFor(static_cast<int>(mu_a.size()), [&](int i) {
    study.curve[i] = CurvePoint(sources, peaked, study, mu_a[i], options.seed + i);
    const std::lock_guard lock(reporting);
    if (progress) progress(0.9 * ++done / static_cast<double>(mu_a.size()));
  });
  study.sweep = SweptSkins(mu_a, options.quick);
  ParallelFor(static_cast<int>(study.sweep.size()), [&](int i) {
    const OpticsPoint p = study.sweep[i];
    study.sweep[i] = sources.Ask(p.wavelength_nm, p.mu_a_epidermis, p.mu_a_dermis, p.junction_absorbance);
  });
  study.verdicts = Judge(study);
  if (progress) progress(1.0);
  return study;
}

}  // namespace dermap
