// SPDX-License-Identifier: Apache-2.0
// Renders one band: the scene's planes on its domain, the series at one wavelength or several, the filter's
// width.
#pragma once

#include <memory>
#include <vector>

#include "common/transport/band_optics.h"
#include "common/transport/filter_width.h"
#include "common/transport/paths/path_light.h"
#include "common/transport/scattering_series.h"

namespace dermap {

// Keeps its memory between renders of patches of one shape; one a thread.
class BandRenderer {
 public:
  // `plans` are shared by the model's renderers.
  BandRenderer(int width, int height, const ImagingConditions& conditions, const ForwardOptions& options,
               PathPlans& plans);
  bool Fits(int width, int height) const { return width_ == width && height_ == height; }

  // Hemispherical reflectance of the patch. `light` may be null (1 everywhere); `junction_absorbance` may be
  // null (`base_absorbance` everywhere). `keep`: whether Tangent or Transpose will be asked.
  void Render(const BandOptics& band, const std::vector<LocalTotals>& totals, const FilterWidth& width,
              const ParameterMaps& maps, const PlaneF* junction_absorbance, double base_absorbance,
              const PlaneF* light, bool keep, PlaneF& out);

  // What the engine `lowrank` took for the last render, and why.
  BandChoice choice() const;

  // Of the last render, which must have been kept, at the band's centre (not of the full band): the change of
  // the reflectance under a change of the maps, and the derivatives of the sum of weights * reflectance by
  // the maps. A plane of `change` may be empty; of the junction there is one or none.
  void Tangent(const BandOptics& band, const FilterWidth& width, const ParameterMaps& maps,
               const ParameterMaps& change, const PlaneF* junction_change, PlaneF& out);
  // `weights` is used up.
  void Transpose(const BandOptics& band, const FilterWidth& width, const ParameterMaps& maps, PlaneF& weights,
                 ParameterMaps& derivatives, PlaneF& junction_derivative);

 private:
  void SetLight(const PlaneF* light, const Domain& domain);
  void SetTransmittance(const PlaneF* junction_absorbance, double base_absorbance);
  void SetAbsorption(const Absorbers& absorbers, const ParameterMaps& maps);
  void RenderNode(const BandOptics& band, int node, const LocalTotals& totals, const ParameterMaps& maps,
                  const PlaneF* light, PlaneF& out);
  void RenderPaths(const BandOptics::Node& optics, const LocalTotals& totals, int most_terms, bool black_tape,
                   const PlaneF* light, PlaneF& out);
  PathLight& LightWithMargin(double margin_mm);

  std::array<double, 3> LocalDerivatives(const BandOptics& band, std::size_t pixel) const;
  void LocalTangent(const BandOptics& band, const SeriesChanges& changes, PlaneF& out) const;
  void LocalTranspose(const BandOptics& band, const PlaneF& weights, SeriesChanges& derivatives) const;

  int width_, height_;
  ImagingConditions conditions_;
  ForwardOptions options_;
  PathPlans& plans_;
  std::unique_ptr<ScatteringSeries> gaussian_series_;    // of the engines made of Gaussians
  std::vector<std::unique_ptr<PathLight>> path_lights_;  // of the engine `lowrank`, by margins
  KeptSeries* kept_ = nullptr;                           // the last render; none where it was local
  BandChoice choice_;
  float local_light_ = 1.0f;
  bool keep_ = false;                    // whether derivatives will be asked for
  PlaneF mu_a_epidermis_, mu_a_dermis_;  // 1/mm
  PlaneF transmittance_;                 // A of the junction
  PlaneF light_;                         // on the whole domain
  PlaneF node_reflectance_;
  PlaneF center_reflectance_;  // before the filter's width
  PlaneF unlit_;               // 1 everywhere
  SeriesChanges by_;           // scratch of derivatives, as are these
  PlaneF ratio_;
  std::array<PlaneF, kParameterCount + 1> gradient_;
};

}  // namespace dermap
