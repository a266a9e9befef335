// SPDX-License-Identifier: Apache-2.0
// Responses of a band: as sums of 18 Gaussians, tabulated over 256 logarithmic steps of mu_a [D08 eq. 4, 7],
// and as sums over path lengths (path_kernels.h).
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/optics/path_kernels.h"
#include "common/optics/profile_source.h"
#include "common/optics/totals_correction.h"
#include "common/tissue/tissue.h"

namespace dermap {

inline constexpr int kGaussianCount = 18;
inline constexpr double kSmallestVariance_mm2 = 0.0001;  // [D08 7] says mm; a variance is in mm^2
inline constexpr int kTableSize = 256;
inline constexpr double kTableMinMuA = 0.005;  // 1/mm
inline constexpr double kTableMaxMuA = 200.0;

// Variance of Gaussian i per axis, mm^2: each next one twice the last.
constexpr double GaussianVariance_mm2(int i) {
  return kSmallestVariance_mm2 * static_cast<double>(1 << i);
}

using GaussianWeights = std::array<float, kGaussianCount>;

// One response at one wavelength, as weights over log mu_a. A weight is the share of the incident light that
// a Gaussian (of volume 1) carries; the weights' sum is the response's total.
class ProfileTable {
 public:
  ProfileTable() = default;
  explicit ProfileTable(std::vector<GaussianWeights> entries,
                        TransformTable transforms = {});  // kTableSize entries

  // Linear interpolation in log mu_a; mu_a is clamped to the table's range.
  void Weights(float mu_a, std::span<float, kGaussianCount> weights) const noexcept;
  float Weight(int gaussian, float mu_a) const noexcept;
  // Sum of the weights, and its derivative by mu_a.
  float Total(float mu_a) const noexcept;
  float TotalDerivative(float mu_a) const noexcept;
  float EntryTotal(int index) const noexcept { return totals_[index]; }  // without interpolation
  bool empty() const noexcept { return entries_.empty(); }
  const std::vector<GaussianWeights>& entries() const noexcept { return entries_; }
  const TransformTable& transforms() const noexcept {
    return transforms_;
  }  // empty where only totals are known

 private:
  std::vector<GaussianWeights> entries_;
  TransformTable transforms_;
  std::vector<float> totals_;
};

// Position of mu_a in the table: entry index and share of the next entry. For callers that look up many
// responses of one mu_a.
struct TablePosition {
  int index;
  float fraction;
};
TablePosition PositionInTable(float mu_a) noexcept;
double TableMuA(int index);  // mu_a of an entry, 1/mm

// Lateral frequencies at which BuildBandTables asks a source, 1/mm: 0, then logarithmic to beyond what
// images of 0.03 mm pixels hold (151/mm on the diagonal). Gaussians are fitted to the first
// kGaussianFrequencies of them, up to 100/mm.
std::span<const double> TableFrequencies_per_mm();
inline constexpr int kGaussianFrequencies = 64;

// All responses of the two-layer skin at one wavelength. t1_ballistic is a scalar over mu_a (no spread): its
// weights sit in entry [0] of a GaussianWeights and must be read with Total() only.
struct BandTables {
  double wavelength_nm = 0.0;
  ProfileTable r1_forward, t1_forward, t1_ballistic;
  ProfileTable r1_backward, t1_backward;
  ProfileTable r1_backward_black;  // under black tape
  ProfileTable r2_diffuse, r2_normal;
  TotalsCorrection correction{};  // of costly sources: tables of single layers against both layers at once

  // Two-layer total for uniform skin and wide light:
  // R1+ + (Tb R2n + Td R2d) A^2 T1- / (1 - A^2 R1- R2d), A = exp(-P); with Tb = 0 the sum of [D08 eq. 7].
  double TotalReflectance(double mu_a_epidermis, double mu_a_dermis,
                          double junction_absorbance) const noexcept;
  struct TotalDerivatives {
    double reflectance, d_mu_a_epidermis, d_mu_a_dermis, d_junction_absorbance;
  };
  TotalDerivatives TotalReflectanceDerivatives(double mu_a_epidermis, double mu_a_dermis,
                                               double junction_absorbance) const noexcept;
  // The same times the correction.
  TotalDerivatives CorrectedDerivatives(double mu_a_epidermis, double mu_a_dermis,
                                        double junction_absorbance) const noexcept;
};

// Asks `source` for every response at every mu_a of the table, in parallel. A response whose total is
// negative (the multipole's transmittance of a layer thinner than a mean free path) is taken as 0, with a
// warning in the log. Throws InputError for a configuration that is out of range or that profiles cannot
// honour.
BandTables BuildBandTables(const ProfileSource& source, double wavelength_nm, const TissueConfig& config);

// The layers that a table entry stands for, mu_a in 1/mm, with the typical neighbours whose light tables
// assume.
EpidermisOptics EpidermisOpticsOf(const TissueConfig& config, double wavelength_nm, double mu_a);
DermisOptics DermisOpticsOf(const TissueConfig& config, double wavelength_nm, double mu_a);

// The same responses by every `step`-th Gaussian alone, fitted anew to the tables' transforms, in parallel;
// tables that hold totals only are left as they are.
void UseFewerGaussians(int step, BandTables& tables);

// Weights w >= 0 of the Gaussians, fitted on the transform's side by non-negative least squares, their sum
// made equal to the total transform[0] (k_per_mm[0] must be 0, the others ascend); all 0 where the total is
// not positive. A profile that is no mixture of Gaussians cannot be met exactly by weights >= 0.
GaussianWeights FitGaussianSum(std::span<const double> k_per_mm, std::span<const double> transform);

}  // namespace dermap
