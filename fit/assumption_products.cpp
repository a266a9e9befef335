// SPDX-License-Identifier: Apache-2.0
// Sums over data and details.
#include "fit/assumption_products.h"

#include <cmath>
#include <utility>

#include "fit/octave_solver.h"

namespace dermap {
namespace {

// Sum over the data of products of what is left over the noise's variance; that of the patch's mean is the
// top octave's own.
double DataProduct(const std::vector<OctaveLevel>& levels, const DetailView& detail,
                   const std::vector<PlaneF>& u, const std::vector<PlaneF>& v) {
  const OctaveLevel& fine = levels.front();
  const OctaveLevel& mean = levels.back();
  const double noise = fine.noise_inflation * detail.scatter.front();
  double sum = 0.0;
  for (std::size_t b = 0; b < u.size(); ++b) {
    double weights = 0.0, of_u = 0.0, of_v = 0.0, both = 0.0;
    for (std::size_t i = 0; i < u[b].size(); ++i) {
      const double weight = fine.weight[b].data()[i];
      weights += weight;
      of_u += weight * u[b].data()[i];
      of_v += weight * v[b].data()[i];
      both += weight * u[b].data()[i] * v[b].data()[i];
    }
    if (weights <= 0.0) continue;
    const double mean_weight = mean.weight[b].data()[0] / (mean.noise_inflation * detail.scatter.back());
    sum += (both - of_u * of_v / weights) / noise + of_u / weights * of_v / weights * mean_weight;
  }
  return sum;
}

// Sum over the octaves of products of details over their prior variance.
double PriorProduct(const DetailView& detail, PlaneF u, PlaneF v, int j, Parameter p) {
  const std::vector<GridShape> shapes = OctaveShapes(u.width(), u.height());
  double sum = 0.0;
  for (std::size_t l = 0; l < shapes.size(); ++l) {
    const bool top = l + 1 == shapes.size();
    const PlaneF of_u = top ? u : DetailOf(u), of_v = top ? v : DetailOf(v);
    const PlaneF* activity = detail.ActivityOf(l, shapes[l], p);
    double product = 0.0;
    for (std::size_t i = 0; i < of_u.size(); ++i)
      product +=
          static_cast<double>(of_u.data()[i]) * of_v.data()[i] / (activity ? activity->data()[i] : 1.0f);
    sum += (top ? 1.0 : kDetailShare) / detail.prior[l][j] * product;
    if (top) break;
    u = Halve(u);
    v = Halve(v);
  }
  return sum;
}

}  // namespace

double Product(const std::vector<OctaveLevel>& levels, const ParameterSpace& space, const DetailView& detail,
               const Answered& u, const Answered& v) {
  double sum = DataProduct(levels, detail, u.left, v.left);
  for (std::size_t j = 0; j < u.distance.size(); ++j)
    sum += PriorProduct(detail, u.distance[j], v.distance[j], static_cast<int>(j),
                        space.parameter(static_cast<int>(j)));
  return sum;
}

double LogEvidence(double error, double sigma) {
  return 0.5 * std::pow(error / sigma, 2) - std::log(kExpectedError / sigma);
}

}  // namespace dermap
