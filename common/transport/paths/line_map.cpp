// SPDX-License-Identifier: Apache-2.0
// Sparse lines; their regular inner parts as loops.
#include "common/transport/paths/line_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "common/core/kernel.h"
#include "common/transport/blur.h"
#include "common/transport/domain.h"

namespace dermap {
namespace {

// One half of the taps, the middle one first.
constexpr std::array<float, 4> kBinomial = {35.0f / 128, 21.0f / 128, 7.0f / 128, 1.0f / 128};
// a = -1/2, at distances 1/4, 3/4, 5/4 and 7/4 of a coarse sample, halved
constexpr std::array<float, 4> kKeys = {0.43359375f, 0.11328125f, -0.03515625f, -0.01171875f};

const std::array<float, 4>& HalfOf(Halver halver) {
  return halver == Halver::kSmooth ? kBinomial : kKeys;
}

DERMAP_KERNEL
void HalveLine(const float* in, int n, const float* half, float* __restrict out) noexcept {
  const float h0 = half[0], h1 = half[1], h2 = half[2], h3 = half[3];
  for (int i = 0; i < n; ++i) {
    const float* p = in + 2 * i;
    out[i] = h0 * (p[3] + p[4]) + h1 * (p[2] + p[5]) + h2 * (p[1] + p[6]) + h3 * (p[0] + p[7]);
  }
}

// Outputs 2 i and 2 i + 1 lie a quarter to the left and to the right of in[i + 1] and in[i + 2]'s middle.
DERMAP_KERNEL
void DoubleLine(const float* in, int pairs, const float* half, float* __restrict out) noexcept {
  const float h0 = half[0], h1 = half[1], h2 = half[2], h3 = half[3];
  for (int i = 0; i < pairs; ++i) {
    const float a = in[i], b = in[i + 1], c = in[i + 2], d = in[i + 3];
    out[2 * i] = h2 * a + h0 * b + h1 * c + h3 * d;
    out[2 * i + 1] = h3 * a + h1 * b + h0 * c + h2 * d;
  }
}

// Nearly all outputs have four or eight taps.
DERMAP_KERNEL
void SumFour(const float* a, const float* b, const float* c, const float* d, const float* w, bool first,
             int n, float* __restrict out) noexcept {
  if (first) {
    for (int x = 0; x < n; ++x) out[x] = w[0] * a[x] + w[1] * b[x] + w[2] * c[x] + w[3] * d[x];
  } else {
    for (int x = 0; x < n; ++x) out[x] += w[0] * a[x] + w[1] * b[x] + w[2] * c[x] + w[3] * d[x];
  }
}

int Inside(int i, int n, LineEnd end) {
  if (i >= 0 && i < n) return i;
  switch (end) {
    case LineEnd::kZero:
    case LineEnd::kMean:
      return -1;
    case LineEnd::kReplicate:
      return std::clamp(i, 0, n - 1);
    case LineEnd::kMirror:
      return MirroredIndex(i, n);
  }
  return -1;
}

void AddTap(std::vector<LineMap::Tap>& row, int input, float weight) {
  const auto same = std::find_if(row.begin(), row.end(), [&](const auto& tap) { return tap.input == input; });
  if (same != row.end()) {
    same->weight += weight;
  } else {
    row.push_back({input, weight});
  }
}

}  // namespace

LineMap::LineMap(int inputs, const std::vector<std::vector<Tap>>& rows) : inputs_(inputs) {
  for (std::vector<Tap> row : rows) {
    std::sort(row.begin(), row.end(), [](const Tap& a, const Tap& b) { return a.input < b.input; });
    taps_.insert(taps_.end(), row.begin(), row.end());
    start_.push_back(static_cast<int>(taps_.size()));
  }
  FindRegular();
}

LineMap LineMap::Halving(Halver halver, int inputs, int outputs, int first, LineEnd end) {
  const std::array<float, 4>& half = HalfOf(halver);
  std::vector<std::vector<Tap>> rows(outputs);
  for (int i = 0; i < outputs; ++i) {
    for (int t = 0; t < 8; ++t) {
      const int input = Inside(2 * i + first + t - 3, inputs, end);
      if (input >= 0) AddTap(rows[i], input, half[t < 4 ? 3 - t : t - 4]);
    }
  }
  return {inputs, rows};
}

LineMap LineMap::Shift(int inputs, int outputs, int first, LineEnd end) {
  std::vector<std::vector<Tap>> rows(outputs);
  for (int i = 0; i < outputs; ++i) {
    const int input = Inside(i + first, inputs, end);
    if (input >= 0)
      rows[i].push_back({input, 1.0f});
    else if (end == LineEnd::kMean)
      for (int k = 0; k < inputs; ++k) rows[i].push_back({k, 1.0f / static_cast<float>(inputs)});
  }
  return {inputs, rows};
}

double LineMap::Gain(Halver halver, double omega) {
  double gain = 0.0;
  for (int t = 0; t < 4; ++t) gain += 2.0 * HalfOf(halver)[t] * std::cos(omega * (t + 0.5));
  return gain;
}

LineMap LineMap::Transposed() const {
  std::vector<std::vector<Tap>> rows(inputs_);
  for (int i = 0; i < outputs(); ++i)
    for (int t = start_[i]; t < start_[i + 1]; ++t) rows[taps_[t].input].push_back({i, taps_[t].weight});
  LineMap transposed(outputs(), rows);
  return transposed;
}

LineMap LineMap::Scaled(float factor) const {
  LineMap scaled = *this;
  for (Tap& tap : scaled.taps_) tap.weight *= factor;
  scaled.FindRegular();
  return scaled;
}

bool LineMap::IsRegular(int output, int input, std::span<const float> weights) const {
  if (start_[output + 1] - start_[output] != static_cast<int>(weights.size())) return false;
  for (std::size_t t = 0; t < weights.size(); ++t) {
    const Tap& tap = taps_[start_[output] + t];
    if (tap.input != input + static_cast<int>(t) || std::abs(tap.weight - weights[t]) > 1e-6f) return false;
  }
  return true;
}

// The longest run of outputs, from the first on that is regular, that a halving or a doubling would give.
void LineMap::FindRegular() {
  halving_ = doubling_ = {};
  const int middle = outputs() / 2 / 2 * 2;
  const int taps = start_[middle + 1] - start_[middle];
  if (taps != 8 && taps != 4) return;
  const Tap* tap = taps_.data() + start_[middle];
  const auto& h = half_;
  if (taps == 8) {
    half_ = {tap[4].weight, tap[5].weight, tap[6].weight, tap[7].weight};
    const std::array<float, 8> all = {h[3], h[2], h[1], h[0], h[0], h[1], h[2], h[3]};
    Regular& run = halving_;
    for (int i = 0; i < outputs(); ++i) {
      const int input = start_[i] < start_[i + 1] ? taps_[start_[i]].input : 0;
      const bool regular = IsRegular(i, input, all);
      if (!regular && run.count > 0) break;
      if (!regular) continue;
      if (run.count == 0) run = {i, 0, input};
      if (input != run.input + 2 * run.count) break;
      ++run.count;
    }
    return;
  }
  // Which of a pair is first follows from where the largest weight is.
  for (int first = 0; first < 2; ++first) {
    const Tap* even = taps_.data() + start_[middle + first];
    if (start_[middle + first + 1] - start_[middle + first] != 4 || even[1].weight < even[2].weight) continue;
    half_ = {even[1].weight, even[2].weight, even[0].weight, even[3].weight};
    const std::array<float, 4> left = {h[2], h[0], h[1], h[3]}, right = {h[3], h[1], h[0], h[2]};
    Regular& run = doubling_;
    for (int i = first; i + 1 < outputs(); i += 2) {
      const int input = start_[i] < start_[i + 1] ? taps_[start_[i]].input : 0;
      const bool regular = IsRegular(i, input, left) && IsRegular(i + 1, input, right);
      if (!regular && run.count > 0) break;
      if (!regular) continue;
      if (run.count == 0) run = {i, 0, input};
      if (input != run.input + run.count) break;
      ++run.count;
    }
  }
}

void LineMap::ApplyTaps(int first, int last, const float* in, float* out) const {
  for (int i = first; i < last; ++i) {
    float sum = 0.0f;
    for (int t = start_[i]; t < start_[i + 1]; ++t) sum += taps_[t].weight * in[taps_[t].input];
    out[i] = sum;
  }
}

void LineMap::Apply(const float* in, float* out) const {
  int first = outputs(), last = outputs();
  if (halving_.count > 0) {
    first = halving_.first, last = first + halving_.count;
    HalveLine(in + halving_.input, halving_.count, half_.data(), out + first);
  } else if (doubling_.count > 0) {
    first = doubling_.first, last = first + 2 * doubling_.count;
    DoubleLine(in + doubling_.input, doubling_.count, half_.data(), out + first);
  }
  ApplyTaps(0, first, in, out);
  ApplyTaps(last, outputs(), in, out);
}

void LineMap::ApplyToRows(const PlaneF& in, PlaneF& out) const {
  assert(in.height() == inputs_);
  const int width = in.width();
  EnsureShape(out, width, outputs());
  for (int i = 0; i < outputs(); ++i) {
    const Tap* tap = taps_.data() + start_[i];
    const int count = start_[i + 1] - start_[i];
    int done = 0;
    for (; done + 4 <= count; done += 4) {
      const float w[] = {tap[done].weight, tap[done + 1].weight, tap[done + 2].weight, tap[done + 3].weight};
      SumFour(in.Row(tap[done].input), in.Row(tap[done + 1].input), in.Row(tap[done + 2].input),
              in.Row(tap[done + 3].input), w, done == 0, width, out.Row(i));
    }
    if (done == 0) std::fill_n(out.Row(i), width, 0.0f);
    for (; done < count; ++done) {
      const float w = tap[done].weight;
      const float* row = in.Row(tap[done].input);
      std::transform(row, row + width, out.Row(i), out.Row(i), [w](float r, float o) { return o + w * r; });
    }
  }
}

void PlaneMap::Apply(const PlaneF& in, PlaneF& out) {
  assert(in.width() == x_.inputs());
  y_.ApplyToRows(in, rows_done_);
  EnsureShape(out, x_.outputs(), y_.outputs());
  for (int y = 0; y < out.height(); ++y) x_.Apply(rows_done_.Row(y), out.Row(y));
}

}  // namespace dermap
