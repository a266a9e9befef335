// SPDX-License-Identifier: Apache-2.0
// Separable convolution: rows through a padded copy, columns by summing whole rows, so both run along x.
#include "common/transport/blur.h"

#include <algorithm>

#include "common/core/kernel.h"

namespace dermap {
namespace {

constexpr int kPairsAtOnce = 4;

// out += four pairs of rows. Plain loops along x, which the compiler vectorises for each instruction set;
// four pairs at once because then out's own load and store hardly count beside the pairs' loads, which are
// the bound.
DERMAP_KERNEL
void AddFourPairs(const float* const* before, const float* const* after, const float* taps, int n,
                  float* __restrict out) noexcept {
  const float *a0 = before[0], *a1 = before[1], *a2 = before[2], *a3 = before[3];
  const float *b0 = after[0], *b1 = after[1], *b2 = after[2], *b3 = after[3];
  const float t0 = taps[0], t1 = taps[1], t2 = taps[2], t3 = taps[3];
  for (int x = 0; x < n; ++x) {
    out[x] += (t0 * (a0[x] + b0[x]) + t1 * (a1[x] + b1[x])) + (t2 * (a2[x] + b2[x]) + t3 * (a3[x] + b3[x]));
  }
}

DERMAP_KERNEL
void AddPair(const float* before, const float* after, float tap, int n, float* __restrict out) noexcept {
  for (int x = 0; x < n; ++x) out[x] += tap * (before[x] + after[x]);
}

DERMAP_KERNEL
void Scale(const float* in, float factor, int n, float* __restrict out) noexcept {
  for (int x = 0; x < n; ++x) out[x] = factor * in[x];
}

}  // namespace

void SumPairs(const float* middle, const float* const* before, const float* const* after, const float* taps,
              int radius, int n, float* out) noexcept {
  Scale(middle, taps[0], n, out);
  int k = 0;
  for (; k + kPairsAtOnce <= radius; k += kPairsAtOnce)
    AddFourPairs(before + k, after + k, taps + 1 + k, n, out);
  for (; k < radius; ++k) AddPair(before[k], after[k], taps[1 + k], n, out);
}

int MirroredIndex(int i, int n) noexcept {
  const int period = 2 * n;
  int folded = i % period;
  if (folded < 0) folded += period;
  return folded < n ? folded : period - 1 - folded;
}

void SeparableBlur::Apply(const PlaneF& in, const SymmetricKernel& kernel, PlaneF& out) {
  if (in.empty()) return;
  Rows(in, kernel);
  if (!out.SameShape(in)) out = PlaneF(in.width(), in.height());
  Columns(kernel, out);
}

void SeparableBlur::Rows(const PlaneF& in, const SymmetricKernel& kernel) {
  const int n = in.width();
  int radius = static_cast<int>(kernel.size()) - 1;
  if (border_ == Border::kZero) radius = std::min(radius, n - 1);
  if (!rows_done_.SameShape(in)) rows_done_ = PlaneF(n, in.height());
  padded_row_.assign(static_cast<std::size_t>(n) + 2 * radius, 0.0f);
  before_.resize(radius);
  after_.resize(radius);
  float* middle = padded_row_.data() + radius;
  for (int k = 0; k < radius; ++k) {
    before_[k] = middle - (k + 1);
    after_[k] = middle + (k + 1);
  }
  for (int y = 0; y < in.height(); ++y) {
    const float* row = in.Row(y);
    std::copy(row, row + n, middle);
    if (border_ == Border::kMirror) {
      for (int k = 1; k <= radius; ++k) {
        middle[-k] = row[MirroredIndex(-k, n)];
        middle[n - 1 + k] = row[MirroredIndex(n - 1 + k, n)];
      }
    }
    SumPairs(middle, before_.data(), after_.data(), kernel.data(), radius, n, rows_done_.Row(y));
  }
}

void SeparableBlur::Columns(const SymmetricKernel& kernel, PlaneF& out) {
  const int n = out.height();
  int radius = static_cast<int>(kernel.size()) - 1;
  if (border_ == Border::kZero) radius = std::min(radius, n - 1);
  before_.resize(radius);
  after_.resize(radius);
  zero_row_.assign(out.width(), 0.0f);
  const auto row = [&](int y) -> const float* {
    if (y >= 0 && y < n) return rows_done_.Row(y);
    return border_ == Border::kZero ? zero_row_.data() : rows_done_.Row(MirroredIndex(y, n));
  };
  for (int y = 0; y < n; ++y) {
    for (int k = 0; k < radius; ++k) {
      before_[k] = row(y - 1 - k);
      after_[k] = row(y + 1 + k);
    }
    SumPairs(rows_done_.Row(y), before_.data(), after_.data(), kernel.data(), radius, out.width(),
             out.Row(y));
  }
}

}  // namespace dermap
