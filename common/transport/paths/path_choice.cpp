// SPDX-License-Identifier: Apache-2.0
// The ladder, and what each approximation costs. Constants are fits to renders of random scenes, on the safe
// side (path_choice_test.cpp holds estimates against true errors).
#include "common/transport/paths/path_choice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace dermap {
namespace {

// Light that is lost past the margin, relative, rms over a window of 7.5 mm: kLost exp(-kFall kappa margin),
// kappa the dermis's effective attenuation.
constexpr double kLost = 0.06, kFall = 3.5;
constexpr double kLeastMargin_mm = 0.6, kLargestMargin_mm = 4.0;
// Share of what closing the series adds by which it is off where skin or light are not uniform.
constexpr double kClosing = 0.1;
// Halving light and skin, and cut stencils: of a lit window, whose border is sharp, and of light that goes
// on.
constexpr double kGridsOfWindow = 4e-4, kGridsOfUniform = 2e-4, kStrictGrids = 2e-4, kLooseGrids = 8e-4;
constexpr double kRounding = 1e-5;         // of single precision
constexpr double kTables = 1e-4;           // of totals, between entries of the tables
constexpr double kShareOfTolerance = 0.5;  // that margin or series may take, each

double EffectiveAttenuation(double mu_a, double mu_s) {
  return std::sqrt(3.0 * mu_a * (mu_a + mu_s));
}

// Share of a response that is left at frequency k: linear in its square between the table's.
double ShareAt(const TransformTable& table, double mu_a, double k_per_mm) {
  const auto k = TableFrequencies_per_mm();
  const auto above = std::lower_bound(k.begin(), k.end(), k_per_mm);
  const std::size_t high = std::min<std::size_t>(above - k.begin(), k.size() - 1);
  const std::size_t low = high > 0 ? high - 1 : 0;
  const double total = table.At(mu_a, 0);
  if (!(total > 0.0)) return 1.0;
  const double step = k[high] * k[high] - k[low] * k[low];
  const double way = step > 0.0 ? std::min((k_per_mm * k_per_mm - k[low] * k[low]) / step, 1.0) : 1.0;
  return std::clamp(std::lerp(table.At(mu_a, low), table.At(mu_a, high), way) / total, 0.0, 1.0);
}

// How far closed forms are off under light that goes on: what of the scene's contrast transport would level
// out, up to the frequencies that its pixels can hold.
double LocalError(const BandTables& tables, const LocalTotals& totals, const SceneRange& scene,
                  double pixel_size_mm) {
  const auto position = [](double mu_a) { return PositionInTable(static_cast<float>(mu_a)); };
  const auto A = static_cast<float>(scene.most_transmittance);
  const double bright =
      totals.Reflectance(position(scene.epidermis.lowest), position(scene.dermis.lowest), A);
  const double dark =
      totals.Reflectance(position(scene.epidermis.highest), position(scene.dermis.highest), A);
  const double contrast = (bright - dark) / (bright + dark);
  const double k = std::numbers::pi / pixel_size_mm;
  const double left = std::min(ShareAt(tables.r1_forward.transforms(), scene.epidermis.lowest, k),
                               ShareAt(tables.r2_diffuse.transforms(), scene.dermis.lowest, k));
  return contrast * (1.0 - left);
}

int Terms(double quotient, double share_from_below, double tolerance, bool close, int most) {
  int terms = 1;
  double left = share_from_below * quotient * (close ? kClosing : 1.0);
  while (left > tolerance && terms < most) {
    left *= quotient;
    ++terms;
  }
  return terms;
}

}  // namespace

BandChoice ChooseModel(const BandTables& tables, const LocalTotals& totals, double mu_s_dermis,
                       const SceneRange& scene, bool black_tape, const ImagingConditions& conditions,
                       const ForwardOptions& options, int most_terms) {
  BandChoice choice;
  const bool window = conditions.illumination == Illumination::kWindow;
  if (!window && scene.uniform_besides && options.path_lengths == kAutomaticPaths) {
    const double transport = LocalError(tables, totals, scene, conditions.pixel_size_mm);
    choice.error = std::hypot(transport, kTables);
    if (transport <= kShareOfTolerance * options.tolerance && kTables <= options.tolerance) {
      choice.rung = Rung::kLocal;
      return choice;
    }
  }
  const auto position = [](double mu_a) { return PositionInTable(static_cast<float>(mu_a)); };
  const auto A = static_cast<float>(scene.most_transmittance);
  const TablePosition e = position(scene.epidermis.lowest), d = position(scene.dermis.lowest);
  const double quotient = totals.Quotient(e, d, A, black_tape);
  const double from_below = 1.0 - totals.SurfaceReflectance(e) / totals.Reflectance(e, d, A);
  const double share = kShareOfTolerance * options.tolerance;
  choice.terms = options.terms == kAutomaticTerms
                     ? Terms(quotient, from_below, share, options.close_series, most_terms)
                     : options.terms;
  double series = from_below * std::pow(quotient, choice.terms) * (options.close_series ? kClosing : 1.0);
  double lost = 0.0;
  if (window) {
    const double kappa = EffectiveAttenuation(scene.dermis.lowest, mu_s_dermis);
    choice.margin_mm =
        options.margin_mm == kAutomaticMargin
            ? std::clamp(std::log(kLost / share) / (kFall * kappa), kLeastMargin_mm, kLargestMargin_mm)
            : options.margin_mm;
    lost = kLost * std::exp(-kFall * kappa * choice.margin_mm);
  }
  choice.error = std::hypot(series, lost);
  return choice;
}

void AddPaths(const PathPlan& plan, const PathFrames& frames, double tolerance, BandChoice& choice) {
  choice.epidermis_paths = static_cast<int>(plan.epidermis_mm.size());
  choice.dermis_paths = choice.terms > 0 ? static_cast<int>(plan.dermis_mm.size()) : 0;
  const int most = std::max(choice.epidermis_paths, choice.dermis_paths);
  choice.rung = most == 1 ? Rung::kHomogeneous : most == 2 ? Rung::kFirstOrder : Rung::kFull;
  double grids = 0.0;
  if (frames.halvings > 0)
    grids = tolerance < kStrictTolerance   ? kStrictGrids
            : tolerance >= kLooseTolerance ? kLooseGrids
            : frames.window                ? kGridsOfWindow
                                           : kGridsOfUniform;
  choice.error = std::hypot(std::hypot(choice.error, kRounding), plan.error, grids);
}

std::string Explain(const BandChoice& choice, bool window) {
  if (choice.rung == Rung::kLocal)
    return "Light goes on beyond the border, and transport would level out less than the tolerance.";
  char text[240];
  std::snprintf(
      text, sizeof text,
      "The scene's range of absorption needs %d path lengths in the epidermis and %d in the dermis, its "
      "lightest skin %d terms",
      choice.epidermis_paths, choice.dermis_paths, choice.terms);
  std::string why = text;
  std::snprintf(text, sizeof text, " and %.1f mm of skin beneath the tape.", choice.margin_mm);
  return why + (window ? text : ".");
}

}  // namespace dermap
