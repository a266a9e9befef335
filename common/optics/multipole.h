// SPDX-License-Identifier: Apache-2.0
// The diffusion multipole of [Donner and Jensen 2005, "Light diffusion in multi-layered translucent
// materials"], which is where [D08 3] takes its profiles from, as closed forms of the lateral frequency k
// (1/mm, radians).
#pragma once

#include <memory>

#include "common/optics/profile_source.h"

namespace dermap {

// A = (1 + F_dr)/(1 - F_dr), F_dr the diffuse reflectance that light in n_inside meets at the face to
// n_outside.
double BoundaryMismatch(double n_inside, double n_outside);

// A slab lit at its near face by one source, a mean free path below that face. Lengths in mm.
class MultipoleSlab {
 public:
  // a_near, a_far: A of the face that the light enters by, and of the other.
  MultipoleSlab(const LayerOptics& layer, double thickness_mm, double a_near, double a_far);

  // 2-D Fourier transforms of the profiles, per light that has entered. Transmittance is what the formula
  // gives: negative where the source lies beyond the far face (1/sigma_t' > thickness).
  double Reflectance(double k_per_mm) const;
  double Transmittance(double k_per_mm) const;

 private:
  double Decay(double k_per_mm) const;  // s = sqrt(sigma_tr^2 + k^2), 1/mm

  double albedo_;     // alpha', reduced
  double sigma_tr2_;  // 1/mm^2
  double source_mm_;  // l = 1/sigma_t'
  double thickness_mm_;
  double near_mm_, far_mm_;  // z_b of the two faces
};

// The same for a half-space: the dipole of [Jensen et al. 2001].
class DipoleHalfSpace {
 public:
  DipoleHalfSpace(const LayerOptics& layer, double a_near);
  double Reflectance(double k_per_mm) const;

 private:
  double albedo_, sigma_tr2_, source_mm_, near_mm_;
};

// "multipole": every face with its own A, in both directions, as [D08] writes it.
// "multipole-symmetric": the shortcut that takes R1 and T1 of light from above for light from below as well.
//
// How the faces share the work: what a face reflects inwards is in the A of the medium that the light comes
// from; so light that crosses the junction has met its face already, and R1-, T1- and R2 need no factor of
// entry. Light from outside, at normal incidence, enters with 1 - F(normal), which R1+ and T1+ contain. The
// multipole has no ballistic part, and does not tell normal from diffuse light.
enum class MultipoleDirections { kOwn, kSymmetric };
std::unique_ptr<ProfileSource> MakeMultipoleSource(MultipoleDirections directions);

}  // namespace dermap
