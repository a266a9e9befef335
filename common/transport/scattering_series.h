// SPDX-License-Identifier: Apache-2.0
// The inter-scattering series between the two layers [D08 eq. 7], at one wavelength.
#pragma once

#include <array>
#include <memory>

#include "common/transport/band_optics.h"
#include "common/transport/convolver.h"
#include "common/transport/paths/line_map.h"
#include "common/transport/plane_graph.h"

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

// On the patch: of mu_a of both layers and of the junction's transmittance.
using SeriesChanges = std::array<PlaneF, 3>;

// A render that was kept, whatever the engine: the product with its Jacobian and with the transpose.
class KeptSeries {
 public:
  virtual ~KeptSeries() = default;
  // What small changes do to the reflectance. A change may be empty: none.
  virtual void Tangent(const SeriesChanges& changes, PlaneF& change) = 0;
  // The derivatives, by what changes, of the sum of weights * reflectance.
  virtual void Transpose(const PlaneF& weights, SeriesChanges& derivatives) = 0;
};

// Keeps all memory that a render needs; one a thread.
class ScatteringSeries : public KeptSeries {
 public:
  // `beneath`: what skin is outside the patch.
  ScatteringSeries(const Domain& domain, std::unique_ptr<Convolver> convolver,
                   BeneathTape beneath = BeneathTape::kEdge);
  const Domain& domain() const { return domain_; }
  // Hemispherical reflectance of the patch. `keep`: whether Tangent or Transpose will be asked.
  void Render(const SeriesInput& input, PlaneF& reflectance, bool keep = false);
  void Tangent(const SeriesChanges& changes, PlaneF& change) override;
  void Transpose(const PlaneF& weights, SeriesChanges& derivatives) override;

 private:
  using Id = PlaneGraph::Id;
  struct Layer {
    Id patch = 0, whole = 0;  // mu_a
    TablePositions positions;
  };

  Id ToWhole(const PlaneF& patch, Id& input);
  void SetLayer(const PlaneF& mu_a, Layer& layer);
  void SetScene(const SeriesInput& input);
  Id LookUp(const LocalTotals::Totals& inside, const LocalTotals::Totals& outside, const Layer& layer);
  Id ProductAndDrop(Id a, Id b);
  Id SumAndDrop(Id a, Id b);
  Id Convolve(Id a, const Layer& layer, const ResponseWeights& weights);
  Id Enter(const SeriesInput& input);
  Id EnterDermis(Id down, const SeriesInput& input);
  Id Remainder(Id up, const SeriesInput& input);

  Domain domain_;
  std::unique_ptr<Convolver> convolver_;
  PlaneMap to_whole_, from_whole_;
  PlaneGraph graph_{Border::kZero};
  bool keep_ = false;
  Layer epidermis_, dermis_;
  Id junction_input_ = 0, junction_ = 0, surface_ = 0, reflectance_ = 0;  // junction: A
  ResponseWeights r1_forward_, t1_backward_;                              // on the patch
  ResponseWeights t1_forward_, r1_backward_, r2_diffuse_, r2_normal_;     // on the whole domain
};

}  // namespace dermap
