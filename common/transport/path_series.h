// SPDX-License-Identifier: Apache-2.0
// The inter-scattering series between the layers by path lengths (path_layer.h): the same terms as
// scattering_series.h, but light that goes back and forth below the epidermis, which is smooth, is kept on a
// coarser grid.
#pragma once

#include <memory>

#include "common/transport/path_layer.h"
#include "common/transport/scattering_series.h"

namespace dermap {

// Keeps all memory that a render needs; one a thread.
class PathSeries {
 public:
  PathSeries(std::unique_ptr<PathGrid> grid, Coupling coupling, double tolerance);
  const Domain& domain() const { return grid_->domain(); }
  // Hemispherical reflectance of the patch. Of `input`, the planes are as for ScatteringSeries.
  void Render(const SeriesInput& input, PlaneF& reflectance);

 private:
  enum EpidermisResponse { kR1Forward, kT1Forward, kR1Backward, kT1Backward, kR1BackwardBlack };
  enum DermisResponse { kR2Diffuse, kR2Normal };

  void SetScene(const SeriesInput& input);
  int CoarseFactor() const;
  void EnterEpidermis(const SeriesInput& input, PlaneF& reflectance);
  void AddBallistic(const SeriesInput& input);
  void ReturnFromDermis(bool ballistic);
  void ReturnFromEpidermis(bool black_tape);
  void AddRemainder(bool black_tape);
  void LeaveEpidermis(PlaneF& reflectance);

  std::unique_ptr<PathGrid> grid_;
  Coupling coupling_;
  double tolerance_;
  int factor_ = 1;  // of the coarser grid
  PathLayer epidermis_, dermis_;
  PlaneF junction_;                                       // A, fine
  PlaneF coarse_junction_, skin_share_, patch_share_;     // coarse
  std::vector<PlaneF> coarse_epidermis_, coarse_dermis_;  // attenuations where light leaves, coarse
  PlaneF fine_, spectrum_;                                // scratch
  PlaneF down_, up_, up_sum_, ballistic_, coarse_, coarse_spectrum_, black_;
};

}  // namespace dermap
