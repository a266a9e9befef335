// SPDX-License-Identifier: Apache-2.0
// Columns of the Jacobian from tangents, band by band into the normal matrix.
#include "studies/coupled_bound.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "fit/map_steps.h"
#include "fit/parameter_space.h"
#include "fit/scene_choice.h"

namespace dermap {
CoupledInformation::CoupledInformation(const ForwardModel& model, const ParameterMaps& truth,
                                       const std::vector<PlaneF>& noise)
    : width_(truth.width()), height_(truth.height()) {
  const ParameterMaps maps = WithJunction(truth, model.tissue().junction_absorbance);
  const ParameterSpace space(AllUnknowns());
  const int pixels = width_ * height_, unknowns = space.count() * pixels;
  std::vector<Eigen::MatrixXf> jacobian(noise.size(), Eigen::MatrixXf(pixels, unknowns));  // over the noise
  const ForwardModel::Kept kept(model, maps);
  for (int column = 0; column < unknowns; ++column) {
    const std::vector<PlaneF> response = kept.Tangent(
        ChangeOfPixel(space, column / pixels, static_cast<std::size_t>(column % pixels), width_, height_));
    for (std::size_t b = 0; b < response.size(); ++b)
      for (int i = 0; i < pixels; ++i) {
        const float sigma = noise[b].data()[i];
        jacobian[b](i, column) = sigma > 0.0f ? response[b].data()[i] / sigma : 0.0f;
      }
  }
  information_.setZero(unknowns, unknowns);
  for (const Eigen::MatrixXf& band : jacobian)
    information_.selfadjointView<Eigen::Lower>().rankUpdate(band.transpose());
}

std::vector<PlaneF> CoupledInformation::Bound(const std::vector<Parameter>& free) const {
  const ParameterSpace all(AllUnknowns()), space(free);
  const int pixels = width_ * height_;
  std::vector<int> blocks;
  for (int j = 0; j < space.count(); ++j)
    for (int k = 0; k < all.count(); ++k)
      if (all.parameter(k) == space.parameter(j)) blocks.push_back(k);
  Eigen::MatrixXd normal(space.count() * pixels, space.count() * pixels);
  for (int j = 0; j < space.count(); ++j)
    for (int k = 0; k <= j; ++k) {
      const bool lower = blocks[j] >= blocks[k];
      const int row = (lower ? blocks[j] : blocks[k]) * pixels,
                column = (lower ? blocks[k] : blocks[j]) * pixels;
      auto part = normal.block(j * pixels, k * pixels, pixels, pixels);
      part = information_.block(row, column, pixels, pixels).cast<double>();
      if (!lower) part = part.transpose().eval();
    }
  normal.diagonal().array() += 1.0;  // the range alone
  // The inverse's diagonal from the factor: columns of its inverse, squared.
  const Eigen::LLT<Eigen::MatrixXd> factor(normal);
  const Eigen::MatrixXd inverse =
      factor.matrixL().solve(Eigen::MatrixXd::Identity(normal.rows(), normal.rows()));
  std::vector<PlaneF> bound(free.size(), PlaneF(width_, height_));
  for (int j = 0; j < space.count(); ++j)
    for (int i = 0; i < pixels; ++i)
      bound[static_cast<std::size_t>(j)].data()[i] =
          static_cast<float>(space.scale(j) * inverse.col(j * pixels + i).norm());
  return bound;
}

}  // namespace dermap
