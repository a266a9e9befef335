// SPDX-License-Identifier: Apache-2.0
// The inter-scattering series between the layers [D08 eq. 7] by path lengths, on ever coarser grids
// (path_plan.h).
#pragma once

#include <memory>

#include "common/core/short_list.h"
#include "common/transport/paths/path_plan.h"
#include "common/transport/plane_graph.h"
#include "common/transport/scattering_series.h"

namespace dermap {

// Keeps all memory that a render needs; one a thread.
class PathLight : public KeptSeries {
 public:
  PathLight(int patch_width, int patch_height, const ImagingConditions& conditions, double margin_mm,
            const ForwardOptions& options);
  double margin_mm() const { return frames_.margin_mm; }
  const PathFrames& frames() const { return frames_; }
  // Where `SeriesInput::light` is given: the patch, a little widened.
  const Domain& domain() const { return frames_.patch; }
  // Hemispherical reflectance of the patch. Of `input`, the planes are as for ScatteringSeries.
  // `keep`: whether Tangent or Transpose will be asked; they need `input.light` still.
  void Render(const SeriesInput& input, PathPlans& plans, bool keep, PlaneF& reflectance);
  const PathPlan& plan() const { return *plan_; }  // of the last render

  // Of the last render, if it was kept.
  void Tangent(const SeriesChanges& changes, PlaneF& change) override;
  void Transpose(const PlaneF& weights, SeriesChanges& derivatives) override;

 private:
  using Id = PlaneGraph::Id;
  using Ids = ShortList<Id, kMostPaths>;
  using Pairs = ShortList<PlaneGraph::Pair, kMostPaths>;
  static constexpr std::size_t kMostLevels = 12;
  struct MapPair {
    PlaneMap map, transposed;
  };
  // What light keeps at the end of a path of one layer, on each grid, [path].
  struct Layer {
    Ids fine, whole, rest;
  };

  Id OnPatch(const PlaneF& plane);
  Id Map(Id id, MapPair& maps) { return graph_.Map(id, maps.map, maps.transposed); }
  Id MapAndDrop(Id id, MapPair& maps);
  Id SkinToWhole(Id fine);
  Id LightToWhole(Id light);
  Layer MakeLayer(Id mu_a, const std::vector<double>& lengths_mm, const SymmetricKernel& stray,
                  bool need_fine);
  Id At(Id light, const Ids& ends, std::size_t path);
  void Enter(const SeriesInput& input);
  Id Below(const SeriesInput& input, Id junction);
  Id Ballistic(Id junction);
  Id ReturnFromDermis(Id down, const Id* ballistic, const PathPlan::Kernels& diffuse, const Ids& ends,
                      CosineTransform& transform);
  Id ReturnFromEpidermis(Id up, bool black_tape);
  Id Quotient(bool black_tape);
  Id Leave(const Id* below);
  Id SumAndDrop(Id a, Id b);
  bool NeedsStencil(std::size_t level, std::size_t path) const;
  bool reciprocal() const { return options_.coupling == Coupling::kReciprocal; }

  PathFrames frames_;
  ForwardOptions options_;
  std::vector<MapPair> light_down_, light_up_, skin_down_;
  MapPair to_rest_, from_rest_;
  CosineTransform whole_transform_, rest_transform_;
  PlaneF skin_share_, patch_share_rest_, tape_share_rest_;

  std::shared_ptr<const PathPlan> plan_;
  struct Stray {
    double mu_s = 0.0;
    SymmetricKernel kernel;
  };
  void SetStray(double mu_s, Stray& stray) const;
  Stray stray_epidermis_, stray_dermis_;
  const PlaneF* light_ = nullptr;
  PlaneGraph graph_;
  Id mu_a_epidermis_ = 0, mu_a_dermis_ = 0, junction_ = 0, junction_rest_ = 0, reflectance_ = 0;
  Layer epidermis_, dermis_;
  std::array<ShortList<Id, kMostLevels>, kMostPaths> light_at_;  // [path][level] on its way down
  Ids entering_;           // [path] its spectrum on the transforms' grid
  std::vector<Id> later_;  // scratch of Below
  SeriesChanges widened_;  // scratch of derivatives
  PlaneF widened_weights_;
};

}  // namespace dermap
