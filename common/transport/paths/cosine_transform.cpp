// SPDX-License-Identifier: Apache-2.0
// Cosine transforms by matrix products.
#include "common/transport/paths/cosine_transform.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "common/core/kernel.h"
#include "common/core/lanes.h"
#include "common/transport/domain.h"

namespace dermap {
namespace {

constexpr int kLargestByProduct = 192;  // beyond it a fast transform is faster
// Of a product, what one pass over the depth holds in registers.
constexpr int kRows = 4, kWide = 3 * kLanes;

// out (4 x 24) = a (4 x depth) * b (depth x 24)
DERMAP_KERNEL
void MultiplyWide(const float* a, std::ptrdiff_t a_stride, const float* b, std::ptrdiff_t b_stride, int depth,
                  float* out, std::ptrdiff_t out_stride) noexcept {
  const float *a1 = a + a_stride, *a2 = a1 + a_stride, *a3 = a2 + a_stride;
  Lanes s00{}, s01{}, s02{}, s10{}, s11{}, s12{}, s20{}, s21{}, s22{}, s30{}, s31{}, s32{};
  for (int k = 0; k < depth; ++k, b += b_stride) {
    const Lanes x = DERMAP_LOAD(b), y = DERMAP_LOAD(b + kLanes), z = DERMAP_LOAD(b + 2 * kLanes);
    s00 += a[k] * x, s01 += a[k] * y, s02 += a[k] * z;
    s10 += a1[k] * x, s11 += a1[k] * y, s12 += a1[k] * z;
    s20 += a2[k] * x, s21 += a2[k] * y, s22 += a2[k] * z;
    s30 += a3[k] * x, s31 += a3[k] * y, s32 += a3[k] * z;
  }
  float *o1 = out + out_stride, *o2 = o1 + out_stride, *o3 = o2 + out_stride;
  DERMAP_STORE(out, s00), DERMAP_STORE(out + kLanes, s01), DERMAP_STORE(out + 2 * kLanes, s02);
  DERMAP_STORE(o1, s10), DERMAP_STORE(o1 + kLanes, s11), DERMAP_STORE(o1 + 2 * kLanes, s12);
  DERMAP_STORE(o2, s20), DERMAP_STORE(o2 + kLanes, s21), DERMAP_STORE(o2 + 2 * kLanes, s22);
  DERMAP_STORE(o3, s30), DERMAP_STORE(o3 + kLanes, s31), DERMAP_STORE(o3 + 2 * kLanes, s32);
}

// out (4 x 8) = a (4 x depth) * b (depth x 8)
DERMAP_KERNEL
void MultiplyNarrow(const float* a, std::ptrdiff_t a_stride, const float* b, std::ptrdiff_t b_stride,
                    int depth, float* out, std::ptrdiff_t out_stride) noexcept {
  const float *a1 = a + a_stride, *a2 = a1 + a_stride, *a3 = a2 + a_stride;
  Lanes s0{}, s1{}, s2{}, s3{};
  for (int k = 0; k < depth; ++k, b += b_stride) {
    const Lanes x = DERMAP_LOAD(b);
    s0 += a[k] * x, s1 += a1[k] * x, s2 += a2[k] * x, s3 += a3[k] * x;
  }
  DERMAP_STORE(out, s0), DERMAP_STORE(out + out_stride, s1);
  DERMAP_STORE(out + 2 * out_stride, s2), DERMAP_STORE(out + 3 * out_stride, s3);
}

void MultiplySmall(const PlaneF& a, const PlaneF& b, PlaneF& out) {
  for (int r = 0; r < a.height(); ++r) {
    for (int c = 0; c < b.width(); ++c) {
      float sum = 0.0f;
      for (int k = 0; k < a.width(); ++k) sum += a(k, r) * b(c, k);
      out(c, r) = sum;
    }
  }
}

// The last rows and columns are done again where their number is no multiple of what a pass does.
void Multiply(const PlaneF& a, const PlaneF& b, PlaneF& out) {
  assert(a.width() == b.height());
  const int rows = a.height(), columns = b.width(), depth = a.width();
  EnsureShape(out, columns, rows);
  if (rows < kRows || columns < kLanes) return MultiplySmall(a, b, out);
  for (int c = 0; c < columns;) {
    const bool wide = c + kWide <= columns;
    const int at = wide ? c : std::min(c, columns - kLanes);
    for (int r = 0; r < rows; r += kRows) {
      const int row = std::min(r, rows - kRows);
      (wide ? MultiplyWide : MultiplyNarrow)(a.Row(row), depth, b.data() + at, columns, depth,
                                             out.Row(row) + at, columns);
    }
    c += wide ? kWide : kLanes;
  }
}

PlaneF TransposedOf(const PlaneF& plane) {
  PlaneF transposed(plane.height(), plane.width());
  for (int y = 0; y < plane.height(); ++y)
    for (int x = 0; x < plane.width(); ++x) transposed(y, x) = plane(x, y);
  return transposed;
}

DERMAP_KERNEL
void SumAndDifference(const float* a, const float* b, int n, float* __restrict sum,
                      float* __restrict difference) noexcept {
  for (int i = 0; i < n; ++i) {
    sum[i] = a[i] + b[i];
    difference[i] = a[i] - b[i];
  }
}

DERMAP_KERNEL
void SumAndDifferenceReversed(const float* a, const float* last, int n, float* __restrict sum,
                              float* __restrict difference) noexcept {
  for (int i = 0; i < n; ++i) {
    sum[i] = a[i] + last[-i];
    difference[i] = a[i] - last[-i];
  }
}

DERMAP_KERNEL
void Interleave(const float* even, const float* odd, int n, float* __restrict out) noexcept {
  for (int i = 0; i < n; ++i) {
    out[2 * i] = even[i];
    out[2 * i + 1] = odd[i];
  }
}

DERMAP_KERNEL
void Separate(const float* in, int n, float* __restrict even, float* __restrict odd) noexcept {
  for (int i = 0; i < n; ++i) {
    even[i] = in[2 * i];
    odd[i] = in[2 * i + 1];
  }
}

}  // namespace

CosineTransform::CosineTransform(int width, int height)
    : x_(MakeAxis(width)), y_(MakeAxis(height)), large_(std::max(width, height) > kLargestByProduct) {}

CosineTransform::Axis CosineTransform::MakeAxis(int size) {
  assert(size % 2 == 0);
  Axis axis;
  axis.size = size;
  if (size > kLargestByProduct) return axis;
  const int half = size / 2;
  axis.even = axis.odd = PlaneF(half, half);
  for (int f = 0; f < half; ++f) {
    for (int i = 0; i < half; ++i) {
      const double scale = std::sqrt((f == 0 ? 1.0 : 2.0) / size),
                   angle = std::numbers::pi * (i + 0.5) / size;
      axis.even(i, f) = static_cast<float>(scale * std::cos(2 * f * angle));
      axis.odd(i, f) = static_cast<float>(std::sqrt(2.0 / size) * std::cos((2 * f + 1) * angle));
    }
  }
  axis.even_transposed = TransposedOf(axis.even);
  axis.odd_transposed = TransposedOf(axis.odd);
  return axis;
}

void CosineTransform::Columns(const Axis& axis, bool forward, const PlaneF& in, PlaneF& out) {
  const int half = axis.size / 2, width = in.width();
  EnsureShape(columns_.even, width, half);
  EnsureShape(columns_.odd, width, half);
  EnsureShape(out, width, axis.size);
  if (forward) {
    for (int i = 0; i < half; ++i)
      SumAndDifference(in.Row(i), in.Row(axis.size - 1 - i), width, columns_.even.Row(i),
                       columns_.odd.Row(i));
  } else {
    for (int i = 0; i < half; ++i) {
      std::copy_n(in.Row(2 * i), width, columns_.even.Row(i));
      std::copy_n(in.Row(2 * i + 1), width, columns_.odd.Row(i));
    }
  }
  Multiply(forward ? axis.even : axis.even_transposed, columns_.even, columns_.even_out);
  Multiply(forward ? axis.odd : axis.odd_transposed, columns_.odd, columns_.odd_out);
  for (int i = 0; i < half; ++i) {
    if (forward) {
      std::copy_n(columns_.even_out.Row(i), width, out.Row(2 * i));
      std::copy_n(columns_.odd_out.Row(i), width, out.Row(2 * i + 1));
    } else {
      SumAndDifference(columns_.even_out.Row(i), columns_.odd_out.Row(i), width, out.Row(i),
                       out.Row(axis.size - 1 - i));
    }
  }
}

void CosineTransform::Rows(const Axis& axis, bool forward, const PlaneF& in, PlaneF& out) {
  const int half = axis.size / 2, height = in.height();
  EnsureShape(rows_.even, half, height);
  EnsureShape(rows_.odd, half, height);
  EnsureShape(out, axis.size, height);
  for (int y = 0; y < height; ++y) {
    if (forward) {
      SumAndDifferenceReversed(in.Row(y), in.Row(y) + axis.size - 1, half, rows_.even.Row(y),
                               rows_.odd.Row(y));
    } else {
      Separate(in.Row(y), half, rows_.even.Row(y), rows_.odd.Row(y));
    }
  }
  Multiply(rows_.even, forward ? axis.even_transposed : axis.even, rows_.even_out);
  Multiply(rows_.odd, forward ? axis.odd_transposed : axis.odd, rows_.odd_out);
  for (int y = 0; y < height; ++y) {
    if (forward) {
      Interleave(rows_.even_out.Row(y), rows_.odd_out.Row(y), half, out.Row(y));
    } else {
      float* to = out.Row(y);
      for (int i = 0; i < half; ++i) {
        to[i] = rows_.even_out(i, y) + rows_.odd_out(i, y);
        to[axis.size - 1 - i] = rows_.even_out(i, y) - rows_.odd_out(i, y);
      }
    }
  }
}

void CosineTransform::ByOpenCv(PlaneF& plane, bool forward) {
  cv::Mat view(plane.height(), plane.width(), CV_32F, plane.data());
  if (forward) {
    cv::dct(view, view);
  } else {
    cv::idct(view, view);
  }
}

void CosineTransform::Forward(PlaneF& plane) {
  if (large_) return ByOpenCv(plane, true);
  Columns(y_, true, plane, between_);
  Rows(x_, true, between_, plane);
}

void CosineTransform::Inverse(PlaneF& plane) {
  if (large_) return ByOpenCv(plane, false);
  Rows(x_, false, plane, between_);
  Columns(y_, false, between_, plane);
}

}  // namespace dermap
