// SPDX-License-Identifier: Apache-2.0
// Totals without noise: adding-doubling on an exact angular quadrature, layers of different index.
// Source: van de Hulst, "Multiple Light Scattering" (1980); Prahl, van Gemert, Welch, Appl. Opt. 32 (1993)
// 559.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tests/reference/layer_stack.h"

namespace dermap::reference {

// Light in a medium is a vector of fluxes, one a node: a cone of transverse invariant n sin(theta), so that
// Snell's law maps node onto node and a face is a diagonal. Medium m carries only its first count[m] nodes.
struct AngularNodes {
  std::vector<double> n;                    // of each medium
  std::vector<int> count;                   // nodes that propagate in it
  std::vector<std::vector<double>> mu;      // cosines [medium][node]
  std::vector<std::vector<double>> weight;  // of d mu; sums to 1 in each medium
  int normal = 0;                           // the node that is normal incidence
};
// nodes_per_interval: of each interval between the critical angles.
AngularNodes MakeAngularNodes(const std::vector<double>& n, int nodes_per_interval);

// Reflection and transmission of anything plane, both directions, on flux vectors.
struct Operators {
  Eigen::MatrixXd r_down, t_down;  // light coming from above
  Eigen::MatrixXd r_up, t_up;      // light coming from below
};
Operators Add(const Operators& above, const Operators& below);

struct Totals {
  double specular = 0.0;       // of the first face, normal incidence
  double reflectance = 0.0;    // without the specular part
  double transmittance = 0.0;  // everything that leaves below
  double ballistic = 0.0;      // part of transmittance that never scattered (one pass)
};

class AddingDoubling {
 public:
  explicit AddingDoubling(const LayerStack& stack, int nodes_per_interval = 14);

  const AngularNodes& nodes() const { return nodes_; }
  Totals NormalIncidence() const;
  // The whole stack; media: 0 is above, i+1 is layer i, the last is below.
  Operators Whole() const { return Part(0, static_cast<int>(stack_.layers.size()) + 1); }
  // From inside medium `first` to inside medium `last`, the media themselves included where they are layers
  // and `include_first`, `include_last` say so; the faces between are.
  Operators Part(int first, int last, bool include_first = true, bool include_last = true) const;
  // Flux vector of sum 1, radiance uniform over the directions of a medium that also propagate in `through`
  // (and multiplied by the face's transmittance, if weighted).
  Eigen::VectorXd LambertianFlux(int medium, int through, bool transmitted) const;

 private:
  LayerStack stack_;
  AngularNodes nodes_;
  Operators Face(int upper, int lower, double absorbance) const;
  Operators Slab(int layer) const;
  double IndexOf(int medium) const;
};

Totals NormalIncidenceTotals(const LayerStack& stack, int nodes_per_interval = 14);

}  // namespace dermap::reference
