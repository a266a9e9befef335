// SPDX-License-Identifier: Apache-2.0
// The inter-scattering series between the layers [D08 eq. 7] by path lengths, on ever coarser grids
// (path_plan.h).
#pragma once

#include <memory>

#include "common/transport/paths/attenuation.h"
#include "common/transport/paths/cosine_transform.h"
#include "common/transport/paths/path_plan.h"
#include "common/transport/scattering_series.h"

namespace dermap {

// Keeps all memory that a render needs; one a thread.
class PathLight {
 public:
  PathLight(int patch_width, int patch_height, const ImagingConditions& conditions,
            const ForwardOptions& options);
  // Where `SeriesInput::light` is given: the patch, a little widened.
  const Domain& domain() const { return frames_.patch; }
  // Hemispherical reflectance of the patch. Of `input`, the planes are as for ScatteringSeries.
  void Render(const SeriesInput& input, PathPlans& plans, PlaneF& reflectance);

 private:
  // One layer of the scene: what light keeps at the end of a path, on each grid, [path].
  struct Layer {
    std::vector<PlaneF> fine, whole, rest;
  };

  // A grid on which light is followed by cosine transforms.
  struct Grid {
    explicit Grid(const PathFrames::Frame& frame) : transform(frame.width, frame.height) {}
    CosineTransform transform;
    PlaneF spectrum, scratch;
  };

  void SetScene(const SeriesInput& input, PathPlans& plans);
  void SetLayer(const PlaneF& mu_a, const std::vector<double>& lengths_mm, const SymmetricKernel& stray,
                bool keep_fine, Layer& layer);
  void SkinToWhole(const PlaneF& fine, PlaneF& whole);
  void Enter(const SeriesInput& input, PlaneF& surface);
  void AddBallistic(const SeriesInput& input);
  void ReturnFromDermis(const PathPlan::Kernels& diffuse, const PlaneF& down, const PlaneF* ballistic,
                        const std::vector<PlaneF>& ends, Grid& grid, PlaneF& up);
  void ReturnFromEpidermis(bool black_tape);
  void AddRemainder(bool black_tape);
  void Leave(const SeriesInput& input, PlaneF& reflectance);

  PathFrames frames_;
  ForwardOptions options_;
  std::vector<PlaneMap> light_down_, light_up_, skin_down_;
  PlaneMap to_rest_, from_rest_;
  Grid whole_, rest_;
  StencilRunner stencils_;
  SeparableBlur blur_{Border::kMirror};
  PlaneF skin_share_, patch_share_rest_;

  std::shared_ptr<const PathPlan> plan_;
  Layer epidermis_, dermis_;
  PlaneF mu_a_;  // widened
  PlaneF junction_, junction_whole_, junction_rest_;
  std::vector<PlaneF> entering_;              // spectra on the transforms' grid, [path]
  std::vector<std::vector<PlaneF>> surface_;  // [level - 1][path] what stencils return, levels 1 ...
  std::vector<PlaneF> step_;                  // light on each grid, on its way down or up
  PlaneF scratch_fine_, down_, ballistic_, upward_, down_rest_, up_rest_, up_sum_rest_, black_;
};

}  // namespace dermap
