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
  PathSeries(int patch_width, int patch_height, const ImagingConditions& conditions,
             const ForwardOptions& options);
  // Where `SeriesInput::light` is given: the patch and a little around it.
  const Domain& domain() const { return layout_.near; }
  // Hemispherical reflectance of the patch. Of `input`, the planes are as for ScatteringSeries.
  void Render(const SeriesInput& input, PlaneF& reflectance);

 private:
  enum EpidermisResponse { kR1Forward, kT1Forward, kR1Backward, kT1Backward, kR1BackwardBlack };
  enum DermisResponse { kR2Diffuse, kR2Normal };

  // The skin below, in pixels `factor` times as large.
  struct Below {
    int factor = 0;
    std::vector<PlaneF> epidermis, dermis;       // attenuations where light leaves
    PlaneF junction, skin_share, patch_share;    // A; 1 where there is skin; 1 under the window
    PlaneF down, up, up_sum, scratch, spectrum;  // light at the junction
  };

  void SetScene(const SeriesInput& input);
  int CoarseFactor(bool first) const;
  void SetBelow(int factor, const SeriesInput& input, Below& below);
  void EnterEpidermis(const SeriesInput& input, PlaneF& reflectance);
  void AddBallistic(const SeriesInput& input);
  void ReturnFromDermis(Below& below, const PlaneF* ballistic) const;
  void ReturnFromEpidermis(Below& below, bool black_tape) const;
  void AddRemainder(Below& below, bool black_tape) const;
  void AddUpward(const PlaneF& up, int factor);
  void LeaveEpidermis(PlaneF& reflectance);
  void ToWhole(const PlaneF& near, int factor, PlaneF& whole) const;

  double pixel_size_mm_;
  bool window_;
  Coupling coupling_;
  double tolerance_;
  PathLayout layout_;
  PathGrid near_grid_, whole_grid_;
  PathLayer epidermis_, dermis_;
  Below first_, rest_;  // where light returns for the first time, and all times after
  PlaneF junction_;     // A, near
  PlaneF fine_, spectrum_, coarse_, ballistic_, upward_;
};

}  // namespace dermap
