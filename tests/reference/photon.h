// SPDX-License-Identifier: Apache-2.0
// One photon's walk through the layers of a Monte Carlo scene.
#pragma once

#include <optional>

#include "tests/reference/monte_carlo.h"
#include "tests/reference/random.h"

namespace dermap::reference {

struct Exit {
  bool above = true;
  double x_mm = 0.0, y_mm = 0.0;  // where it left
  double weight = 0.0;
  int scatterings = 0;
};

class PhotonWalk {
 public:
  PhotonWalk(const MonteCarloScene& scene, double roulette_weight);
  double specular() const { return specular_; }
  // nullopt: absorbed.
  std::optional<Exit> Run(Random& random) const;

 private:
  struct Photon {
    double x, y, z;     // mm
    double ux, uy, uz;  // direction, z downwards
    double weight;
    int layer;
    int scatterings;
  };
  const MonteCarloScene& scene_;
  double roulette_weight_;
  double specular_;
  std::vector<double> top_mm_;  // depth of each layer's upper face, and of the last one's lower face

  Photon Launch(Random& random) const;
  void Move(Photon& photon, double length_mm) const;
  void Scatter(Photon& photon, Random& random) const;
  // True if it left the stack.
  bool MeetFace(Photon& photon, Random& random) const;
  double AbsorptionAlong(const PlaneF& mu_a, const Photon& photon, double length_mm) const;
  int PixelIndex(double position_mm, int count) const;
  bool UnderTape(const Photon& photon) const;
};

}  // namespace dermap::reference
