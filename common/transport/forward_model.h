// SPDX-License-Identifier: Apache-2.0
// The heterogeneous two-layer forward model [D08 eq. 5-9] in gather form: maps of parameters in, reflectance
// out.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/image.h"
#include "common/core/progress.h"
#include "common/optics/profile_table.h"
#include "common/tissue/tissue.h"
#include "common/transport/conditions.h"

namespace dermap {

enum class Engine {
  kCascade,  // the paper's: 18 separable blurs at full resolution, each made from the last; the slow twin for
             // ever
  kPyramid,  // the same sum with wide Gaussians at reduced resolution
  kLowRank,  // a few path lengths instead of Gaussians, on ever coarser grids
};
std::string_view EngineName(Engine engine);  // "cascade", "pyramid", "lowrank"
// Throws InputError that lists the known names.
Engine EngineFromName(std::string_view name);

// What a response's profile between two points depends on: the absorption at both (paths/path_plan.h), or at
// the exit alone [D08 4.1]. The engines made of Gaussians know only the second.
enum class Coupling { kReciprocal, kGather };

// What skin is taken to be beneath the tape, where nobody saw it: as at the window's edge, the patch
// mirrored, or the mean of the row (column) that ends there.
enum class BeneathTape { kEdge, kMirrored, kMean };
std::string_view NameOf(BeneathTape beneath);  // "edge", "mirrored", "mean"
// Throws InputError that lists the known names.
BeneathTape BeneathTapeFromName(std::string_view name);

inline constexpr int kAutomaticTerms = -1;
inline constexpr double kAutomaticMargin = -1.0;
inline constexpr int kAutomaticPaths = 0;

// How much of the model a band of a scene needed, from the bottom of the ladder up.
enum class Rung {
  kLocal,        // no lateral transport: closed forms
  kHomogeneous,  // one path length: one kernel for all of the scene
  kFirstOrder,   // two: kernels that change with absorption by one term
  kFull,
};
std::string_view RungName(Rung rung);  // "local", "homogeneous", "first-order", "full"

// What the engine `lowrank` chose for a band of a scene, and its own estimate of the error that is left.
struct BandChoice {
  Rung rung = Rung::kFull;
  int epidermis_paths = 0, dermis_paths = 0;
  int terms = 0;           // of [D08 eq. 7] after Phi * R1+
  double margin_mm = 0.0;  // beneath the tape
  double error = 0.0;      // relative, rms over the patch
  std::string why;         // one sentence
};

struct ForwardOptions {
  Engine engine = Engine::kLowRank;
  Coupling coupling = Coupling::kReciprocal;  // of the engine `lowrank`
  // Of the engine `lowrank`: how far a render may be off, relative, rms over the patch. The engine takes no
  // more path lengths, terms and margin than a band of a scene needs for it (BandChoice).
  double tolerance = 1e-3;
  // Path lengths of either layer (engine `lowrank`): as few as the tolerance asks for, or exactly so many, 1
  // to kMostPaths, whatever error that leaves.
  int path_lengths = kAutomaticPaths;
  // Every so-many-th of the 18 Gaussians (the other engines), with weights of their own fit: 1, 2, 3 or 6.
  int gaussian_step = 1;
  // Terms of [D08 eq. 7] after Phi * R1+. Automatic: for each band as many as the scene's lightest skin needs
  // (lowrank) or the lightest that there is (others: 3 to 6; the paper takes 4 for blue light, 5 for green
  // and red).
  int terms = kAutomaticTerms;
  // Whether what lies beyond the last term is added as if skin and light were uniform around each pixel (a
  // geometric series of the last term). If not, the series simply ends, as the paper's does.
  bool close_series = true;
  // Skin around the patch that takes part: beneath the tape, or beyond the border. Automatic: as far as light
  // goes (lowrank), or 1.9 mm.
  double margin_mm = kAutomaticMargin;
  BeneathTape beneath_tape = BeneathTape::kEdge;
  // Whether every band with a width is rendered at several wavelengths of its filter. If not, it is rendered
  // once, at its centre, and corrected by the ratio of local closed forms (cheap; the error is tested).
  bool full_band_integration = false;
};

// Tables and absorbers of a set of bands; built once, then read by any thread.
struct BandOptics {
  Band band;
  struct Node {  // one wavelength of the filter's curve
    double weight;
    double mu_s_epidermis, mu_s_dermis;  // reduced scattering, 1/mm
    Absorbers absorbers;
    BandTables
        tables;  // beside the centre only totals, unless the whole band is rendered (full_band_integration)
  };
  std::vector<Node> nodes;  // the centre is nodes[center]; one node where the width is 0
  int center = 0;
  int terms = 0;  // how many terms of [D08 eq. 7] after Phi * R1+ a render sums
};

// Derivatives of the logarithm of uniform skin's reflectance.
struct LogSensitivity {
  double mu_a_epidermis, mu_a_dermis;  // by absorption, mm
  double junction_absorbance;
};

class BandRenderer;

class ForwardModel {
 public:
  // Throws InputError where bands, conditions or options make no sense.
  ForwardModel(const Chromophores& chromophores, const ProfileSource& source, const TissueConfig& tissue,
               std::span<const Band> bands, const ImagingConditions& conditions,
               const ForwardOptions& options, const ProgressFunction& progress = {});
  ~ForwardModel();
  ForwardModel(ForwardModel&&) noexcept;
  // The same skin and bands under other conditions, such as another size of a pixel: the tables, which do not
  // depend on them, are taken over.
  ForwardModel With(const ImagingConditions& conditions) const;
  // The same under other options; full_band_integration, for which tables were built or not, must stay.
  ForwardModel With(const ForwardOptions& options) const;

  int band_count() const;
  const ImagingConditions& conditions() const;
  const ForwardOptions& options() const;
  const TissueConfig& tissue() const;
  const std::vector<BandOptics>& optics() const;

  // Reflectance of the patch, one plane a band, of the maps' shape. Bands run in parallel.
  // `light`: relative irradiance on the patch, one plane a band, one for all, or empty (1 everywhere).
  // Throws InputError where the planes do not fit together or hold values that are not finite.
  // `choices`, where asked for: of every band (engine `lowrank`).
  std::vector<PlaneF> Render(const ParameterMaps& maps, std::span<const PlaneF> light = {},
                             std::vector<BandChoice>* choices = nullptr) const;
  // The same into planes that are there: of their shape, it takes no memory once a render was made.
  void Render(const ParameterMaps& maps, std::span<const PlaneF> light,
              std::vector<PlaneF>& reflectance) const;
  PlaneF RenderBand(int band, const ParameterMaps& maps, const PlaneF* light = nullptr) const;

  // Derivatives of the render, exact to rounding, of every engine, without full_band_integration (InputError
  // otherwise). `junction_absorbance` of maps and results has as many planes as that of `maps`.
  //
  // The change of the reflectance, one plane a band, under a change of the maps: the product with the
  // Jacobian. Planes of `change` may be empty: no change.
  std::vector<PlaneF> Tangent(const ParameterMaps& maps, const ParameterMaps& change,
                              std::span<const PlaneF> light = {}) const;
  // The same for several changes of the same maps: the render is done once and all of it kept, in every band.
  // Borrows model and maps.
  class Kept {
   public:
    Kept(const ForwardModel& model, const ParameterMaps& maps);
    ~Kept();
    std::vector<PlaneF> Tangent(const ParameterMaps& change) const;

   private:
    const ForwardModel& model_;
    const ParameterMaps& maps_;
    std::vector<std::unique_ptr<BandRenderer>> renderers_;  // [band]
  };
  // The derivatives by the maps of the sum over bands and pixels of weights * reflectance: the product with
  // the Jacobian's transpose. `weigh` is told every band's reflectance once it is rendered, in any order and
  // from several threads, and gives the band's weights.
  using WeighFunction = std::function<PlaneF(int band, const PlaneF& reflectance)>;
  ParameterMaps Transpose(const ParameterMaps& maps, const WeighFunction& weigh,
                          std::span<const PlaneF> light = {}) const;

  // Reflectance of uniform skin under wide light in this geometry (closed form, no lateral transport),
  // filter's width included; the gradient is by the five parameters.
  double LocalReflectance(int band, const ParameterVector& p, double junction_absorbance) const;
  double LocalReflectance(int band, const ParameterVector& p, double junction_absorbance,
                          ParameterVector& gradient) const;

  // Derivatives of the logarithm of that reflectance at the band's centre alone, several times cheaper: a
  // filter's width changes reflectance by some percent, but hardly how it answers to absorption.
  LogSensitivity LocalSensitivity(int band, const ParameterVector& p, double junction_absorbance) const;

 private:
  struct Impl;
  explicit ForwardModel(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// What a reflectance factor seen at 30 degrees is to the hemispherical reflectance, for light that is diffuse
// inside: (1 - F(30)) / (2 int_0^1 (1 - F(mu)) mu dmu), F Fresnel's reflectance from outside.
double ExitAngleFactor(Geometry geometry, double n_outside, double n_skin);

}  // namespace dermap
