// SPDX-License-Identifier: Apache-2.0
// A polynomial fitted at Chebyshev's points, where whole rows of skins share their layers.
#include "common/optics/totals_correction.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/optics/homogeneous_skin.h"
#include "common/optics/profile_table.h"

namespace dermap {
namespace {

// Absorption of skin, 1/mm: beyond, the ratio stays what it is at the end.
constexpr double kLeastMuA = 0.01, kMostMuA = 60.0;
constexpr int kEpidermisPoints = 12, kDermisPoints = 10;
constexpr std::array kPasses{1.0, 0.75, 0.4, 0.05};  // A^2 of the junction
constexpr double kDark = 0.003;  // reflectances below it count less: their last digits matter to nobody

const double kLogMiddle = 0.5 * std::log(kLeastMuA * kMostMuA);
const double kLogScale = 2.0 / std::log(kMostMuA / kLeastMuA);

// -1 to 1, and its derivative by mu_a.
struct Variable {
  double value, slope;
};
Variable VariableOf(double mu_a) {
  if (mu_a <= kLeastMuA) return {-1.0, 0.0};
  if (mu_a >= kMostMuA) return {1.0, 0.0};
  return {kLogScale * (std::log(mu_a) - kLogMiddle), kLogScale / mu_a};
}

double MuAOf(double variable) {
  return std::exp(kLogMiddle + variable / kLogScale);
}

std::vector<double> ChebyshevPoints(int count) {
  std::vector<double> points;
  for (int i = 0; i < count; ++i) points.push_back(-std::cos(std::numbers::pi * i / (count - 1)));
  return points;
}

// Calls body(term, power of x, power of y, power of A^2).
template <class Body>
void ForTerms(const Body& body) {
  int term = 0;
  for (int z = 0; z <= TotalsCorrection::kJunctionDegree; ++z)
    for (int x = 0; x <= TotalsCorrection::kDegree; ++x)
      for (int y = 0; x + y <= TotalsCorrection::kDegree; ++y) body(term++, x, y, z);
}

}  // namespace

TotalsCorrection::Ratio TotalsCorrection::At(double mu_a_epidermis, double mu_a_dermis,
                                             double junction_absorbance) const noexcept {
  const Variable x = VariableOf(mu_a_epidermis), y = VariableOf(mu_a_dermis);
  const double a2 = std::exp(-2.0 * junction_absorbance);
  std::array<double, kDegree + 2> px{1.0}, py{1.0}, pz{1.0};
  for (int i = 1; i <= kDegree; ++i) {
    px[i] = px[i - 1] * x.value;
    py[i] = py[i - 1] * y.value;
    pz[i] = pz[i - 1] * a2;
  }
  Ratio ratio;
  ForTerms([&](int term, int a, int b, int c) {
    const double coefficient = coefficients[term];
    ratio.value += coefficient * px[a] * py[b] * pz[c];
    if (a > 0) ratio.d_mu_a_epidermis += coefficient * a * px[a - 1] * py[b] * pz[c];
    if (b > 0) ratio.d_mu_a_dermis += coefficient * px[a] * b * py[b - 1] * pz[c];
    if (c > 0) ratio.d_junction_absorbance += coefficient * px[a] * py[b] * c * pz[c - 1];
  });
  ratio.d_mu_a_epidermis *= x.slope;
  ratio.d_mu_a_dermis *= y.slope;
  ratio.d_junction_absorbance *= -2.0 * a2;
  return ratio;
}

bool TotalsCorrection::IsOne() const noexcept {
  return std::all_of(coefficients.begin(), coefficients.end(), [](double c) { return c == 0.0; });
}

TotalsCorrection FitTotalsCorrection(const BandTables& tables, const TissueConfig& config) {
  std::vector<SkinRow> rows;
  std::vector<std::array<double, 3>> at;
  for (const double x : ChebyshevPoints(kEpidermisPoints))
    for (const double y : ChebyshevPoints(kDermisPoints))
      for (const double a2 : kPasses) {
        at.push_back({x, y, a2});
        rows.push_back({.mu_a_epidermis = MuAOf(x),
                        .mu_a_dermis = MuAOf(y),
                        .junction_absorbance = -0.5 * std::log(a2),
                        .mu_s_reduced_epidermis = ReducedScatteringEpidermis(tables.wavelength_nm, config),
                        .mu_s_reduced_dermis = ReducedScatteringDermis(tables.wavelength_nm, config),
                        .epidermis_thickness_mm = config.epidermis_thickness_mm});
      }
  const std::vector<SkinResponses> truth = HomogeneousSkin({}, config).Evaluate(rows, {});
  Eigen::MatrixXd basis(rows.size(), TotalsCorrection::kTerms);
  Eigen::VectorXd excess(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double table =
        tables.TotalReflectance(rows[i].mu_a_epidermis, rows[i].mu_a_dermis, rows[i].junction_absorbance);
    const auto row = static_cast<Eigen::Index>(i);
    const double weight = table / (table + kDark);
    excess[row] = weight * (truth[i].reflectance / table - 1.0);
    ForTerms([&](int term, int a, int b, int c) {
      basis(row, term) = weight * std::pow(at[i][0], a) * std::pow(at[i][1], b) * std::pow(at[i][2], c);
    });
  }
  const Eigen::VectorXd solution = basis.colPivHouseholderQr().solve(excess);
  TotalsCorrection correction;
  std::copy(solution.begin(), solution.end(), correction.coefficients.begin());
  return correction;
}

}  // namespace dermap
