// SPDX-License-Identifier: Apache-2.0
// Bilinear samples of each lattice, combined by inverse variance; planes where a lattice holds several
// colours.
#include "calibrate/resampler.h"

#include <Eigen/Dense>
#include <array>

namespace dermap {
namespace {

constexpr double kFewestSamples = 0.5;  // share of a pixel's samples that must exist
constexpr double kSampleStep_px = 1.5;  // photosites; a bilinear sample reaches two to either side
constexpr double kPlaneReach_px = 3.5;  // X-Trans: every colour lies within it several times

}  // namespace

Resampler::Resampler(const PatchSource& source, int patch_px, bool draft)
    : mosaic_(*source.mosaic), noise_(*source.noise), patch_px_(patch_px) {
  const auto count = static_cast<std::size_t>(patch_px + 1);
  corners_.reserve(count * count);
  for (int y = 0; y <= patch_px; ++y) {
    for (int x = 0; x <= patch_px; ++x) {
      const Point unit{double(x) / patch_px, double(y) / patch_px};
      corners_.push_back(mosaic_.lens.PhotositesFromIdeal(source.map(unit)));
    }
  }
  if (draft) return;
  const auto side = [&](std::size_t from, std::size_t to) {
    return std::hypot(corners_[to].x - corners_[from].x, corners_[to].y - corners_[from].y);
  };
  const double longest = std::max(side(0, count - 1), side(count - 1, count * count - 1));
  samples_ =
      std::max(2, static_cast<int>(std::ceil(longest / patch_px / kSampleStep_px)));  // 2 as in [D08 7.2]
}

void Resampler::Pixel(int px, int py, PixelWeights& out) const {
  StartBox(px, py, out);
  int used = 0;
  double skin_sum = 0.0;
  for (int j = 0; j < samples_; ++j) {
    for (int i = 0; i < samples_; ++i) {
      double value = 0.0;
      if (!Sample(SamplePoint(px, py, i, j), out, value)) continue;
      skin_sum += value;
      ++used;
    }
  }
  out.valid = used > 0 && used >= kFewestSamples * samples_ * samples_;
  if (!out.valid) return;
  out.value = skin_sum / used;
  for (double& c : out.coefficients) c *= 1.0 / used;
}

Point Resampler::SamplePoint(int px, int py, int i, int j) const {
  const double fx = (i + 0.5) / samples_, fy = (j + 0.5) / samples_;
  const Point* top = &corners_[static_cast<std::size_t>(py) * (patch_px_ + 1) + px];
  const Point* bottom = top + patch_px_ + 1;
  const auto between = [&](double a, double b, double c, double d) {
    return (1 - fy) * ((1 - fx) * a + fx * b) + fy * ((1 - fx) * c + fx * d);
  };
  return {between(top[0].x, top[1].x, bottom[0].x, bottom[1].x),
          between(top[0].y, top[1].y, bottom[0].y, bottom[1].y)};
}

void Resampler::StartBox(int px, int py, PixelWeights& out) const {
  double left = 1e30, top = 1e30, right = -1e30, bottom = -1e30;
  for (const int i : {0, samples_ - 1}) {
    for (const int j : {0, samples_ - 1}) {
      const Point p = SamplePoint(px, py, i, j);
      left = std::min(left, p.x), right = std::max(right, p.x);
      top = std::min(top, p.y), bottom = std::max(bottom, p.y);
    }
  }
  const auto clip = [](double v, int limit) { return static_cast<int>(std::clamp(v, 0.0, double(limit))); };
  out.Clear(clip(std::floor(left) - mosaic_.x0 - 4, mosaic_.width()),
            clip(std::floor(top) - mosaic_.y0 - 4, mosaic_.height()),
            clip(std::floor(right) - mosaic_.x0 + 5, mosaic_.width()),
            clip(std::floor(bottom) - mosaic_.y0 + 5, mosaic_.height()));
}

bool Resampler::SamplePlane(Point p, PixelWeights& out, double& value) const {
  const double cx = p.x - mosaic_.x0, cy = p.y - mosaic_.y0;
  const int x0 = std::max({0, out.x0, static_cast<int>(std::floor(cx - kPlaneReach_px))});
  const int y0 = std::max({0, out.y0, static_cast<int>(std::floor(cy - kPlaneReach_px))});
  const int x1 = std::min({mosaic_.width(), out.x0 + out.width, static_cast<int>(cx + kPlaneReach_px) + 1});
  const int y1 = std::min({mosaic_.height(), out.y0 + out.height, static_cast<int>(cy + kPlaneReach_px) + 1});
  const auto weight_of = [&](int x, int y, double dx, double dy) {
    const double r2 = (dx * dx + dy * dy) / (kPlaneReach_px * kPlaneReach_px);
    const bool usable = r2 < 1.0 && noise_.signals(x, y).spectralon > 0.0f;
    return usable ? noise_.signals(x, y).weight * (1.0 - r2) * (1.0 - r2) : 0.0;
  };
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const Eigen::Vector3d row(1.0, x + 0.5 - cx, y + 0.5 - cy);
      normal += weight_of(x, y, row(1), row(2)) * row * row.transpose();
    }
  }
  if (!(normal.determinant() > 1e-6 * std::pow(normal(0, 0), 3))) return false;
  const Eigen::Vector3d first = normal.ldlt().solve(Eigen::Vector3d(1.0, 0.0, 0.0));
  value = 0.0;
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const Eigen::Vector3d row(1.0, x + 0.5 - cx, y + 0.5 - cy);
      const double share = weight_of(x, y, row(1), row(2)) * first.dot(row);
      if (share == 0.0) continue;
      const PhotositeSignal& own = noise_.signals(x, y);
      value += share * mosaic_.scale * own.skin / own.spectralon;
      out.At(x, y) += share * mosaic_.scale / own.smooth;
    }
  }
  return true;
}

bool Resampler::SampleLattices(Point p, PixelWeights& out, double& value) const {
  struct Lattice {
    int x, y;  // of the cell; copied one by one, since a copy of the whole waits for its parts
    std::array<double, 4> b;
    PhotositeSignal sum;
  };
  std::array<Lattice, kLatticeCount> lattices;
  double total = 0.0;
  for (int l = 0; l < kLatticeCount; ++l) {
    Lattice& lattice = lattices[l];
    const LatticeCell c = CellAt(mosaic_, l, p);
    lattice.sum = {};
    if (!c.inside) continue;
    lattice.x = c.x, lattice.y = c.y;
    lattice.b = {(1 - c.fx) * (1 - c.fy), c.fx * (1 - c.fy), (1 - c.fx) * c.fy, c.fx * c.fy};
    const PhotositeSignal* top = noise_.signals.Row(c.y) + c.x;
    const PhotositeSignal* bottom = noise_.signals.Row(c.y + 2) + c.x;
    bool usable = true;
    for (int i = 0; i < 4; ++i) {
      const PhotositeSignal& one = (i < 2 ? top : bottom)[2 * (i & 1)];
      const auto b = static_cast<float>(lattice.b[i]);
      usable &= one.weight > 0.0f || lattice.b[i] < 1e-9;
      lattice.sum.skin += b * one.skin;
      lattice.sum.spectralon += b * one.spectralon;
      lattice.sum.smooth += b * one.smooth;
      lattice.sum.weight += b * one.weight;
    }
    if (!usable || !(lattice.sum.spectralon > 0.0f)) lattice.sum.weight = 0.0f;
    total += lattice.sum.weight;
  }
  if (!(total > 0.0)) return false;
  value = 0.0;
  for (const Lattice& lattice : lattices) {
    if (lattice.sum.weight == 0.0f) continue;
    const double share = mosaic_.scale * lattice.sum.weight / total;
    value += share * lattice.sum.skin / lattice.sum.spectralon;
    const double each = share / lattice.sum.smooth;
    double* at = &out.At(lattice.x, lattice.y);
    at[0] += each * lattice.b[0];
    at[2] += each * lattice.b[1];
    at[2 * out.width] += each * lattice.b[2];
    at[2 * out.width + 2] += each * lattice.b[3];
  }
  return true;
}

}  // namespace dermap
