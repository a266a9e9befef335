// SPDX-License-Identifier: Apache-2.0
// Projective maps on OpenCV's small matrices.
#include "calibrate/homography.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace dermap {

Homography Homography::After(const Homography& first) const {
  Homography out;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      double sum = 0.0;
      for (int k = 0; k < 3; ++k) sum += m[3 * i + k] * first.m[3 * k + j];
      out.m[3 * i + j] = sum;
    }
  }
  return out;
}

Homography Homography::Inverse() const {
  const cv::Matx33d inverse = cv::Matx33d(m.data()).inv();
  Homography out;
  std::copy_n(inverse.val, 9, out.m.begin());
  return out;
}

Homography CameraFromUnit(const std::array<Point, 4>& corners) {
  const std::array<cv::Point2f, 4> unit{cv::Point2f(0, 0), {1, 0}, {1, 1}, {0, 1}};
  std::array<cv::Point2f, 4> camera;
  // Single precision goes in: relative to the first corner it is good to 1e-4 photosites at any sensor's
  // size.
  for (int i = 0; i < 4; ++i) {
    camera[i] = {static_cast<float>(corners[i].x - corners[0].x),
                 static_cast<float>(corners[i].y - corners[0].y)};
  }
  const cv::Matx33d solved = cv::getPerspectiveTransform(unit.data(), camera.data());
  Homography out;
  std::copy_n(solved.val, 9, out.m.begin());
  const Homography shift{{1, 0, corners[0].x, 0, 1, corners[0].y, 0, 0, 1}};
  return shift.After(out);
}

Homography UnitMotion(double dx, double dy, double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  return {{c, -s, 0.5 - 0.5 * c + 0.5 * s + dx, s, c, 0.5 - 0.5 * s - 0.5 * c + dy, 0, 0, 1}};
}

}  // namespace dermap
