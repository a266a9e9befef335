// SPDX-License-Identifier: Apache-2.0
// Responses as sums over the lengths of light's paths: absorption acts on scattering paths as a Laplace
// transform, P(mu_a; k) = int p(L; k) exp(-mu_a L) dL, so over a scene's own range of absorption a few
// lengths do,
//   P(mu_a; k) = sum_j p_j(k) exp(-mu_a L_j).
// Unlike weights of Gaussians this separates what light meets on its way, exp(-mu_a L), from how it spreads,
// so it also tells what becomes of light whose path begins in skin of one absorption and ends in another.
#pragma once

#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace dermap {

// The transforms of one response at every absorption of the tables (TableMuA) and every frequency
// (TableFrequencies_per_mm).
class TransformTable {
 public:
  TransformTable() = default;
  // values[entry * frequencies + frequency]
  explicit TransformTable(std::vector<float> values) : values_(std::move(values)) {}

  bool empty() const noexcept { return values_.empty(); }
  const std::vector<float>& values() const noexcept { return values_; }
  // All frequencies at one absorption, 1/mm, by cubics in its logarithm; clamped to the tables' range.
  std::vector<double> At(double mu_a) const;
  double At(double mu_a, std::size_t frequency) const;  // one of them

 private:
  std::vector<float> values_;
};

// The responses of a layer over a scene's own range of absorption, by as few path lengths as the scene needs.
struct ScenePaths {
  std::vector<double> lengths_mm;
  // [response][path][frequency]; a path length's kernel may be negative, their sum is not beyond `error`.
  std::vector<std::vector<std::vector<float>>> kernels;
  double error = 0.0;  // largest, of a transform as it counts

  int count() const { return static_cast<int>(lengths_mm.size()); }
};
// One response by given path lengths, and the largest error at each frequency, relative as above.
struct PathFit {
  std::vector<std::vector<float>> kernels;  // [path][frequency]
  std::vector<double> errors;               // [frequency]
};
PathFit FitPaths(const TransformTable& response, std::span<const double> lengths_mm, double lowest,
                 double highest);

// How much an error of a response at some mu_a counts; where none is given, relative to the response's total
// (or to 1e-4, if that is more).
using ErrorWeight = std::function<double(std::size_t response, double mu_a)>;

// Between mu_a `lowest` and `highest` (1/mm): as few lengths as have an error of at most `tolerance`, or,
// where none has, the best of up to kMostPaths. `count`: exactly so many instead, 1 to kMostPaths.
inline constexpr int kMostPaths = 16;
ScenePaths ReducePaths(std::span<const TransformTable* const> responses, double lowest, double highest,
                       double tolerance, int count = 0, const ErrorWeight& weight = {});

}  // namespace dermap
