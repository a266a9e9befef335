// SPDX-License-Identifier: Apache-2.0
// Both engines' heterogeneous convolution against dense sums, against modulated light, and against each
// other.
#include "common/transport/convolver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/common/transport/scenes.h"

namespace dermap {
namespace {

constexpr Engine kEngines[] = {Engine::kCascade, Engine::kPyramid};

PlaneF Convolve(Engine engine, const ProfileTable& table, const PlaneF& mu_a, const PlaneF& input,
                const Domain& domain, double pixel_size_mm, Border border) {
  TablePositions positions;
  positions.Set(mu_a, domain);
  ResponseWeights weights;
  weights.Set(table, positions, domain.Whole());
  PlaneF out;
  const ConvolutionTarget target{&weights, &out};
  MakeConvolver(engine, domain, pixel_size_mm, border)->Convolve(input, {&target, 1});
  return out;
}

// Absorption with soft-edged spots, from light to dark, 1/mm.
PlaneF SpottedAbsorption(int size) {
  const ParameterMaps maps = FreckledSkin(size, 11);
  PlaneF mu_a(size, size);
  for (std::size_t i = 0; i < mu_a.size(); ++i)
    mu_a.data()[i] = 0.2f + 30.0f * maps[Parameter::kC_m].data()[i];
  return mu_a;
}

// The sum of [D08 eq. 9] as it stands: for every pixel its own weights, for every Gaussian every other pixel,
// with continuous Gaussians. Pixels of 0.01 mm, where even the narrowest (0.01 mm) may be sampled; zeros
// around. The cascade loses what one blur carries over the border and the next would carry back, so only the
// middle is compared.
TEST(Convolver, IsTheDenseSumOfContinuousGaussians) {
  const int size = 40, margin = 60;
  const double pixel_size_mm = 0.01;
  const ProfileTable& table = TestTables(560).r1_forward;
  const PlaneF mu_a = SpottedAbsorption(size);
  const PlaneF patch = Noise(size, size, 5, 0.0f, 1.0f);
  const Domain domain = MakeDomain(size, size, margin);
  PlaneF input;
  SurroundWithZeros(patch, domain, input);
  PlaneF dense(size, size);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      GaussianWeights weights;
      table.Weights(mu_a(x, y), weights);
      double sum = 0.0;
      for (int i = 0; i < kGaussianCount; ++i) {
        if (weights[i] <= 0.0f) continue;
        const double v = 0.0001 * std::exp2(i);  // mm^2 [D08 7]
        double blurred = 0.0;
        for (int yy = 0; yy < size; ++yy) {
          for (int xx = 0; xx < size; ++xx) {
            const double r2 = (std::pow(xx - x, 2) + std::pow(yy - y, 2)) * pixel_size_mm * pixel_size_mm;
            blurred += patch(xx, yy) * std::exp(-0.5 * r2 / v);
          }
        }
        sum += weights[i] * blurred * pixel_size_mm * pixel_size_mm / (2.0 * std::numbers::pi * v);
      }
      dense(x, y) = static_cast<float>(sum);
    }
  }
  for (const Engine engine : kEngines) {
    const PlaneF whole = Convolve(engine, table, mu_a, input, domain, pixel_size_mm, Border::kZero);
    PlaneF found(size, size);
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) found(x, y) = whole(x + domain.patch.x, y + domain.patch.y);
    }
    const Difference difference = Compare(found, dense);
    EXPECT_LT(difference.relative_rms, 1e-3) << EngineName(engine);
    EXPECT_LT(difference.relative_max, 3e-3) << EngineName(engine);
  }
}

// A cosine that a mirrored border continues is an eigenfunction of every Gaussian: the transform exp(-v k^2 /
// 2), summed with the weights, times the cosine. No grid, no kernel, no truncation in the expected number.
TEST(Convolver, DampsModulatedLightByTheTransform) {
  const int size = 192;
  const double pixel_size_mm = 7.5 / 256;
  const ProfileTable& table = TestTables(560).r2_diffuse;
  const float mu_a = 0.3f;
  const Domain domain = MakeDomain(size, size, 0.0);
  ASSERT_EQ(domain.width, size);
  GaussianWeights weights;
  table.Weights(mu_a, weights);
  for (const int periods : {1, 4, 10, 24}) {
    const double k_per_px = std::numbers::pi * periods / size, k_per_mm = k_per_px / pixel_size_mm;
    PlaneF input(size, size);
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) input(x, y) = static_cast<float>(std::cos(k_per_px * (x + 0.5)));
    }
    double transform = 0.0, total = 0.0;
    for (int i = 0; i < kGaussianCount; ++i) {
      transform += weights[i] * std::exp(-0.5 * 0.0001 * std::exp2(i) * k_per_mm * k_per_mm);
      total += weights[i];
    }
    for (const Engine engine : kEngines) {
      const PlaneF out =
          Convolve(engine, table, PlaneF(size, size, mu_a), input, domain, pixel_size_mm, Border::kMirror);
      double worst = 0.0;
      for (std::size_t i = 0; i < out.size(); ++i) {
        worst = std::max(worst, std::abs(out.data()[i] - transform * input.data()[i]));
      }
      EXPECT_LT(worst / total, 5e-4) << EngineName(engine) << ", " << k_per_mm << "/mm, transform "
                                     << transform;
    }
  }
}

// The cascade is the judge; 1e-3 rms is the error that the pyramid may make. Spots with edges of two pixels,
// light that ends at a sharp border or changes from pixel to pixel, every response, both borders.
TEST(Convolver, PyramidIsTheCascade) {
  const BandTables& tables = TestTables(610);
  for (const int size : {256, 64}) {
    const double pixel_size_mm = 7.5 / size;
    const PlaneF mu_a = SpottedAbsorption(size);
    const Domain domain = MakeDomain(size, size, 1.9 / pixel_size_mm);
    const PlaneF patch = Noise(size, size, 3, 0.5f, 1.5f);
    for (const Border border : {Border::kZero, Border::kMirror}) {
      PlaneF input;
      border == Border::kZero ? SurroundWithZeros(patch, domain, input)
                              : ReplicateOutwards(patch, domain, input);
      for (const ProfileTable* table : {&tables.r1_forward, &tables.r2_diffuse, &tables.t1_backward}) {
        const PlaneF slow = Convolve(Engine::kCascade, *table, mu_a, input, domain, pixel_size_mm, border);
        const PlaneF fast = Convolve(Engine::kPyramid, *table, mu_a, input, domain, pixel_size_mm, border);
        const Difference difference = Compare(fast, slow);
        EXPECT_LT(difference.relative_rms, 1e-3) << size << " pixels, mirror " << (border == Border::kMirror);
        EXPECT_LT(difference.relative_max, 5e-3) << size << " pixels, mirror " << (border == Border::kMirror);
      }
    }
  }
}

// Pixels far finer and far coarser than any Gaussian, where levels are many or none, and shapes that are not
// square.
TEST(Convolver, PyramidIsTheCascadeAtExtremePixelSizes) {
  const ProfileTable& table = TestTables(610).r2_diffuse;
  for (const double pixel_size_mm : {0.002, 0.3, 2.0}) {
    const Domain domain = MakeDomain(120, 56, 8.0);
    const PlaneF mu_a = Noise(120, 56, 9, 0.1f, 2.0f);
    PlaneF input;
    ReplicateOutwards(Noise(120, 56, 3, 0.5f, 1.5f), domain, input);
    const PlaneF slow =
        Convolve(Engine::kCascade, table, mu_a, input, domain, pixel_size_mm, Border::kMirror);
    const PlaneF fast =
        Convolve(Engine::kPyramid, table, mu_a, input, domain, pixel_size_mm, Border::kMirror);
    EXPECT_LT(Compare(fast, slow).relative_rms, 1e-3) << pixel_size_mm << " mm";
  }
}

// Source: the definition of a transpose, <w, C f> = <C' w, f>; sums in double of products in single
// precision.
TEST(Convolver, TransposedIsTheTranspose) {
  const BandTables& tables = TestTables(610);
  for (const int size : {48, 130}) {
    const PlaneF mu_a = SpottedAbsorption(size);
    const double pixel_size_mm = 7.5 / size;
    const Domain domain = MakeDomain(size, size, 1.0 / pixel_size_mm);
    const PlaneF f = Noise(domain.width, domain.height, 3, -1.0f, 1.0f);
    TablePositions positions;
    positions.Set(mu_a, domain);
    for (const Engine engine : kEngines) {
      for (const Border border : {Border::kZero, Border::kMirror}) {
        const auto convolver = MakeConvolver(engine, domain, pixel_size_mm, border);
        for (const Region& region : {domain.patch, domain.Whole()}) {
          ResponseWeights weights;
          weights.Set(tables.r2_diffuse, positions, region);
          const PlaneF w = Noise(region.width, region.height, 5, -1.0f, 1.0f);
          PlaneF forward, backward;
          const ConvolutionTarget target{&weights, &forward};
          convolver->Convolve(f, {&target, 1});
          convolver->ConvolveTransposed(w, weights, backward);
          double left = 0.0, right = 0.0, a = 0.0, b = 0.0;
          for (std::size_t i = 0; i < w.size(); ++i) {
            left += double(w.data()[i]) * forward.data()[i];
            a += std::pow(w.data()[i], 2), b += std::pow(forward.data()[i], 2);
          }
          for (std::size_t i = 0; i < f.size(); ++i) right += double(backward.data()[i]) * f.data()[i];
          EXPECT_NEAR(left, right, 1e-6 * std::sqrt(a * b))
              << EngineName(engine) << ", " << size << " pixels, mirror " << (border == Border::kMirror);
        }
      }
    }
  }
}

// Targets share blurs, not results: each comes out as it would alone, whatever its region.
TEST(Convolver, TargetsDoNotDisturbEachOther) {
  const BandTables& tables = TestTables(560);
  const PlaneF mu_a = SpottedAbsorption(64);
  const Domain domain = MakeDomain(64, 64, 16.0);
  PlaneF input;
  SurroundWithZeros(Noise(64, 64, 4, 0.0f, 1.0f), domain, input);
  TablePositions positions;
  positions.Set(mu_a, domain);
  ResponseWeights first, second;
  first.Set(tables.r1_forward, positions, domain.patch);
  second.Set(tables.t1_forward, positions, domain.Whole());
  for (const Engine engine : kEngines) {
    const auto convolver = MakeConvolver(engine, domain, 7.5 / 64, Border::kZero);
    PlaneF together[2], alone[2];
    const ConvolutionTarget both[] = {{&first, &together[0]}, {&second, &together[1]}};
    const ConvolutionTarget one{&first, &alone[0]}, other{&second, &alone[1]};
    convolver->Convolve(input, both);
    convolver->Convolve(input, {&one, 1});
    convolver->Convolve(input, {&other, 1});
    for (int i = 0; i < 2; ++i) {
      ASSERT_TRUE(together[i].SameShape(alone[i]));
      // A Gaussian that only the other target needs may split one blur into two.
      EXPECT_LT(Compare(together[i], alone[i]).relative_max, 1e-4) << EngineName(engine);
    }
  }
}

}  // namespace
}  // namespace dermap
