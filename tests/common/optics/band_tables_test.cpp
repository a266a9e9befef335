// SPDX-License-Identifier: Apache-2.0
// The tables of a band against the source they were made from, and the two-layer total that follows from
// them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/core/error.h"
#include "common/optics/gaussian_sum.h"
#include "common/optics/layers.h"
#include "common/optics/multipole.h"
#include "tests/common/optics/dipole_sum.h"

namespace dermap {
namespace {

const BandTables& TablesAt(int wavelength_nm) {
  static const BandTables kBlue = BuildBandTables(*MakeProfileSource("multipole"), 450.0, {});
  static const BandTables kRed = BuildBandTables(*MakeProfileSource("multipole"), 650.0, {});
  return wavelength_nm == 450 ? kBlue : kRed;
}

// What the source says, response by response.
struct Direct {
  EpidermisTransforms epidermis;
  DermisTransforms dermis;
  std::vector<double> r1_forward, t1_forward, r1_backward, t1_backward, r1_black, r2_diffuse, r2_normal;
};

Direct AskSource(double wavelength_nm, double mu_a, std::span<const double> k) {
  const auto source = MakeProfileSource("multipole");
  EpidermisOptics optics{.layer = {mu_a, ReducedScatteringEpidermis(wavelength_nm, {}), 1.4}};
  Direct direct;
  direct.epidermis = source->Epidermis(optics, k);
  direct.dermis = source->Dermis({.layer = {mu_a, ReducedScatteringDermis(wavelength_nm, {}), 1.38}}, k);
  direct.r1_forward = direct.epidermis.r_forward;
  direct.t1_forward = direct.epidermis.t_forward;
  direct.r1_backward = direct.epidermis.r_backward;
  direct.t1_backward = direct.epidermis.t_backward;
  optics.black_above = true;
  direct.r1_black = source->Epidermis(optics, k).r_backward;
  direct.r2_diffuse = direct.dermis.r_diffuse;
  direct.r2_normal = direct.dermis.r_normal;
  return direct;
}

struct Column {
  const char* name;
  const ProfileTable BandTables::*table;
  const std::vector<double> Direct::*transform;
};

constexpr Column kT1Backward{"T1-", &BandTables::t1_backward, &Direct::t1_backward};
constexpr Column kColumns[] = {{"R1+", &BandTables::r1_forward, &Direct::r1_forward},
                               {"T1+", &BandTables::t1_forward, &Direct::t1_forward},
                               {"R1-", &BandTables::r1_backward, &Direct::r1_backward},
                               kT1Backward,
                               {"R1- black", &BandTables::r1_backward_black, &Direct::r1_black},
                               {"R2", &BandTables::r2_diffuse, &Direct::r2_diffuse},
                               {"R2 normal", &BandTables::r2_normal, &Direct::r2_normal}};

// The source itself, at mu_a between the table's entries: totals within 1e-3 of themselves from 0.03 to 40
// per mm.
TEST(BandTables, TotalsAreTheSources) {
  const double k[] = {0.0};
  for (const int wavelength : {450, 650}) {
    for (double mu_a = 0.0301; mu_a < 40.0; mu_a *= 1.217) {
      const auto direct = AskSource(wavelength, mu_a, k);
      for (const auto& column : kColumns) {
        const double expected = (direct.*column.transform)[0];
        EXPECT_NEAR((TablesAt(wavelength).*column.table).Total(static_cast<float>(mu_a)), expected,
                    1e-3 * expected + 5e-5)
            << column.name << " at " << wavelength << " nm, mu_a " << mu_a;
      }
    }
  }
}

// Largest difference of an entry's transform from the source's at k = 0 and 0.01 to 60 per mm, as a share of
// the total, or of the incident light.
double WorstShapeError(const Column& column, int wavelength_nm, int entry, bool of_total) {
  std::vector<double> k{0.0};
  for (int i = 0; i < 100; ++i) k.push_back(0.01 * std::pow(6000.0, i / 99.0));
  const Direct direct = AskSource(wavelength_nm, TableMuA(entry), k);
  const auto& transform = direct.*column.transform;
  const auto& weights = (TablesAt(wavelength_nm).*column.table).entries()[entry];
  double worst = 0.0;
  for (std::size_t i = 0; i < k.size(); ++i) {
    worst = std::max(worst, std::abs(GaussianSumTransform(weights, k[i]) - transform[i]));
  }
  return of_total ? worst / transform[0] : worst;
}

// The source itself at 450 nm, from 0.03 to 40 per mm: transforms within 1e-4 of the total for what reflects,
// and within 1e-5 of the incident light for what crosses (where less than 1e-4 of it crosses, the profile is
// close to one Gaussian of a variance between two of ours, and 18 of them miss 0.5 % of that little).
TEST(BandTables, ShapesAreTheSources) {
  for (int entry = 0; entry < kTableSize; entry += 5) {
    if (TableMuA(entry) < 0.03 || TableMuA(entry) > 40.0) continue;
    for (const auto& column : kColumns) {
      const bool crosses = column.name[0] == 'T';
      EXPECT_LT(WorstShapeError(column, 450, entry, !crosses), crosses ? 1e-5 : 1e-4)
          << column.name << ", mu_a " << TableMuA(entry);
    }
  }
}

// The edge of the method. In red light and a clear epidermis the multipole itself sends less than no light
// out at a distance: its own sum of dipoles is negative there (the extrapolated top face lies further off
// than everything else). Weights >= 0 cannot hold that, and miss up to 2 % of the total. Where the dipoles
// stay positive they miss nothing.
TEST(BandTables, MissTheShapeOnlyWhereTheMultipoleIsNegative) {
  const auto smallest_dipole_sum = [](int wavelength_nm, int entry) {
    const DipoleSlab from_below{TableMuA(entry), ReducedScatteringEpidermis(wavelength_nm, {}), 0.25,
                                BoundaryMismatch(1.4, 1.38), BoundaryMismatch(1.4, 1.0)};
    double smallest = 1.0;
    for (double r = 0.1; r < 3.0; r += 0.1)
      smallest = std::min(smallest, DipoleSumTransmittance(from_below, r));
    return smallest;
  };
  constexpr int kClear = 44;  // 0.031 per mm
  EXPECT_LT(smallest_dipole_sum(650, kClear), -1e-4);
  EXPECT_GT(WorstShapeError(kT1Backward, 650, kClear, true), 1e-3);
  EXPECT_LT(WorstShapeError(kT1Backward, 650, kClear, true), 2e-2);
  EXPECT_GT(smallest_dipole_sum(450, kClear), 0.0);
  EXPECT_LT(WorstShapeError(kT1Backward, 450, kClear, true), 1e-4);
}

// [D08 eq. 3 and 7] at k = 0, straight from the source: no table, no Gaussians.
TEST(BandTables, TwoLayerTotalIsTheSources) {
  const double k[] = {0.0};
  for (const auto& [mu_a_epidermis, mu_a_dermis, p] :
       {std::array{0.2, 0.1, 0.0175}, {5.0, 1.3, 0.0175}, {0.05, 0.05, 1.0}, {20.0, 3.0, 0.0}}) {
    const double expected = TwoLayerReflectance(AskSource(450.0, mu_a_epidermis, k).epidermis,
                                                AskSource(450.0, mu_a_dermis, k).dermis, p)[0];
    EXPECT_NEAR(TablesAt(450).TotalReflectance(mu_a_epidermis, mu_a_dermis, p), expected, 5e-4 * expected);
  }
}

// The terms of [D08 eq. 7], summed one by one with the tables' totals.
TEST(BandTables, ClosedFormIsTheSeriesOfEquation7) {
  const auto& tables = TablesAt(450);
  const float e = 0.7f, d = 0.4f;
  const double a = std::exp(-0.3), r2 = tables.r2_diffuse.Total(d);
  double sum = tables.r1_forward.Total(e), upward = tables.t1_forward.Total(e) * a * r2 * a;
  for (int n = 0; n < 100; ++n) {
    sum += upward * tables.t1_backward.Total(e);
    upward *= tables.r1_backward.Total(e) * a * r2 * a;
  }
  EXPECT_NEAR(tables.TotalReflectance(e, d, 0.3), sum, 1e-7);
}

// A table with made-up entries: every response depends on mu_a and there is ballistic light.
BandTables MadeUpTables() {
  const auto ramp = [](double first, double last) {
    std::vector<GaussianWeights> entries(kTableSize);
    for (int j = 0; j < kTableSize; ++j) {
      entries[j][0] = static_cast<float>(first + (last - first) * std::pow(j / 255.0, 2));
    }
    return ProfileTable(std::move(entries));
  };
  return {.wavelength_nm = 500.0,
          .r1_forward = ramp(0.4, 0.02),
          .t1_forward = ramp(0.5, 0.01),
          .t1_ballistic = ramp(0.2, 0.001),
          .r1_backward = ramp(0.7, 0.05),
          .t1_backward = ramp(0.3, 0.01),
          .r1_backward_black = ramp(0.2, 0.01),
          .r2_diffuse = ramp(0.9, 0.05),
          .r2_normal = ramp(0.95, 0.03)};
}

// Central differences inside one step of the table, where the interpolation is smooth.
TEST(BandTables, DerivativesAreExact) {
  const auto tables = MadeUpTables();
  const double e = TableMuA(90) * 1.02, d = TableMuA(60) * 1.02, p = 0.4;
  const auto derivatives = tables.TotalReflectanceDerivatives(e, d, p);
  EXPECT_EQ(derivatives.reflectance, tables.TotalReflectance(e, d, p));
  const double h = 1e-4;
  const auto slope = [&](double de, double dd, double dp) {
    return (tables.TotalReflectance(e + de, d + dd, p + dp) -
            tables.TotalReflectance(e - de, d - dd, p - dp)) /
           (2.0 * (de + dd + dp));
  };
  EXPECT_NEAR(derivatives.d_mu_a_epidermis / slope(h * e, 0.0, 0.0), 1.0, 1e-6);
  EXPECT_NEAR(derivatives.d_mu_a_dermis / slope(0.0, h * d, 0.0), 1.0, 1e-6);
  EXPECT_NEAR(derivatives.d_junction_absorbance / slope(0.0, 0.0, h), 1.0, 1e-6);
}

// By hand for the first entries: 0.4 + (0.2*0.95 + 0.5*0.9) * A^2 * 0.3 / (1 - A^2 * 0.7 * 0.9), A^2 =
// exp(-0.8).
TEST(BandTables, BallisticLightMeetsTheNormalResponse) {
  const double a2 = std::exp(-0.8);
  EXPECT_NEAR(MadeUpTables().TotalReflectance(0.0, 0.0, 0.4), 0.4 + 0.64 * a2 * 0.3 / (1.0 - a2 * 0.63),
              1e-7);
}

// The same table for any number of threads, bit by bit (the claim of parallel.h).
TEST(BandTables, AreReproducible) {
  const auto again = BuildBandTables(*MakeProfileSource("multipole"), 450.0, {});
  EXPECT_EQ(again.t1_backward.entries(), TablesAt(450).t1_backward.entries());
  EXPECT_EQ(again.r2_diffuse.entries(), TablesAt(450).r2_diffuse.entries());
}

// An epidermis thinner than a mean free path: the multipole's transmittance is negative, the table's is 0,
// never less.
TEST(BandTables, TakeNegativeLightAsNone) {
  TissueConfig config;
  config.epidermis_thickness_mm = 0.08;
  const double k[] = {0.0};
  EpidermisOptics epidermis{.layer = {0.1, ReducedScatteringEpidermis(450.0, config), 1.4},
                            .thickness_mm = 0.08};
  ASSERT_LT(MakeProfileSource("multipole")->Epidermis(epidermis, k).t_forward[0], 0.0);
  const auto tables = BuildBandTables(*MakeProfileSource("multipole"), 450.0, config);
  EXPECT_EQ(tables.t1_forward.Total(0.1f), 0.0f);
  EXPECT_GT(tables.t1_forward.Total(20.0f), 0.0f);
}

// A configuration that profiles cannot honour is refused, never ignored.
TEST(BandTables, RefuseWhatTheyCannotHonour) {
  TissueConfig config;
  config.anisotropy = 0.8;
  EXPECT_THROW(BuildBandTables(*MakeProfileSource("multipole"), 450.0, config), InputError);
  config = {};
  config.epidermis_thickness_mm = -1.0;
  EXPECT_THROW(BuildBandTables(*MakeProfileSource("multipole"), 450.0, config), InputError);
}

}  // namespace
}  // namespace dermap
