// SPDX-License-Identifier: Apache-2.0
// Moments of fits, and what they say of the next one.
#include "fit/learnt_prior.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <span>

#include "common/core/error.h"
#include "common/files/atomic_file.h"

namespace dermap {
namespace {

// Variance of a parameter of which only the range is known.
double RangeVariance(Parameter p) {
  const double range = InfoOf(p).upper - InfoOf(p).lower;
  return range * range / 12.0;
}

bool Holds(const std::vector<Parameter>& list, Parameter p) {
  return std::find(list.begin(), list.end(), p) != list.end();
}

std::string FingerprintOf(const FitResult& fit) {
  std::vector<float> values;
  for (const PlaneF& plane : fit.measured)
    values.insert(values.end(), plane.values().begin(), plane.values().end());
  return Sha256(std::as_bytes(std::span(values)));
}

// Pixels whose maps were fitted and explain the data.
std::vector<std::size_t> Teachers(const FitResult& fit) {
  std::vector<std::size_t> pixels;
  for (std::size_t i = 0; i < fit.flags.size(); ++i)
    if (!(fit.flags.data()[i] & (kFlagSaturated | kFlagNotConverged))) pixels.push_back(i);
  return pixels;
}

void CheckTeaches(const FitResult& fit, const std::string& name, std::size_t pixels) {
  const std::string what = "A prior cannot be learnt from the fit of " + name + ": ";
  if (static_cast<int>(fit.bands.size()) < kTeachingBands)
    throw InputError(what + "it has " + std::to_string(fit.bands.size()) + " bands, but needs at least " +
                     std::to_string(kTeachingBands) + " to find all of table 1; leave out --save-prior.");
  if (fit.method == "descent")
    throw InputError(what +
                     "method descent takes noise for detail; use --method fast or leave out --save-prior.");
  if (!fit.converged || pixels == 0) throw InputError(what + "it did not converge; leave out --save-prior.");
}

ParameterMatrix Weighted(const ParameterMatrix& a, double weight_a, const ParameterMatrix& b,
                         double weight_b) {
  ParameterMatrix sum;
  for (int j = 0; j < kParameterCount; ++j)
    for (int k = 0; k < kParameterCount; ++k) sum[j][k] = weight_a * a[j][k] + weight_b * b[j][k];
  return sum;
}

// The matrix of the free parameters in scaled units, `weight` of it and `more` on the diagonal; inverted.
struct ScaledMatrix {
  FreeMatrix inverse{};
  FreeVector diagonal{};
};
ScaledMatrix Scaled(const ParameterMatrix& matrix, double weight, const FreeVector& more,
                    const ParameterSpace& space) {
  const int count = space.count();
  Eigen::MatrixXd scaled = Eigen::MatrixXd::Zero(count, count);
  ScaledMatrix out;
  for (int j = 0; j < count; ++j) {
    const int p = static_cast<int>(space.parameter(j));
    for (int k = 0; k < count; ++k) {
      const int q = static_cast<int>(space.parameter(k));
      if (p < kParameterCount && q < kParameterCount)
        scaled(j, k) = weight * matrix[p][q] / (space.scale(j) * space.scale(k));
    }
    scaled(j, j) += more[j];
    out.diagonal[j] = scaled(j, j);
  }
  const Eigen::MatrixXd inverse = scaled.llt().solve(Eigen::MatrixXd::Identity(count, count));
  for (int j = 0; j < count; ++j)
    for (int k = 0; k < count; ++k) out.inverse[j][k] = 0.5 * (inverse(j, k) + inverse(k, j));
  return out;
}

}  // namespace

LearntPrior LearnFrom(const FitResult& fit, const std::string& name) {
  const std::vector<std::size_t> pixels = Teachers(fit);
  CheckTeaches(fit, name, pixels.size());
  const double share = 1.0 / static_cast<double>(pixels.size());
  LearntPrior prior;
  prior.sources = {{name, FingerprintOf(fit)}};
  for (int j = 0; j < kParameterCount; ++j)
    for (const std::size_t i : pixels) prior.mean[j] += share * fit.maps.planes[j].data()[i];
  const std::vector<Parameter> absent =
      fit.candidates.empty() ? std::vector<Parameter>{} : fit.candidates.front().absent;
  for (int j = 0; j < kParameterCount; ++j) {
    const auto parameter = static_cast<Parameter>(j);
    if (!Holds(fit.free_parameters, parameter) && !Holds(absent, parameter))
      prior.covariance[j][j] = RangeVariance(parameter);
    for (const std::size_t i : pixels) {
      const double own = fit.maps.planes[j].data()[i] - prior.mean[j], sigma = fit.sigma.planes[j].data()[i];
      prior.detail_covariance[j][j] += share * (own * own + sigma * sigma);
      for (int k = 0; k < j; ++k)
        prior.detail_covariance[j][k] += share * own * (fit.maps.planes[k].data()[i] - prior.mean[k]);
    }
    for (int k = 0; k < j; ++k) prior.detail_covariance[k][j] = prior.detail_covariance[j][k];
  }
  return prior;
}

LearntPrior Combined(const LearntPrior& a, const LearntPrior& b) {
  LearntPrior both;
  both.sources = a.sources;
  for (const PriorSource& source : b.sources) {
    for (const PriorSource& known : a.sources)
      if (known.sha256 == source.sha256)
        throw InputError("The prior already holds the patch of " + source.name + " (as " + known.name +
                         "); a patch counts once: leave out --save-prior, or write another file.");
    both.sources.push_back(source);
  }
  const double of_a = static_cast<double>(a.fits()) / both.fits(), of_b = 1.0 - of_a;
  both.covariance = Weighted(a.covariance, of_a, b.covariance, of_b);
  both.detail_covariance = Weighted(a.detail_covariance, of_a, b.detail_covariance, of_b);
  for (int j = 0; j < kParameterCount; ++j) {
    both.mean[j] = of_a * a.mean[j] + of_b * b.mean[j];
    for (int k = 0; k < kParameterCount; ++k)
      both.covariance[j][k] += of_a * of_b * (a.mean[j] - b.mean[j]) * (a.mean[k] - b.mean[k]);
  }
  return both;
}

LinkedPrior LinkTo(const LearntPrior& prior, const ParameterSpace& space) {
  const double fits = prior.fits();
  FreeVector range{}, guess{};
  for (int j = 0; j < space.count(); ++j) {
    const bool learnt = space.parameter(j) != Parameter::kJunctionAbsorbance;
    range[j] = learnt ? 1.0 / fits : 1.0;  // scaled units: 1 is the range's variance
    guess[j] = kFirstDetailSigma * kFirstDetailSigma * (learnt ? 1.0 / (fits + 1.0) : 1.0);
  }
  // The next patch's mean scatters about the true one, which is known from so many patches only.
  const ScaledMatrix means = Scaled(prior.covariance, (fits + 1.0) / fits, range, space);
  const ScaledMatrix details = Scaled(prior.detail_covariance, fits / (fits + 1.0), guess, space);
  LinkedPrior link{space.mean(), means.inverse, details.diagonal, details.inverse};
  for (int j = 0; j < space.count(); ++j)
    if (const auto p = static_cast<std::size_t>(space.parameter(j)); p < prior.mean.size())
      link.mean[j] = prior.mean[p] / space.scale(j);
  return link;
}

}  // namespace dermap
