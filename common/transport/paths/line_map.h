// SPDX-License-Identifier: Apache-2.0
// Linear maps between the lines (and planes) of a grid and of one twice as coarse, with their exact
// transposes.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "common/core/image.h"

namespace dermap {

// What a line is beyond its ends; its mean only for Shift.
enum class LineEnd { kZero, kReplicate, kMirror, kMean };

// How every second sample is taken of a low-passed line.
enum class Halver {
  kSmooth,  // binomial, 8 taps: folds next to nothing, but takes off middle frequencies, which must be given
            // back
  kFlat,    // Keys's cubic at half its rate (R. Keys, IEEE Trans. ASSP 29, 1981): keeps them, folds more
};

// A sparse matrix: output i is the sum of weight * input over its taps.
class LineMap {
 public:
  struct Tap {
    int input;
    float weight;
  };
  // Where the taps of neighbouring outputs differ by a shift only, so that a loop can do them.
  struct Regular {
    int first = 0, count = 0;  // outputs; doubling: pairs of outputs
    int input = 0;             // first input of the first
  };

  LineMap() = default;
  // Output i lies in the middle between inputs 2 i + first and 2 i + first + 1.
  static LineMap Halving(Halver halver, int inputs, int outputs, int first, LineEnd end);
  // Output i is input i + first.
  static LineMap Shift(int inputs, int outputs, int first, LineEnd end);
  // Gain of a halving for a wave of `omega` radians per input.
  static double Gain(Halver halver, double omega);

  LineMap Transposed() const;
  LineMap Scaled(float factor) const;

  int inputs() const { return inputs_; }
  int outputs() const { return static_cast<int>(start_.size()) - 1; }
  void Apply(const float* in, float* out) const;          // a line of contiguous samples
  void ApplyToRows(const PlaneF& in, PlaneF& out) const;  // every column at once

 private:
  LineMap(int inputs, const std::vector<std::vector<Tap>>& rows);
  void FindRegular();
  bool IsRegular(int output, int input, std::span<const float> weights) const;
  void ApplyTaps(int first, int last, const float* in, float* out) const;

  int inputs_ = 0;
  std::vector<int> start_{0};
  std::vector<Tap> taps_;
  Regular halving_, doubling_;
  std::array<float, 4> half_{};  // weights of the regular taps, the middle one first
};

// The same along both axes of a plane. One a thread: it keeps its scratch.
class PlaneMap {
 public:
  PlaneMap() = default;
  PlaneMap(LineMap along_x, LineMap along_y) : x_(std::move(along_x)), y_(std::move(along_y)) {}
  PlaneMap Transposed() const { return {x_.Transposed(), y_.Transposed()}; }
  PlaneMap Scaled(float factor) const { return {x_.Scaled(factor), y_.Scaled(factor)}; }  // factor^2 in all
  int width() const { return x_.outputs(); }  // of what Apply gives
  int height() const { return y_.outputs(); }
  void Apply(const PlaneF& in, PlaneF& out);

 private:
  LineMap x_, y_;
  PlaneF rows_done_;
};

}  // namespace dermap
