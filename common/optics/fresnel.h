// SPDX-License-Identifier: Apache-2.0
// Fresnel reflection of unpolarised light at a smooth face between two clear media, as a share of the
// incident light.
#pragma once

namespace dermap {

// cos_incidence: cosine of the angle to the normal on the side of n_from, 0 to 1. 1 beyond the critical
// angle.
double FresnelReflectance(double cos_incidence, double n_from, double n_to) noexcept;

// Of diffuse (Lambertian) light that falls on the face from the side of n_from: 2 int_0^1 F(mu) mu dmu.
double DiffuseFresnelReflectance(double n_from, double n_to) noexcept;

}  // namespace dermap
