// SPDX-License-Identifier: Apache-2.0
// Differences of Gaussians, tape and missing pixels kept out.
#include "calibrate/alignment_structure.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "calibrate/statistics.h"

namespace dermap {
namespace {

// Along the border: darkened by the tape's edge, kept out of the smoothing too.
constexpr int kTapeBlur_px = 6;
// What is smoother than this (0.23 mm) is light and shape, not structure: light spreads as far as that, in
// each band by another length, and a freckle's halo then seems to lie elsewhere.
constexpr double kCoarse_px = 8.0;
constexpr double kDarkest = 0.003;

cv::Mat View(PlaneF& plane) {
  return {plane.height(), plane.width(), CV_32F, plane.data()};
}
// OpenCV has no view of what must not be changed.
cv::Mat View(const PlaneF& plane) {
  return View(const_cast<PlaneF&>(plane));
}

PlaneF NormalisedBlur(const PlaneF& values, const PlaneF& weights, double sigma) {
  PlaneF out(values.width(), values.height());
  cv::Mat sum, norm;
  cv::GaussianBlur(View(values).mul(View(weights)), sum, {}, sigma, sigma, cv::BORDER_REFLECT);
  cv::GaussianBlur(View(weights), norm, {}, sigma, sigma, cv::BORDER_REFLECT);
  View(out) = sum / (norm + 1e-6);
  return out;
}

}  // namespace

Structure StructureOf(const PlaneF& reflectance, const PlaneF& noise, int border_px) {
  const int width = reflectance.width(), height = reflectance.height();
  Structure s{PlaneF(width, height), Plane<std::uint8_t>(width, height, 0), 0.0};
  PlaneF log_r(width, height), weights(width, height);
  std::vector<float> relative;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float r = reflectance(x, y);
      if (!std::isfinite(r)) continue;
      log_r(x, y) = static_cast<float>(std::log(std::max(static_cast<double>(r), kDarkest)));
      const int edge = std::min({x, y, width - 1 - x, height - 1 - y});
      if (edge >= kTapeBlur_px) weights(x, y) = 1.0f;
      if (edge < border_px) continue;
      s.mask(x, y) = 255;
      if (std::isfinite(noise(x, y)) && r > 0.0f) relative.push_back(noise(x, y) / r);
    }
  }
  const PlaneF fine = NormalisedBlur(log_r, weights, kStructureSmooth_px);
  const PlaneF coarse = NormalisedBlur(log_r, weights, kCoarse_px);
  cv::Mat picture = View(s.picture);
  picture = View(fine) - View(coarse);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(picture, mean, deviation, cv::Mat(height, width, CV_8U, s.mask.data()));
  if (!(deviation[0] > 0.0) || relative.empty()) return s;
  picture = (picture - mean[0]) / deviation[0];
  // Resampled noise is about 0.7 px wide (standard deviation) already; smoothing by 1 px leaves a third of
  // its variance.
  const double left = 0.5 / (0.5 + kStructureSmooth_px * kStructureSmooth_px);
  const double noise_variance = left * std::pow(Median(relative), 2);
  s.weight = std::max(0.0, 1.0 - noise_variance / (deviation[0] * deviation[0]));
  return s;
}

PlaneF Smoothed(const PlaneF& picture, double sigma_px) {
  PlaneF out(picture.width(), picture.height());
  cv::Mat view = View(out);
  cv::GaussianBlur(View(picture), view, {}, sigma_px);
  return out;
}

Point UnitOf(int x, int y, const PlaneF& picture) {
  return {(x + 0.5) / picture.width(), (y + 0.5) / picture.height()};
}

PlaneF Moved(const PlaneF& picture, const Warp& warp) {
  PlaneF map_x(picture.width(), picture.height()), map_y(picture.width(), picture.height());
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const Point d = warp.At(UnitOf(x, y, picture));
      map_x(x, y) = static_cast<float>(x + d.x);
      map_y(x, y) = static_cast<float>(y + d.y);
    }
  }
  PlaneF out(picture.width(), picture.height());
  cv::Mat view = View(out);
  cv::remap(View(picture), view, View(map_x), View(map_y), cv::INTER_CUBIC, cv::BORDER_REFLECT);
  return out;
}

PlaneF MeanOfOthers(std::span<const Structure> structures, std::span<const PlaneF> moved, std::size_t self) {
  PlaneF sum(structures[self].picture.width(), structures[self].picture.height());
  double total = 0.0;
  for (std::size_t i = 0; i < structures.size(); ++i) {
    if (i == self || structures[i].weight <= 0.0) continue;
    View(sum) += structures[i].weight * View(moved[i]);
    total += structures[i].weight;
  }
  if (!(total > 0.0)) return {};
  View(sum) /= total;
  return sum;
}

}  // namespace dermap
