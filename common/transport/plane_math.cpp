// SPDX-License-Identifier: Apache-2.0
// Loops over pixels.
#include "common/transport/plane_math.h"

#include <algorithm>
#include <cassert>

#include "common/core/kernel.h"
#include "common/transport/domain.h"

namespace dermap {
namespace {

DERMAP_KERNEL
void AddLoop(const float* a, std::size_t n, float* __restrict sum) noexcept {
  for (std::size_t i = 0; i < n; ++i) sum[i] += a[i];
}

DERMAP_KERNEL
void AddScaledLoop(const float* a, float factor, std::size_t n, float* __restrict sum) noexcept {
  for (std::size_t i = 0; i < n; ++i) sum[i] += factor * a[i];
}

DERMAP_KERNEL
void MultiplyLoop(const float* a, std::size_t n, float* __restrict values) noexcept {
  for (std::size_t i = 0; i < n; ++i) values[i] *= a[i];
}

DERMAP_KERNEL
void ProductLoop(const float* a, const float* b, std::size_t n, float* __restrict out) noexcept {
  for (std::size_t i = 0; i < n; ++i) out[i] = a[i] * b[i];
}

DERMAP_KERNEL
void AddProductLoop(const float* a, const float* b, std::size_t n, float* __restrict sum) noexcept {
  for (std::size_t i = 0; i < n; ++i) sum[i] += a[i] * b[i];
}

DERMAP_KERNEL
void AddProductScaledLoop(const float* a, const float* b, float factor, std::size_t n,
                          float* __restrict sum) noexcept {
  for (std::size_t i = 0; i < n; ++i) sum[i] += factor * a[i] * b[i];
}

DERMAP_KERNEL
void ScaledLoop(const float* a, float factor, std::size_t n, float* out) noexcept {
  for (std::size_t i = 0; i < n; ++i) out[i] = factor * a[i];
}

}  // namespace

void Fill(PlaneF& plane, int width, int height, float value) {
  EnsureShape(plane, width, height);
  std::fill(plane.values().begin(), plane.values().end(), value);
}

void AddTo(const PlaneF& addend, PlaneF& sum) {
  assert(addend.SameShape(sum));
  AddLoop(addend.data(), sum.size(), sum.data());
}

void AddScaled(const PlaneF& addend, float factor, PlaneF& sum) {
  assert(addend.SameShape(sum));
  AddScaledLoop(addend.data(), factor, sum.size(), sum.data());
}

void MultiplyBy(const PlaneF& factor, PlaneF& values) {
  assert(factor.SameShape(values));
  MultiplyLoop(factor.data(), values.size(), values.data());
}

void Product(const PlaneF& a, const PlaneF& b, PlaneF& out) {
  assert(a.SameShape(b));
  EnsureShape(out, a.width(), a.height());
  ProductLoop(a.data(), b.data(), out.size(), out.data());
}

void AddProduct(const PlaneF& a, const PlaneF& b, PlaneF& sum) {
  assert(a.SameShape(b) && a.SameShape(sum));
  AddProductLoop(a.data(), b.data(), sum.size(), sum.data());
}

void AddProductScaled(const PlaneF& a, const PlaneF& b, float factor, PlaneF& sum) {
  assert(a.SameShape(b) && a.SameShape(sum));
  AddProductScaledLoop(a.data(), b.data(), factor, sum.size(), sum.data());
}

void Scaled(const PlaneF& in, float factor, PlaneF& out) {
  EnsureShape(out, in.width(), in.height());
  ScaledLoop(in.data(), factor, out.size(), out.data());
}

}  // namespace dermap
