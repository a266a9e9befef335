// SPDX-License-Identifier: Apache-2.0
// Products with the render's Jacobian and with its transpose.
#include <gtest/gtest.h>

#include <cmath>

#include "common/core/error.h"
#include "common/core/parallel.h"
#include "common/transport/forward_model.h"
#include "tests/common/transport/scenes.h"

namespace dermap {
namespace {

const Band kBands[] = {{450.0, 0.0}, {580.0, 10.0}, {650.0, 0.0}};

struct Case {
  int size;
  Illumination illumination;
  Tape tape;
  Coupling coupling;
  bool tattoo;
  BeneathTape beneath = BeneathTape::kEdge;
};

ForwardModel ModelOf(const Case& c) {
  ImagingConditions conditions = Conditions(c.size, c.illumination);
  conditions.tape = c.tape;
  conditions.geometry = Geometry::kFactor0_30;
  ForwardOptions options;
  options.coupling = c.coupling;
  options.beneath_tape = c.beneath;
  return Model(kBands, conditions, options, "exact");
}

ParameterMaps SceneOf(const Case& c) {
  ParameterMaps maps = FreckledSkin(c.size, 4);
  // Two pixels that stay as they are and beyond which no other goes: path lengths are chosen for a scene's
  // range of absorption, and a difference across such a choice would show that choice, not a derivative.
  for (int k = 0; k < kParameterCount; ++k) {
    if (k == static_cast<int>(Parameter::kBeta_m)) continue;
    maps.planes[k](0, 0) = 0.0f;
    maps.planes[k](1, 0) = static_cast<float>(kParameters[k].upper);
  }
  if (c.tattoo) maps.junction_absorbance = {Noise(c.size, c.size, 9, 0.02f, 1.0f)};
  return maps;
}

// A change of every plane, a share of what parameters are.
ParameterMaps ChangeOf(const ParameterMaps& maps, std::uint32_t seed) {
  ParameterMaps change(maps.width(), maps.height(), ParameterVector{});
  for (int k = 0; k < kParameterCount; ++k) {
    const auto range = static_cast<float>(0.05 * (kParameters[k].upper - kParameters[k].lower));
    change.planes[k] = Noise(maps.width(), maps.height(), seed + k, -range, range);
    change.planes[k](0, 0) = change.planes[k](1, 0) = 0.0f;
  }
  for (std::size_t i = 0; i < maps.junction_absorbance.size(); ++i)
    change.junction_absorbance.push_back(Noise(maps.width(), maps.height(), seed + 7, -0.1f, 0.1f));
  return change;
}

double Dot(const PlaneF& a, const PlaneF& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += double(a.data()[i]) * b.data()[i];
  return sum;
}

ParameterMaps Moved(const ParameterMaps& maps, const ParameterMaps& change, double step) {
  ParameterMaps moved = maps;
  const auto move = [&](PlaneF& plane, const PlaneF& by) {
    for (std::size_t i = 0; i < plane.size(); ++i) plane.data()[i] += static_cast<float>(step * by.data()[i]);
  };
  for (int k = 0; k < kParameterCount; ++k) move(moved.planes[k], change.planes[k]);
  for (std::size_t i = 0; i < maps.junction_absorbance.size(); ++i)
    move(moved.junction_absorbance[i], change.junction_absorbance[i]);
  return moved;
}

class Derivatives : public testing::TestWithParam<Case> {};

// Source: the definition of a transpose, <J v, w> = <v, J' w>, to rounding.
TEST_P(Derivatives, TransposeIsTheTranspose) {
  const ForwardModel model = ModelOf(GetParam());
  const ParameterMaps maps = SceneOf(GetParam()), change = ChangeOf(maps, 20);
  std::vector<PlaneF> weights;
  for (int b = 0; b < 3; ++b) weights.push_back(Noise(maps.width(), maps.height(), 40 + b, -1.0f, 1.0f));
  const std::vector<PlaneF> forward = model.Tangent(maps, change);
  const ParameterMaps backward =
      model.Transpose(maps, [&](int band, const PlaneF&) { return weights[band]; });
  double left = 0.0, right = 0.0, scale = 0.0;
  for (int b = 0; b < 3; ++b) {
    left += Dot(forward[b], weights[b]);
    scale += std::sqrt(Dot(forward[b], forward[b]) * Dot(weights[b], weights[b]));
  }
  for (int k = 0; k < kParameterCount; ++k) right += Dot(backward.planes[k], change.planes[k]);
  for (std::size_t i = 0; i < backward.junction_absorbance.size(); ++i)
    right += Dot(backward.junction_absorbance[i], change.junction_absorbance[i]);
  EXPECT_NEAR(left, right, 1e-5 * scale);
  const ForwardModel::Kept kept(model, maps);
  kept.Tangent(ChangeOf(maps, 30));
  const std::vector<PlaneF> again = kept.Tangent(change);  // whatever was asked before
  for (int b = 0; b < 3; ++b)
    for (std::size_t i = 0; i < again[b].size(); ++i)
      ASSERT_EQ(again[b].data()[i], forward[b].data()[i]) << b << ' ' << i;
}

// Source: central differences of the render, Richardson's extrapolation of two steps. Single
// precision rounds each pixel of a render, so a pixel's difference is good to some 1e-5 of its value over the
// step; the mean over all pixels, where rounding averages out and an error of a derivative would not, to
// 2e-5.
TEST_P(Derivatives, ProductIsTheLimitOfDifferences) {
  const ForwardModel model = ModelOf(GetParam());
  const ParameterMaps maps = SceneOf(GetParam());
  ParameterMaps change = ChangeOf(maps, 20);
  for (PlaneF& plane : change.planes)  // all one way, so that the mean is no difference of large numbers
    for (float& value : plane.values()) value = std::abs(value);
  for (PlaneF& plane : change.junction_absorbance)
    for (float& value : plane.values()) value = std::abs(value);
  const std::vector<PlaneF> product = model.Tangent(maps, change);
  std::vector<std::vector<PlaneF>> renders;
  const double step = 0.1;
  for (const double share : {-2.0, -1.0, 1.0, 2.0})
    renders.push_back(model.Render(Moved(maps, change, share * step)));
  for (int b = 0; b < 3; ++b) {
    double square = 0.0, difference_square = 0.0, sum = 0.0, difference_sum = 0.0;
    for (std::size_t i = 0; i < product[b].size(); ++i) {
      const auto at = [&](int r) { return double(renders[r][b].data()[i]); };
      const double expected = (8.0 * (at(2) - at(1)) - (at(3) - at(0))) / (12.0 * step);
      square += expected * expected;
      sum += expected;
      difference_square += std::pow(product[b].data()[i] - expected, 2);
      difference_sum += product[b].data()[i] - expected;
    }
    EXPECT_LT(std::sqrt(difference_square / square), 3e-4) << b;
    EXPECT_LT(std::abs(difference_sum / sum), 2e-5) << b;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, Derivatives,
    testing::Values(
        Case{128, Illumination::kWindow, Tape::kFree, Coupling::kReciprocal, false},
        Case{128, Illumination::kUniform, Tape::kFree, Coupling::kReciprocal, true},
        Case{100, Illumination::kWindow, Tape::kBlack, Coupling::kReciprocal, true},
        Case{90, Illumination::kWindow, Tape::kBlack, Coupling::kGather, false},
        Case{90, Illumination::kWindow, Tape::kFree, Coupling::kReciprocal, true, BeneathTape::kMean},
        Case{64, Illumination::kWindow, Tape::kFree, Coupling::kReciprocal, false, BeneathTape::kMirrored}));

// Results do not depend on how many threads share the work.
TEST(DerivativesOfARender, AreTheSameForAnyNumberOfThreads) {
  const Case c{64, Illumination::kWindow, Tape::kFree, Coupling::kReciprocal, false};
  const ForwardModel model = ModelOf(c);
  const ParameterMaps maps = SceneOf(c);
  const auto weigh = [&](int, const PlaneF& reflectance) { return reflectance; };
  const ThreadLimit one(1);
  const ParameterMaps alone = model.Transpose(maps, weigh);
  const ThreadLimit many(3);
  const ParameterMaps shared = model.Transpose(maps, weigh);
  for (int k = 0; k < kParameterCount; ++k)
    for (std::size_t i = 0; i < alone.planes[k].size(); ++i)
      ASSERT_EQ(alone.planes[k].data()[i], shared.planes[k].data()[i]);
}

}  // namespace
}  // namespace dermap
