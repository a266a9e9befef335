// SPDX-License-Identifier: Apache-2.0
// The patch near its present maps as a linear model, octave by octave of detail: which change of the maps the
// data ask for, how sure each parameter then is, and how much detail there really is.
//
// Maps are taken as a mean plus details of every octave (fit/octaves.h). What is known before the data is how
// much detail a parameter has in each octave: a Gaussian prior whose variances (DetailPrior) are not assumed
// but estimated from the data themselves (empirical Bayes). So what the data cannot tell apart from noise, or
// what skin's blur hides, is not followed, and a parameter that does not vary in a scene becomes one number
// for all of it. In each octave a pixel answers by itself, with the Jacobian of uniform skin times the share
// of detail that the blur leaves (fit/blur_share.h): a few unknowns at a time, and no render.
#pragma once

#include <span>
#include <vector>

#include "fit/blur_share.h"
#include "fit/octaves.h"
#include "fit/patch_problem.h"

namespace dermap {

// Variance of a pixel's detail, scaled units, [octave][free parameter]; of the last octave, a single pixel,
// of the mean's distance from average skin.
using DetailPrior = std::vector<FreeVector>;

inline constexpr double kFirstDetailSigma = 0.25;  // scaled units: before there is an estimate
DetailPrior FirstPrior(int octaves);

struct OctaveStep {
  std::vector<PlaneF> change;    // of each free parameter, scaled units
  std::vector<PlaneF> variance;  // of each free parameter once the step is taken, scaled units
  DetailPrior next_prior;        // variances that the details after the step tell
  std::vector<double> next_scatter;  // [octave], of the residuals over the stated noise, variances, at least 1
  double adapted_parameters = 0.0;  // that the data decide: degrees of freedom of the fitted model
  double prior_misfit = 0.0;        // of the details before the step: sum of squares over variances
  double move = 0.0;                // rms of the change in standard deviations
};

class OctaveModel {
 public:
  // Borrows both; blur[0] belongs to the problem's own pixels.
  OctaveModel(const PatchProblem& problem, std::span<const std::vector<BlurCurve>> blur,
              const ParameterVector& fixed);
  int octaves() const { return static_cast<int>(levels_.size()); }
  // Takes residuals and derivatives at a state.
  void Linearise(const FitState& state);
  // prior[0] belongs to the problem's own pixels.
  OctaveStep Solve(std::span<const FreeVector> prior, std::span<const double> scatter) const;
  // state.maps changed by the step, within bounds.
  ParameterMaps Apply(const ParameterMaps& maps, const OctaveStep& step) const;

 private:
  struct Level {
    GridShape shape;
    double noise_inflation = 1.0;  // of a mean's variance, by the correlation of neighbours
    std::vector<PlaneF> residual;  // [band], of the logarithm; weighted means
    std::vector<PlaneF> weight;    // [band], 1 / variance of that
    std::vector<PlaneF> epidermis, dermis, junction;  // [band], LogSensitivity
    std::vector<PlaneF> position, detail;             // [free parameter], scaled units
  };
  struct Solution;
  struct Row;
  using Rows = std::vector<Row>;
  void Sense(const FitState& state, Level& level) const;
  static void Coarsen(const Level& fine, Level& coarse);
  template <class Body>
  static void ForEachPixel(GridShape shape, int bands, const Body& body);
  void FillRows(int index, std::size_t pixel, std::span<Row> rows) const;
  // `answered` is what coarser changes do to the logarithms, [band]; this level's is added.
  Solution SolveLevel(int index, const FreeVector& prior, double scatter, const std::vector<PlaneF>& moved,
                      std::vector<PlaneF>& answered, std::vector<PlaneF>& unblurred) const;

  const PatchProblem& problem_;
  std::span<const std::vector<BlurCurve>> blur_;
  ParameterVector fixed_;
  std::vector<Absorbers> absorbers_;  // [band]
  std::vector<Level> levels_;
};

}  // namespace dermap
