// SPDX-License-Identifier: Apache-2.0
// What the tests of derivatives share.
#include "tests/common/transport/derivative_cases.h"

#include <cmath>

#include "tests/common/transport/scenes.h"

namespace dermap {

ForwardModel ModelOf(const DerivativeCase& c, std::span<const Band> bands, const char* source) {
  ImagingConditions conditions = Conditions(c.size, c.illumination);
  conditions.tape = c.tape;
  conditions.geometry = Geometry::kFactor0_30;
  ForwardOptions options;
  options.coupling = c.coupling;
  options.beneath_tape = c.beneath;
  options.engine = c.engine;
  return Model(bands, conditions, options, source);
}

ParameterMaps SceneOf(const DerivativeCase& c) {
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

double Dot(const PlaneF& a, const PlaneF& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += double(a.data()[i]) * b.data()[i];
  return sum;
}

double TransposeError(const ForwardModel& model, const ParameterMaps& maps, const ParameterMaps& change) {
  std::vector<PlaneF> weights;
  for (int b = 0; b < model.band_count(); ++b)
    weights.push_back(Noise(maps.width(), maps.height(), 40 + b, -1.0f, 1.0f));
  const std::vector<PlaneF> forward = model.Tangent(maps, change);
  const ParameterMaps backward =
      model.Transpose(maps, [&](int band, const PlaneF&) { return weights[band]; });
  double left = 0.0, right = 0.0, scale = 0.0;
  for (int b = 0; b < model.band_count(); ++b) {
    left += Dot(forward[b], weights[b]);
    scale += std::sqrt(Dot(forward[b], forward[b]) * Dot(weights[b], weights[b]));
  }
  for (int k = 0; k < kParameterCount; ++k) right += Dot(backward.planes[k], change.planes[k]);
  for (std::size_t i = 0; i < backward.junction_absorbance.size(); ++i)
    right += Dot(backward.junction_absorbance[i], change.junction_absorbance[i]);
  return std::abs(left - right) / scale;
}

std::vector<DifferenceError> ErrorsAgainstDifferences(const ForwardModel& model, const ParameterMaps& maps,
                                                      const ParameterMaps& change, double step) {
  const std::vector<PlaneF> product = model.Tangent(maps, change);
  std::vector<std::vector<PlaneF>> renders;
  for (const double share : {-2.0, -1.0, 1.0, 2.0})
    renders.push_back(model.Render(Moved(maps, change, share * step)));
  std::vector<DifferenceError> errors;
  for (std::size_t b = 0; b < product.size(); ++b) {
    double square = 0.0, difference_square = 0.0, sum = 0.0, difference_sum = 0.0;
    for (std::size_t i = 0; i < product[b].size(); ++i) {
      const auto at = [&](int r) { return double(renders[r][b].data()[i]); };
      const double expected = (8.0 * (at(2) - at(1)) - (at(3) - at(0))) / (12.0 * step);
      square += expected * expected;
      sum += expected;
      difference_square += std::pow(product[b].data()[i] - expected, 2);
      difference_sum += product[b].data()[i] - expected;
    }
    errors.push_back({std::sqrt(difference_square / square), std::abs(difference_sum / sum)});
  }
  return errors;
}

}  // namespace dermap
