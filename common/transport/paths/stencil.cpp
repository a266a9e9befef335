// SPDX-License-Identifier: Apache-2.0
// Design and application of small even kernels.
#include "common/transport/paths/stencil.h"

#include <Eigen/QR>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <mutex>
#include <numbers>

#include "common/core/kernel.h"
#include "common/core/lanes.h"

namespace dermap {
namespace {

constexpr int kBlock = 4 * kLanes;  // outputs that one pass over the taps holds in registers

// out[x] += factor[x] * sum over dy, dx of tap[dy][|dx|] rows[dy][x + dx], for a block of outputs.
DERMAP_KERNEL
void AddBlock(const float* rows, std::ptrdiff_t stride, const float* taps, const int* reach, int radius,
              const float* factor, float* out) noexcept {
  Lanes a{}, b{}, c{}, d{};
  for (int dy = 0; dy <= radius; ++dy) {
    const float* tap = taps + dy * (radius + 1);
    for (int dx = -reach[dy]; dx <= reach[dy]; ++dx) {
      const float t = tap[dx < 0 ? -dx : dx];
      const float* p = rows + dy * stride + dx;
      a += t * DERMAP_LOAD(p);
      b += t * DERMAP_LOAD(p + kLanes);
      c += t * DERMAP_LOAD(p + 2 * kLanes);
      d += t * DERMAP_LOAD(p + 3 * kLanes);
    }
  }
  if (factor) {
    a *= DERMAP_LOAD(factor);
    b *= DERMAP_LOAD(factor + kLanes);
    c *= DERMAP_LOAD(factor + 2 * kLanes);
    d *= DERMAP_LOAD(factor + 3 * kLanes);
  }
  DERMAP_STORE(out, DERMAP_LOAD(out) + a);
  DERMAP_STORE(out + kLanes, DERMAP_LOAD(out + kLanes) + b);
  DERMAP_STORE(out + 2 * kLanes, DERMAP_LOAD(out + 2 * kLanes) + c);
  DERMAP_STORE(out + 3 * kLanes, DERMAP_LOAD(out + 3 * kLanes) + d);
}

DERMAP_KERNEL
void SumOfTwo(const float* a, const float* b, int n, float* __restrict out) noexcept {
  for (int x = 0; x < n; ++x) out[x] = a[x] + b[x];
}

}  // namespace

// Least squares on the transform's side: truncation would move what is cut from middle to all frequencies,
// while pictures have most of their content, and eyes and fits their interest, at low ones.
class StencilDesign {
 public:
  explicit StencilDesign(int radius) : radius_(radius) {
    for (int y = 0; y <= radius; ++y)
      for (int x = 0; x <= y; ++x)
        if (x * x + y * y <= (radius + 0.5) * (radius + 0.5)) taps_.push_back({x, y});
    frequencies_.push_back({0.0, 0.0, kWeightAtZero});
    for (int v = 0; v < kSamples; ++v) {
      for (int u = 0; u <= v; ++u) {
        const double kx = std::numbers::pi * (u + 0.5) / kSamples,
                     ky = std::numbers::pi * (v + 0.5) / kSamples;
        const double area = u == v ? 1.0 : 2.0;
        frequencies_.push_back({kx, ky, std::sqrt(area) / std::pow(kTurn + std::hypot(kx, ky), kFall)});
      }
    }
    Eigen::MatrixXd basis(frequencies_.size(), taps_.size());
    for (std::size_t f = 0; f < frequencies_.size(); ++f)
      for (std::size_t t = 0; t < taps_.size(); ++t)
        basis(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(t)) =
            frequencies_[f].weight * Wave(taps_[t], frequencies_[f]);
    inverse_ = basis.householderQr().solve(Eigen::MatrixXd::Identity(basis.rows(), basis.rows()));
  }

  std::vector<std::vector<float>> Taps(const std::function<double(double kx, double ky)>& transfer) const {
    Eigen::VectorXd target(frequencies_.size());
    for (std::size_t f = 0; f < frequencies_.size(); ++f)
      target[static_cast<Eigen::Index>(f)] =
          frequencies_[f].weight * transfer(frequencies_[f].x, frequencies_[f].y);
    const Eigen::VectorXd solution = inverse_ * target;
    std::vector<std::vector<float>> rows(radius_ + 1);
    for (int y = 0; y <= radius_; ++y) {
      const int reach =
          std::min(radius_, static_cast<int>(std::sqrt((radius_ + 0.5) * (radius_ + 0.5) - y * y)));
      rows[y].resize(reach + 1);
    }
    for (std::size_t t = 0; t < taps_.size(); ++t) {
      const auto [x, y] = taps_[t];
      rows[y][x] = rows[x][y] = static_cast<float>(solution[static_cast<Eigen::Index>(t)]);
    }
    return rows;
  }

 private:
  static constexpr int kSamples = 24;
  static constexpr double kWeightAtZero = 1e3;
  static constexpr double kTurn = 0.1, kFall = 2.0;  // weights fall as (kTurn + k)^-kFall
  struct Tap {
    int x, y;
  };
  struct Frequency {
    double x, y, weight;
  };
  // Sum of the cosines of all taps that share a value.
  static double Wave(const Tap& tap, const Frequency& at) {
    const auto pair = [&](int x, int y) {
      return (x > 0 ? 2.0 : 1.0) * (y > 0 ? 2.0 : 1.0) * std::cos(at.x * x) * std::cos(at.y * y);
    };
    return tap.x == tap.y ? pair(tap.x, tap.y) : pair(tap.x, tap.y) + pair(tap.y, tap.x);
  }

  int radius_;
  std::vector<Tap> taps_;
  std::vector<Frequency> frequencies_;
  Eigen::MatrixXd inverse_;
};

Stencil::Stencil(const std::function<double(double kx, double ky)>& transfer, int radius) {
  static std::mutex mutex;
  static std::map<int, StencilDesign> designs;
  const StencilDesign* design = nullptr;
  {
    const std::lock_guard lock(mutex);
    design = &designs.try_emplace(radius, radius).first->second;
  }
  rows_ = design->Taps(transfer);
}

void StencilRunner::FoldRows(const PlaneF& in, int y, int radius) {
  const int width = in.width(), height = in.height();
  const auto row = [&](int at) {
    if (at >= 0 && at < height) return in.Row(at);
    return border_ == Border::kZero ? zero_row_.data() : in.Row(MirroredIndex(at, height));
  };
  for (int dy = 0; dy <= radius; ++dy) {
    float* out = folded_.data() + dy * stride_;
    float* middle = out + radius;
    if (dy == 0) {
      std::copy_n(row(y), width, middle);
    } else {
      SumOfTwo(row(y - dy), row(y + dy), width, middle);
    }
    for (int x = 1; x <= radius; ++x) {
      const bool zero = border_ == Border::kZero;
      middle[-x] = zero ? 0.0f : middle[MirroredIndex(-x, width)];
      middle[width - 1 + x] = zero ? 0.0f : middle[MirroredIndex(width - 1 + x, width)];
    }
  }
}

void StencilRunner::AddTo(const PlaneF& in, const Stencil& stencil, const PlaneF* factor, PlaneF& sum) {
  assert(in.SameShape(sum));
  const int radius = stencil.radius(), width = in.width();
  stride_ = width + 2 * radius + kBlock;
  folded_.resize(static_cast<std::size_t>(radius + 1) * stride_);
  zero_row_.assign(border_ == Border::kZero ? width : 0, 0.0f);
  float taps[32 * 32] = {};
  int reach[32];
  assert(radius < 32);
  for (int dy = 0; dy <= radius; ++dy) {
    const std::vector<float>& row = stencil.rows()[dy];
    std::copy(row.begin(), row.end(), taps + dy * (radius + 1));
    reach[dy] = static_cast<int>(row.size()) - 1;
  }
  float rest[kBlock], rest_factor[kBlock] = {};
  for (int y = 0; y < in.height(); ++y) {
    FoldRows(in, y, radius);
    const float* rows = folded_.data() + radius;
    float* out = sum.Row(y);
    const float* by = factor ? factor->Row(y) : nullptr;
    int x = 0;
    for (; x + kBlock <= width; x += kBlock)
      AddBlock(rows + x, stride_, taps, reach, radius, by ? by + x : nullptr, out + x);
    if (x == width) continue;
    std::copy_n(out + x, width - x, rest);
    if (by) std::copy_n(by + x, width - x, rest_factor);
    AddBlock(rows + x, stride_, taps, reach, radius, by ? rest_factor : nullptr, rest);
    std::copy_n(rest, width - x, out + x);
  }
}

}  // namespace dermap
