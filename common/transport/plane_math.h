// SPDX-License-Identifier: Apache-2.0
// Arithmetic of whole planes, pixel by pixel. Planes of one operation have one shape.
#pragma once

#include "common/core/image.h"

namespace dermap {

void Fill(PlaneF& plane, int width, int height, float value);
void AddTo(const PlaneF& addend, PlaneF& sum);
void AddScaled(const PlaneF& addend, float factor, PlaneF& sum);
void MultiplyBy(const PlaneF& factor, PlaneF& values);
void Product(const PlaneF& a, const PlaneF& b, PlaneF& out);
void AddProduct(const PlaneF& a, const PlaneF& b, PlaneF& sum);
void AddProductScaled(const PlaneF& a, const PlaneF& b, float factor, PlaneF& sum);
void Scaled(const PlaneF& in, float factor, PlaneF& out);

}  // namespace dermap
