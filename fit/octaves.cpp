// SPDX-License-Identifier: Apache-2.0
// Halving and doubling.
#include "fit/octaves.h"

#include <algorithm>

namespace dermap {
namespace {

PlaneF Halved(const PlaneF& fine, bool mean) {
  const int width = (fine.width() + 1) / 2, height = (fine.height() + 1) / 2;
  PlaneF coarse(width, height);
  for (int y = 0; y < height; ++y) {
    const bool two_rows = 2 * y + 1 < fine.height();
    const float* upper = fine.Row(2 * y);
    const float* lower = two_rows ? fine.Row(2 * y + 1) : upper;
    const float rows = two_rows || mean ? 1.0f : 0.5f;  // a row that stands for itself twice
    float* out = coarse.Row(y);
    for (int x = 0; x < fine.width() / 2; ++x)
      out[x] = rows * (upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1]);
    if (fine.width() % 2 != 0) {
      const int last = fine.width() - 1;
      out[width - 1] = rows * (mean ? 2.0f : 1.0f) * (upper[last] + lower[last]);
    }
    if (mean)
      for (int x = 0; x < width; ++x) out[x] *= 0.25f;
  }
  return coarse;
}

// Factors that solve for the values between which linear interpolation has given means, along a line of
// `count` pixels that becomes `fine_count` long: rows (1/8, 3/4, 1/8), with what lies beyond an end counted
// to the end; the last pixel of an odd length is half as long, (1/4, 3/4).
struct MeanSolver {
  std::vector<float> lower, pivot, upper;  // a_i / pivot_{i-1}, 1 / pivot_i, c_i

  MeanSolver(int count, int fine_count) : lower(count), pivot(count), upper(count) {
    for (int i = 0; i < count; ++i) {
      const bool first = i == 0, last = i + 1 == count, half = last && fine_count % 2 != 0;
      if (count == 1) {
        pivot[i] = 1.0f;
        continue;
      }
      const float below = first ? 0.0f : half ? 0.25f : 0.125f;
      const float middle = half || (!first && !last) ? 0.75f : 0.875f;
      upper[i] = last ? 0.0f : 0.125f;
      lower[i] = first ? 0.0f : below * pivot[i - 1];
      pivot[i] = 1.0f / (middle - lower[i] * (first ? 0.0f : upper[i - 1]));
    }
  }
};

// The transposed system along both axes: the factors in the other order.
void SolveTransposed(PlaneF& plane, const MeanSolver& along_x, const MeanSolver& along_y) {
  const int width = plane.width(), height = plane.height();
  for (int y = 0; y < height; ++y) {
    float* row = plane.Row(y);
    row[0] *= along_x.pivot[0];
    for (int x = 1; x < width; ++x) row[x] = (row[x] - along_x.upper[x - 1] * row[x - 1]) * along_x.pivot[x];
    for (int x = width - 2; x >= 0; --x) row[x] -= along_x.lower[x + 1] * row[x + 1];
  }
  for (int x = 0; x < width; ++x) plane(x, 0) *= along_y.pivot[0];
  for (int y = 1; y < height; ++y)
    for (int x = 0; x < width; ++x)
      plane(x, y) = (plane(x, y) - along_y.upper[y - 1] * plane(x, y - 1)) * along_y.pivot[y];
  for (int y = height - 2; y >= 0; --y)
    for (int x = 0; x < width; ++x) plane(x, y) -= along_y.lower[y + 1] * plane(x, y + 1);
}

void SolveAlongX(PlaneF& plane, const MeanSolver& solver) {
  const int n = plane.width();
  for (int y = 0; y < plane.height(); ++y) {
    float* row = plane.Row(y);
    for (int x = 1; x < n; ++x) row[x] -= solver.lower[x] * row[x - 1];
    row[n - 1] *= solver.pivot[n - 1];
    for (int x = n - 2; x >= 0; --x) row[x] = (row[x] - solver.upper[x] * row[x + 1]) * solver.pivot[x];
  }
}

void SolveAlongY(PlaneF& plane, const MeanSolver& solver) {
  const int n = plane.height(), width = plane.width();
  for (int y = 1; y < n; ++y)
    for (int x = 0; x < width; ++x) plane(x, y) -= solver.lower[y] * plane(x, y - 1);
  for (int x = 0; x < width; ++x) plane(x, n - 1) *= solver.pivot[n - 1];
  for (int y = n - 2; y >= 0; --y)
    for (int x = 0; x < width; ++x)
      plane(x, y) = (plane(x, y) - solver.upper[y] * plane(x, y + 1)) * solver.pivot[y];
}

// One row of `coarse` at twice as many pixels.
void DoubleRow(const float* coarse, int coarse_width, int width, float* out) {
  for (int x = 0; x < width; ++x) {
    const int near = x / 2;
    const int far = std::clamp(x % 2 == 0 ? near - 1 : near + 1, 0, coarse_width - 1);
    out[x] = 0.75f * coarse[near] + 0.25f * coarse[far];
  }
}

}  // namespace

std::vector<GridShape> OctaveShapes(int width, int height) {
  std::vector<GridShape> shapes{{width, height}};
  while (shapes.back().size() > 1)
    shapes.push_back({(shapes.back().width + 1) / 2, (shapes.back().height + 1) / 2});
  return shapes;
}

PlaneF Halve(const PlaneF& fine) {
  return Halved(fine, true);
}

PlaneF HalveSum(const PlaneF& fine) {
  return Halved(fine, false);
}

PlaneF Double(const PlaneF& means, GridShape fine) {
  PlaneF coarse = means;
  SolveAlongX(coarse, MeanSolver(coarse.width(), fine.width));
  SolveAlongY(coarse, MeanSolver(coarse.height(), fine.height));
  return Interpolate(coarse, fine);
}

PlaneF Interpolate(const PlaneF& coarse, GridShape fine) {
  PlaneF out(fine.width, fine.height);
  std::vector<float> near_row(fine.width), far_row(fine.width);
  for (int y = 0; y < fine.height; ++y) {
    const int near = y / 2;
    const int far = std::clamp(y % 2 == 0 ? near - 1 : near + 1, 0, coarse.height() - 1);
    DoubleRow(coarse.Row(near), coarse.width(), fine.width, near_row.data());
    DoubleRow(coarse.Row(far), coarse.width(), fine.width, far_row.data());
    float* row = out.Row(y);
    for (int x = 0; x < fine.width; ++x) row[x] = 0.75f * near_row[x] + 0.25f * far_row[x];
  }
  return out;
}

PlaneF HalveTransposed(const PlaneF& coarse, GridShape fine) {
  PlaneF out(fine.width, fine.height);
  for (int y = 0; y < fine.height; ++y)
    for (int x = 0; x < fine.width; ++x) {
      const bool lone_x = x % 2 == 0 && x + 1 == fine.width, lone_y = y % 2 == 0 && y + 1 == fine.height;
      out(x, y) = coarse(x / 2, y / 2) * (lone_x ? 1.0f : 0.5f) * (lone_y ? 1.0f : 0.5f);
    }
  return out;
}

PlaneF DoubleTransposed(const PlaneF& fine) {
  const int width = (fine.width() + 1) / 2, height = (fine.height() + 1) / 2;
  PlaneF out(width, height);
  for (int y = 0; y < fine.height(); ++y) {
    const int near_y = y / 2, far_y = std::clamp(y % 2 == 0 ? near_y - 1 : near_y + 1, 0, height - 1);
    for (int x = 0; x < fine.width(); ++x) {
      const int near_x = x / 2, far_x = std::clamp(x % 2 == 0 ? near_x - 1 : near_x + 1, 0, width - 1);
      const float value = fine(x, y);
      out(near_x, near_y) += 0.5625f * value;
      out(far_x, near_y) += 0.1875f * value;
      out(near_x, far_y) += 0.1875f * value;
      out(far_x, far_y) += 0.0625f * value;
    }
  }
  SolveTransposed(out, MeanSolver(width, fine.width()), MeanSolver(height, fine.height()));
  return out;
}

PlaneF DetailTransposed(const PlaneF& plane) {
  const PlaneF means = HalveTransposed(DoubleTransposed(plane), {plane.width(), plane.height()});
  PlaneF out = plane;
  for (std::size_t i = 0; i < out.size(); ++i) out.data()[i] -= means.data()[i];
  return out;
}

PlaneF DetailOf(const PlaneF& plane) {
  PlaneF detail = Double(Halve(plane), {plane.width(), plane.height()});
  for (std::size_t i = 0; i < plane.size(); ++i) detail.data()[i] = plane.data()[i] - detail.data()[i];
  return detail;
}

}  // namespace dermap
