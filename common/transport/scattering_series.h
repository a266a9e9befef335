// SPDX-License-Identifier: Apache-2.0
// The inter-scattering series between the two layers [D08 eq. 7], at one wavelength.
#pragma once

#include <memory>

#include "common/transport/band_optics.h"
#include "common/transport/convolver.h"

namespace dermap {

// One render's inputs, borrowed.
struct SeriesInput {
  const BandTables& tables;
  const LocalTotals& totals;
  double mu_s_epidermis, mu_s_dermis;  // reduced scattering, 1/mm
  const PlaneF& mu_a_epidermis;        // on the patch, 1/mm
  const PlaneF& mu_a_dermis;
  const PlaneF& transmittance;  // A of the junction, on the patch [D08 eq. 8]
  const PlaneF& light;          // Phi, on the whole domain
  bool black_tape;              // around the patch
  int terms;
  bool close;
};

// Keeps all memory that a render needs; one a thread.
class ScatteringSeries {
 public:
  ScatteringSeries(const Domain& domain, std::unique_ptr<Convolver> convolver);
  const Domain& domain() const { return domain_; }
  // Hemispherical reflectance of the patch.
  void Render(const SeriesInput& input, PlaneF& reflectance);

 private:
  void SetScene(const SeriesInput& input);
  void ApplyJunction(PlaneF& flux) const;
  void EnterDermis(const SeriesInput& input);
  void AddBallistic(const SeriesInput& input);
  void AddRemainder(const SeriesInput& input);

  Domain domain_;
  std::unique_ptr<Convolver> convolver_;
  TablePositions epidermis_, dermis_;
  PlaneF junction_;                                                    // A, on the whole domain
  ResponseWeights r1_forward_, t1_backward_;                           // on the patch
  ResponseWeights t1_forward_, r1_backward_, r2_diffuse_, r2_normal_;  // on the whole domain
  PlaneF down_, up_, up_of_ballistic_, up_sum_, leaving_;
};

}  // namespace dermap
