// SPDX-License-Identifier: Apache-2.0
// Tables of Gaussian weights over log mu_a, and the two-layer total that follows from them.
#include "common/optics/profile_table.h"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <mutex>
#include <utility>

#include "common/core/error.h"
#include "common/core/parallel.h"
#include "common/optics/gaussian_sum.h"
#include "common/optics/sampled_source.h"
#include "common/optics/table_cache.h"

namespace dermap {
namespace {

// Functions, since a constant of this file might be used before it is set; compilers fold them.
inline double LogMinMuA() noexcept {
  return std::log(kTableMinMuA);
}
inline double LogStep() noexcept {
  return std::log(kTableMaxMuA / kTableMinMuA) / (kTableSize - 1);
}

// Position in double precision, and d position / d mu_a (0 where mu_a is clamped).
struct FinePosition {
  int index;
  double fraction;
  double slope;
};

FinePosition FinePositionInTable(double mu_a) noexcept {
  if (!(mu_a > kTableMinMuA)) return {0, 0.0, 0.0};  // NaN as well
  if (mu_a >= kTableMaxMuA) return {kTableSize - 2, 1.0, 0.0};
  const double position = (std::log(mu_a) - LogMinMuA()) / LogStep();
  const int index = std::clamp(static_cast<int>(position), 0, kTableSize - 2);
  return {index, position - index, 1.0 / (LogStep() * mu_a)};
}

// A total of the interpolated table, and its derivative by mu_a.
struct Value {
  double value, slope;
};

Value TotalAt(const ProfileTable& table, const FinePosition& at) noexcept {
  const double below = table.EntryTotal(at.index);
  const double above = table.EntryTotal(at.index + 1);
  return {below + at.fraction * (above - below), at.slope * (above - below)};
}

}  // namespace

// In single precision, for loops over pixels: the share is off by up to 2e-5, and weights by a 1e-6 of
// themselves.
TablePosition PositionInTable(float mu_a) noexcept {
  if (!(mu_a > static_cast<float>(kTableMinMuA))) return {0, 0.0f};  // NaN as well
  const auto first = static_cast<float>(LogMinMuA());
  const auto steps = static_cast<float>(1.0 / LogStep());
  const float position = std::min((std::log(mu_a) - first) * steps, static_cast<float>(kTableSize - 1));
  const int index = std::clamp(static_cast<int>(position), 0, kTableSize - 2);
  return {index, std::max(position - static_cast<float>(index), 0.0f)};
}

double TableMuA(int index) {
  assert(index >= 0 && index < kTableSize);
  return std::exp(LogMinMuA() + index * LogStep());
}

std::span<const double> TableFrequencies_per_mm() {
  constexpr int kCount = kGaussianFrequencies + 4;
  constexpr double kFirst_per_mm = 0.02;  // below it even the widest Gaussian's transform is 1
  constexpr double kLastFitted_per_mm = 100.0;
  static const std::vector<double> frequencies = [] {
    std::vector<double> k(kCount, 0.0);
    for (int i = 1; i < kCount; ++i) {
      k[i] = kFirst_per_mm *
             std::pow(kLastFitted_per_mm / kFirst_per_mm, (i - 1) / (kGaussianFrequencies - 2.0));
    }
    return k;
  }();
  return frequencies;
}

ProfileTable::ProfileTable(std::vector<GaussianWeights> entries, TransformTable transforms)
    : entries_(std::move(entries)), transforms_(std::move(transforms)) {
  assert(entries_.size() == static_cast<std::size_t>(kTableSize));
  totals_.reserve(entries_.size());
  for (const auto& entry : entries_) {
    double total = 0.0;
    for (const float weight : entry) total += weight;
    totals_.push_back(static_cast<float>(total));
  }
}

void ProfileTable::Weights(float mu_a, std::span<float, kGaussianCount> weights) const noexcept {
  const auto [index, fraction] = PositionInTable(mu_a);
  const auto& below = entries_[index];
  const auto& above = entries_[index + 1];
  for (int i = 0; i < kGaussianCount; ++i) weights[i] = below[i] + fraction * (above[i] - below[i]);
}

float ProfileTable::Weight(int gaussian, float mu_a) const noexcept {
  const auto [index, fraction] = PositionInTable(mu_a);
  const float below = entries_[index][gaussian];
  return below + fraction * (entries_[index + 1][gaussian] - below);
}

float ProfileTable::Total(float mu_a) const noexcept {
  return static_cast<float>(TotalAt(*this, FinePositionInTable(mu_a)).value);
}

float ProfileTable::TotalDerivative(float mu_a) const noexcept {
  return static_cast<float>(TotalAt(*this, FinePositionInTable(mu_a)).slope);
}

double BandTables::TotalReflectance(double mu_a_epidermis, double mu_a_dermis,
                                    double junction_absorbance) const noexcept {
  return TotalReflectanceDerivatives(mu_a_epidermis, mu_a_dermis, junction_absorbance).reflectance;
}

BandTables::TotalDerivatives BandTables::TotalReflectanceDerivatives(
    double mu_a_epidermis, double mu_a_dermis, double junction_absorbance) const noexcept {
  const auto epidermis = FinePositionInTable(mu_a_epidermis);
  const auto dermis = FinePositionInTable(mu_a_dermis);
  const auto r1f = TotalAt(r1_forward, epidermis), t1f = TotalAt(t1_forward, epidermis);
  const auto r1b = TotalAt(r1_backward, epidermis), t1b = TotalAt(t1_backward, epidermis);
  const auto ballistic = TotalAt(t1_ballistic, epidermis);
  const auto r2d = TotalAt(r2_diffuse, dermis), r2n = TotalAt(r2_normal, dermis);

  const double a2 = std::exp(-2.0 * junction_absorbance);  // A^2 [D08 eq. 8]
  const double first =
      ballistic.value * r2n.value + t1f.value * r2d.value;         // first time back at the junction
  const double series = 1.0 / (1.0 - a2 * r1b.value * r2d.value);  // sum of [D08 eq. 7]
  const double through = a2 * t1b.value * series;                  // out of the epidermis again
  const double per_round_trip = first * through * a2 * series;     // d through / d (R1- R2)
  return {.reflectance = r1f.value + first * through,
          .d_mu_a_epidermis = r1f.slope + (ballistic.slope * r2n.value + t1f.slope * r2d.value) * through +
                              first * a2 * t1b.slope * series + per_round_trip * r1b.slope * r2d.value,
          .d_mu_a_dermis = (ballistic.value * r2n.slope + t1f.value * r2d.slope) * through +
                           per_round_trip * r1b.value * r2d.slope,
          .d_junction_absorbance = -2.0 * first * through * series};
}

BandTables::TotalDerivatives BandTables::CorrectedDerivatives(double mu_a_epidermis, double mu_a_dermis,
                                                              double junction_absorbance) const noexcept {
  const TotalDerivatives t = TotalReflectanceDerivatives(mu_a_epidermis, mu_a_dermis, junction_absorbance);
  const TotalsCorrection::Ratio ratio = correction.At(mu_a_epidermis, mu_a_dermis, junction_absorbance);
  const auto product = [&](double of_table, double of_ratio) {
    return ratio.value * of_table + of_ratio * t.reflectance;
  };
  return {.reflectance = ratio.value * t.reflectance,
          .d_mu_a_epidermis = product(t.d_mu_a_epidermis, ratio.d_mu_a_epidermis),
          .d_mu_a_dermis = product(t.d_mu_a_dermis, ratio.d_mu_a_dermis),
          .d_junction_absorbance = product(t.d_junction_absorbance, ratio.d_junction_absorbance)};
}

namespace {

enum Response {
  kR1Forward,
  kT1Forward,
  kT1Ballistic,
  kR1Backward,
  kT1Backward,
  kR1BackwardBlack,
  kR2Diffuse,
  kR2Normal
};
constexpr int kResponseCount = 8;
using TableEntry = std::array<GaussianWeights, kResponseCount>;

struct EntryResult {
  TableEntry weights{};
  std::array<std::vector<double>, kResponseCount> transforms;
  bool clamped = false;  // a total below 0 was taken as 0
};

// The dermis under which diffuse light's directions are taken, 1/mm: blood of average skin [D08 table 1],
// less than it where hemoglobin absorbs strongly, since the skins that matter most there are the clear ones.
double TypicalDermisAbsorption(double wavelength_nm) {
  return wavelength_nm < 595.0 ? 0.3 : 0.08;
}

EntryResult BuildEntry(const ProfileSource& source, const GaussianFitter& fitter, double wavelength_nm,
                       const TissueConfig& config, double mu_a, const EntryResult& neighbour) {
  const auto k = TableFrequencies_per_mm();
  auto optics = EpidermisOpticsOf(config, wavelength_nm, mu_a);
  const auto epidermis = source.Epidermis(optics, k);
  optics.black_above = true;
  const auto taped = source.Epidermis(optics, k);
  const auto dermis = source.Dermis(DermisOpticsOf(config, wavelength_nm, mu_a), k);

  EntryResult entry;
  const auto fit = [&](Response response, std::vector<double> transform) {
    entry.clamped = entry.clamped || transform[0] < 0.0;
    if (transform[0] <= 0.0) std::fill(transform.begin(), transform.end(), 0.0);
    entry.weights[response] =
        fitter.Fit(std::span(transform).first(kGaussianFrequencies), neighbour.weights[response]);
    entry.transforms[response] = std::move(transform);
  };
  fit(kR1Forward, epidermis.r_forward);
  fit(kT1Forward, epidermis.t_forward);
  fit(kR1Backward, epidermis.r_backward);
  fit(kT1Backward, epidermis.t_backward);
  fit(kR1BackwardBlack, taped.r_backward);
  fit(kR2Diffuse, dermis.r_diffuse);
  if (dermis.r_normal == dermis.r_diffuse) {
    entry.weights[kR2Normal] = entry.weights[kR2Diffuse];
    entry.transforms[kR2Normal] = entry.transforms[kR2Diffuse];
  } else {
    fit(kR2Normal, dermis.r_normal);
  }
  entry.weights[kT1Ballistic][0] = static_cast<float>(epidermis.t_ballistic);
  return entry;
}

ProfileTable Column(const std::vector<EntryResult>& entries, Response response) {
  std::vector<GaussianWeights> weights;
  std::vector<float> transforms;
  for (const EntryResult& entry : entries) {
    weights.push_back(entry.weights[response]);
    transforms.insert(transforms.end(), entry.transforms[response].begin(), entry.transforms[response].end());
  }
  return ProfileTable(std::move(weights), TransformTable(std::move(transforms)));
}

void WarnOfClamping(const std::vector<EntryResult>& entries, std::string_view source, double wavelength_nm) {
  for (int i = kTableSize - 1; i >= 0; --i) {
    if (!entries[i].clamped) continue;
    spdlog::warn(
        "At {} nm the profiles '{}' give less than no light for some mu_a up to {:.3g}/mm: the layer is "
        "thinner than "
        "their mean free path. These totals are taken as 0; results there are not to be trusted.",
        wavelength_nm, source, TableMuA(i));
    return;
  }
}

BandTables TablesFrom(const ProfileSource& source, double wavelength_nm, const TissueConfig& config) {
  const GaussianFitter fitter(TableFrequencies_per_mm().first(kGaussianFrequencies));
  std::vector<EntryResult> entries(kTableSize);
  // Along a run each fit starts from its neighbour's; runs are the same for any number of threads.
  constexpr int kRun = 8;
  static_assert(kTableSize % kRun == 0);
  ParallelFor(kTableSize / kRun, [&](int run) {
    EntryResult neighbour;
    for (int i = run * kRun; i < (run + 1) * kRun; ++i) {
      neighbour = entries[i] = BuildEntry(source, fitter, wavelength_nm, config, TableMuA(i), neighbour);
    }
  });
  WarnOfClamping(entries, source.Name(), wavelength_nm);
  return {.wavelength_nm = wavelength_nm,
          .r1_forward = Column(entries, kR1Forward),
          .t1_forward = Column(entries, kT1Forward),
          .t1_ballistic = Column(entries, kT1Ballistic),
          .r1_backward = Column(entries, kR1Backward),
          .t1_backward = Column(entries, kT1Backward),
          .r1_backward_black = Column(entries, kR1BackwardBlack),
          .r2_diffuse = Column(entries, kR2Diffuse),
          .r2_normal = Column(entries, kR2Normal),
          .correction = {}};
}

// A costly source is asked at few absorptions, and what comes of it is kept.
BandTables TablesFromCostly(const ProfileSource& source, double wavelength_nm, const TissueConfig& config) {
  const TableCache cache;
  const std::string recipe = TableCache::Recipe(source.Name(), wavelength_nm, config);
  if (auto kept = cache.Load(recipe)) return *std::move(kept);
  const SampledSource sampled(source, EpidermisOpticsOf(config, wavelength_nm, 0.0),
                              DermisOpticsOf(config, wavelength_nm, 0.0), TableFrequencies_per_mm(),
                              kTableMinMuA, kTableMaxMuA);
  BandTables tables = TablesFrom(sampled, wavelength_nm, config);
  tables.correction = FitTotalsCorrection(tables, config);
  cache.Store(recipe, tables);
  return tables;
}

}  // namespace

EpidermisOptics EpidermisOpticsOf(const TissueConfig& config, double wavelength_nm, double mu_a) {
  return {.layer = {.mu_a = mu_a,
                    .mu_s_reduced = ReducedScatteringEpidermis(wavelength_nm, config),
                    .n = config.n_epidermis,
                    .anisotropy = config.anisotropy},
          .thickness_mm = config.epidermis_thickness_mm,
          .n_above = config.n_outside,
          .n_below = config.n_dermis,
          .dermis = {.mu_a = TypicalDermisAbsorption(wavelength_nm)}};
}

DermisOptics DermisOpticsOf(const TissueConfig& config, double wavelength_nm, double mu_a) {
  return {.layer = {.mu_a = mu_a,
                    .mu_s_reduced = ReducedScatteringDermis(wavelength_nm, config),
                    .n = config.n_dermis,
                    .anisotropy = config.anisotropy},
          .n_above = config.n_epidermis,
          .epidermis_thickness_mm = config.epidermis_thickness_mm};
}

BandTables BuildBandTables(const ProfileSource& source, double wavelength_nm, const TissueConfig& config) {
  Validate(config);
  if (config.anisotropy != 0.0 && !source.KnowsAnisotropy()) {
    throw InputError(
        fmt::format("[tissue] anisotropy is {}, but the profiles '{}' know only isotropic (reduced) "
                    "scattering; set it to 0 or take "
                    "the profiles 'exact'.",
                    config.anisotropy, source.Name()));
  }
  if (config.anisotropy != 0.0) {
    static std::once_flag once;
    std::call_once(once, [&] {
      spdlog::warn(
          "[tissue] anisotropy is {}: totals honour it within 2 %, but light spreads sideways as with "
          "isotropic scattering; "
          "features narrower than a few mm are not to be trusted.",
          config.anisotropy);
    });
  }
  return source.IsCostly() ? TablesFromCostly(source, wavelength_nm, config)
                           : TablesFrom(source, wavelength_nm, config);
}

void UseFewerGaussians(int step, BandTables& tables) {
  const GaussianFitter fitter(TableFrequencies_per_mm().first(kGaussianFrequencies), step);
  const std::size_t frequencies = TableFrequencies_per_mm().size();
  ProfileTable* const responses[] = {&tables.r1_forward,       &tables.t1_forward, &tables.r1_backward,
                                     &tables.t1_backward,      &tables.r2_diffuse, &tables.r2_normal,
                                     &tables.r1_backward_black};
  for (ProfileTable* response : responses) {
    const std::vector<float>& values = response->transforms().values();
    if (values.empty()) continue;
    std::vector<GaussianWeights> entries(kTableSize);
    ParallelFor(kTableSize, [&](int i) {
      const float* first = values.data() + static_cast<std::size_t>(i) * frequencies;
      entries[i] = fitter.Fit(std::vector<double>(first, first + kGaussianFrequencies));
    });
    *response = ProfileTable(std::move(entries), response->transforms());
  }
}

}  // namespace dermap
