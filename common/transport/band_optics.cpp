// SPDX-License-Identifier: Apache-2.0
// Filter nodes and their tables.
#include "common/transport/band_optics.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>

#include "common/core/parallel.h"
#include "common/optics/sampled_source.h"
#include "common/optics/table_cache.h"

namespace dermap {
namespace {

constexpr double kFwhmPerSigma = 2.3548200450309493;  // 2 sqrt(2 ln 2)
constexpr int kMostAutomaticTerms = 12;

// Nodes and weights for a Gaussian of mean 0 and variance 1, from the Jacobi matrix of its orthogonal
// polynomials [Golub and Welsch, "Calculation of Gauss quadrature rules", Math. Comp. 23, 1969].
// wavelength_nm holds the node.
std::vector<FilterNode> GaussHermite(int count) {
  Eigen::VectorXd off_diagonal(count - 1);
  for (int i = 0; i < count - 1; ++i) off_diagonal[i] = std::sqrt(i + 1.0);
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(Eigen::VectorXd::Zero(count), off_diagonal);
  std::vector<FilterNode> nodes(count);
  for (int i = 0; i < count; ++i) {
    nodes[i] = {solver.eigenvalues()[i], std::pow(solver.eigenvectors()(0, i), 2)};
  }
  nodes[count / 2].wavelength_nm = 0.0;
  return nodes;
}

// A table that only its totals are read of. What the multipole makes negative counts as nothing.
ProfileTable TotalsOnly(const std::vector<double>& totals) {
  std::vector<GaussianWeights> entries(kTableSize, GaussianWeights{});
  for (int i = 0; i < kTableSize; ++i) entries[i][0] = static_cast<float>(std::max(0.0, totals[i]));
  return ProfileTable(std::move(entries));
}

BandTables AskForTotals(const ProfileSource& source, double wavelength_nm, const TissueConfig& tissue) {
  const double total_only[] = {0.0};
  std::array<std::vector<double>, 8> totals;
  for (std::vector<double>& values : totals) values.resize(kTableSize);
  const auto ask = [&](const ProfileSource& from, int i) {
    EpidermisOptics epidermis = EpidermisOpticsOf(tissue, wavelength_nm, TableMuA(i));
    const EpidermisTransforms upper = from.Epidermis(epidermis, total_only);
    epidermis.black_above = true;
    const EpidermisTransforms taped = from.Epidermis(epidermis, total_only);
    const DermisTransforms lower =
        from.Dermis(DermisOpticsOf(tissue, wavelength_nm, TableMuA(i)), total_only);
    totals[0][i] = upper.r_forward[0];
    totals[1][i] = upper.t_forward[0];
    totals[2][i] = upper.t_ballistic;
    totals[3][i] = upper.r_backward[0];
    totals[4][i] = upper.t_backward[0];
    totals[5][i] = taped.r_backward[0];
    totals[6][i] = lower.r_diffuse[0];
    totals[7][i] = lower.r_normal[0];
  };
  if (source.IsCostly()) {
    const SampledSource sampled(source, EpidermisOpticsOf(tissue, wavelength_nm, 0.0),
                                DermisOpticsOf(tissue, wavelength_nm, 0.0), total_only, kTableMinMuA,
                                kTableMaxMuA);
    for (int i = 0; i < kTableSize; ++i) ask(sampled, i);
  } else {
    for (int i = 0; i < kTableSize; ++i) ask(source, i);
  }
  BandTables tables;
  tables.wavelength_nm = wavelength_nm;
  ProfileTable* const responses[] = {&tables.r1_forward,  &tables.t1_forward,  &tables.t1_ballistic,
                                     &tables.r1_backward, &tables.t1_backward, &tables.r1_backward_black,
                                     &tables.r2_diffuse,  &tables.r2_normal};
  for (int i = 0; i < 8; ++i) *responses[i] = TotalsOnly(totals[i]);
  return tables;
}

}  // namespace

std::vector<FilterNode> FilterNodes(const Band& band) {
  if (band.fwhm_nm <= 0.0) return {{band.wavelength_nm, 1.0}};
  const int count = 5 + 2 * std::max(0, static_cast<int>(std::ceil(band.fwhm_nm / 10.0 - 1e-9)) - 1);
  std::vector<FilterNode> nodes = GaussHermite(count);
  for (FilterNode& node : nodes)
    node.wavelength_nm = band.wavelength_nm + node.wavelength_nm * band.fwhm_nm / kFwhmPerSigma;
  return nodes;
}

BandTables BuildBandTotals(const ProfileSource& source, double wavelength_nm, const TissueConfig& tissue) {
  if (!source.IsCostly()) return AskForTotals(source, wavelength_nm, tissue);
  const TableCache cache;
  const std::string recipe = TableCache::TotalsRecipe(source.Name(), wavelength_nm, tissue);
  if (auto kept = cache.Load(recipe)) return *std::move(kept);
  BandTables tables = AskForTotals(source, wavelength_nm, tissue);
  tables.correction = FitTotalsCorrection(tables, tissue);
  cache.Store(recipe, tables);
  return tables;
}

std::vector<BandOptics> BuildBandOptics(const Chromophores& chromophores, const ProfileSource& source,
                                        const TissueConfig& tissue, std::span<const Band> bands,
                                        bool all_profiles, const ProgressFunction& progress) {
  struct Job {
    BandOptics::Node* node;
    FilterNode filter;
    bool profiles;
  };
  std::vector<BandOptics> optics(bands.size());
  std::vector<Job> jobs;
  for (std::size_t band = 0; band < bands.size(); ++band) {
    const std::vector<FilterNode> filter = FilterNodes(bands[band]);
    optics[band].band = bands[band];
    optics[band].center = static_cast<int>(filter.size() / 2);
    optics[band].nodes.resize(filter.size());
    for (int i = 0; i < static_cast<int>(filter.size()); ++i) {
      jobs.push_back({&optics[band].nodes[i], filter[i], all_profiles || i == optics[band].center});
    }
  }
  std::mutex mutex;
  int done = 0;
  ParallelFor(static_cast<int>(jobs.size()), [&](int i) {
    const auto& [node, filter, profiles] = jobs[i];
    node->weight = filter.weight;
    node->mu_s_epidermis = ReducedScatteringEpidermis(filter.wavelength_nm, tissue);
    node->mu_s_dermis = ReducedScatteringDermis(filter.wavelength_nm, tissue);
    node->absorbers = chromophores.At(filter.wavelength_nm, tissue);
    node->tables = profiles ? BuildBandTables(source, filter.wavelength_nm, tissue)
                            : BuildBandTotals(source, filter.wavelength_nm, tissue);
    if (!progress) return;
    const std::lock_guard lock(mutex);
    progress(static_cast<double>(++done) / static_cast<double>(jobs.size()));
  });
  return optics;
}

int AutomaticTerms(const BandOptics& band, const TissueConfig& tissue) {
  // C_m, beta_m, C_he, C_bc, C_hd: hardly any pigment, hardly any blood.
  constexpr ParameterVector kLightestSkin = {0.005, 0.62, 0.002, 0.0, 0.005};
  const BandOptics::Node& center = band.nodes[band.center];
  const double quotient =
      LocalTotals(center.tables)
          .Quotient(PositionInTable(static_cast<float>(center.absorbers.MuAEpidermis(kLightestSkin))),
                    PositionInTable(static_cast<float>(center.absorbers.MuADermis(kLightestSkin))),
                    static_cast<float>(std::exp(-tissue.junction_absorbance)), false);
  double remainder = quotient / (1.0 - quotient);
  int terms = 1;
  while (remainder > kSeriesRemainder && terms < kMostAutomaticTerms) {
    remainder *= quotient;
    ++terms;
  }
  return terms;
}

LocalTotals::LocalTotals(const BandTables& tables) {
  const auto sum = [](const ProfileTable& table, Totals& totals) {
    for (int i = 0; i < kTableSize; ++i) {
      const GaussianWeights& weights = table.entries()[i];
      totals[i] = static_cast<float>(std::accumulate(weights.begin(), weights.end(), 0.0));
    }
    totals[kTableSize] = totals[kTableSize - 1];
  };
  sum(tables.r1_forward, r1_forward_);
  sum(tables.t1_forward, t1_forward_);
  sum(tables.t1_ballistic, t1_ballistic_);
  sum(tables.r1_backward, r1_backward_);
  sum(tables.r1_backward_black, r1_backward_black_);
  sum(tables.t1_backward, t1_backward_);
  sum(tables.r2_diffuse, r2_diffuse_);
  sum(tables.r2_normal, r2_normal_);
  has_ballistic_ = std::any_of(t1_ballistic_.begin(), t1_ballistic_.end(), [](float t) { return t > 0.0f; });
}

float LocalTotals::Reflectance(TablePosition epidermis, TablePosition dermis,
                               float transmittance) const noexcept {
  const float a2 = transmittance * transmittance;
  const float r2 = At(r2_diffuse_, dermis);
  const float up = At(t1_ballistic_, epidermis) * At(r2_normal_, dermis) + At(t1_forward_, epidermis) * r2;
  return At(r1_forward_, epidermis) +
         up * a2 * At(t1_backward_, epidermis) / (1.0f - a2 * At(r1_backward_, epidermis) * r2);
}

float LocalTotals::Quotient(TablePosition epidermis, TablePosition dermis, float transmittance,
                            bool black_tape) const noexcept {
  return transmittance * transmittance * At(black_tape ? r1_backward_black_ : r1_backward_, epidermis) *
         At(r2_diffuse_, dermis);
}

}  // namespace dermap
