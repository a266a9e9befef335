// SPDX-License-Identifier: Apache-2.0
// A kernel's transform at any lateral frequency.
#pragma once

#include <span>
#include <vector>

namespace dermap {

// Sampled finely enough for linear interpolation.
class RadialTransform {
 public:
  RadialTransform() = default;
  // Values at TableFrequencies_per_mm(); beyond the last they fall as 1 / k.
  RadialTransform(std::span<const float> values);  // NOLINT(google-explicit-constructor): a view of the same
  RadialTransform(const std::vector<float>& values) : RadialTransform(std::span(values)) {}  // NOLINT
  // Where a frequency lies among the samples: the same in every transform.
  struct Position {
    int index;
    float fraction;
  };
  static Position PositionOf(double k_per_mm) noexcept;
  float At(Position at) const noexcept {
    return samples_[at.index] + at.fraction * (samples_[at.index + 1] - samples_[at.index]);
  }

 private:
  std::vector<float> samples_;
};

}  // namespace dermap
