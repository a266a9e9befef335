// SPDX-License-Identifier: Apache-2.0
// Multiresolution sum of Gaussians.
#include "common/transport/pyramid.h"

#include <algorithm>
#include <cmath>

#include "common/core/kernel.h"
#include "common/transport/plane_math.h"

namespace dermap {
namespace {

// An image goes to half size once its variance is this many of the coarser pixels squared: its spectrum at
// their Nyquist frequency is then below 2.5 %, and the next Gaussian takes off as much again.
constexpr double kDecimationVariance_px2 = 0.75;
constexpr int kSplinePad = 2;  // spline coefficients beyond each end of a row

double Sinc(double x) {
  return std::abs(x) < 1e-8 ? 1.0 : std::sin(x) / x;
}

// Transfer function of a cubic B-spline with knots `scale` pixels apart; level 0 has none.
double SplineTransfer(int level, double omega) {
  if (level == 0) return 1.0;
  const double sinc = Sinc(0.5 * omega * (1 << level));
  return sinc * sinc * sinc * sinc;
}

std::array<float, 4> SplineWeights(double t) {
  const double t2 = t * t, t3 = t2 * t;
  return {static_cast<float>((1.0 - 3.0 * t + 3.0 * t2 - t3) / 6.0),
          static_cast<float>((3.0 * t3 - 6.0 * t2 + 4.0) / 6.0),
          static_cast<float>((-3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0) / 6.0), static_cast<float>(t3 / 6.0)};
}

// Where pixel x of full resolution lies among a level's samples, which sit in the middle of 2^level pixels.
double LevelPosition(int x, int scale) {
  return (x + 0.5) / scale - 0.5;
}

DERMAP_KERNEL
void AveragePairs(const float* upper, const float* lower, int n, float* __restrict out) noexcept {
  for (int x = 0; x < n; ++x) {
    out[x] = 0.25f * ((upper[2 * x] + upper[2 * x + 1]) + (lower[2 * x] + lower[2 * x + 1]));
  }
}

// The transpose of AveragePairs, for one of the two rows.
DERMAP_KERNEL
void SpreadPairs(const float* in, int n, float* __restrict out) noexcept {
  for (int x = 0; x < n; ++x) out[2 * x] = out[2 * x + 1] = 0.25f * in[x];
}

DERMAP_KERNEL
void AddScaledRow(const float* in, float factor, int n, float* __restrict out) noexcept {
  for (int x = 0; x < n; ++x) out[x] += factor * in[x];
}

DERMAP_KERNEL
void CombineRows(const float* const* rows, const float* weights, int n, float* __restrict out) noexcept {
  const float *a = rows[0], *b = rows[1], *c = rows[2], *d = rows[3];
  const float wa = weights[0], wb = weights[1], wc = weights[2], wd = weights[3];
  for (int x = 0; x < n; ++x) out[x] = (wa * a[x] + wb * b[x]) + (wc * c[x] + wd * d[x]);
}

// `expanded` repeats every spline coefficient `scale` times, so neighbours are `scale` apart and all loads
// run along x.
DERMAP_KERNEL
void EvaluateSpline(const float* expanded, int scale, const float* w0, const float* w1, const float* w2,
                    const float* w3, int n, float* __restrict out) noexcept {
  for (int x = 0; x < n; ++x) {
    out[x] = (w0[x] * expanded[x] + w1[x] * expanded[x + scale]) +
             (w2[x] * expanded[x + 2 * scale] + w3[x] * expanded[x + 3 * scale]);
  }
}

}  // namespace

PyramidConvolver::PyramidConvolver(const Domain& domain, double pixel_size_mm, Border border)
    : domain_(domain), pixel_size_mm_(pixel_size_mm), border_(border), zero_row_(domain.width, 0.0f) {
  for (int level = 0; level <= domain.levels; ++level) {
    planes_.emplace_back(domain.width >> level, domain.height >> level);
    blurs_.emplace_back(border);
    Upsampler upsampler;
    upsampler.scale = 1 << level;
    for (std::vector<float>& weights : upsampler.along_x) weights.resize(domain.width);
    for (int x = 0; x < domain.width; ++x) {
      const double position = LevelPosition(x, upsampler.scale);
      const std::array<float, 4> weights = SplineWeights(position - std::floor(position));
      for (int k = 0; k < 4; ++k) upsampler.along_x[k][x] = weights[k];
    }
    for (int phase = 0; phase < upsampler.scale; ++phase) {
      const double position = LevelPosition(phase, upsampler.scale);
      upsampler.along_y.push_back(SplineWeights(position - std::floor(position)));
    }
    upsamplers_.push_back(std::move(upsampler));
  }
  const int coarsest = 1 << domain.levels;
  spline_row_.resize(domain.width + 2 * kSplinePad);
  expanded_row_.resize(domain.width + 4 * coarsest);
  full_row_.resize(domain.width);
}

// The level to which an image of Gaussian `last` may go.
int PyramidConvolver::LevelAfter(int level, int last) const {
  if (last < 0) return 0;
  const double variance_px2 = GaussianVariance_px2(last, pixel_size_mm_);
  while (level < domain_.levels &&
         variance_px2 >= kDecimationVariance_px2 * static_cast<double>(1 << (2 * level + 2))) {
    ++level;
  }
  return level;
}

void PyramidConvolver::Descend(int from_level, int to_level) {
  for (int level = from_level; level < to_level; ++level) {
    const PlaneF& fine = planes_[level];
    PlaneF& coarse = planes_[level + 1];
    for (int y = 0; y < coarse.height(); ++y) {
      AveragePairs(fine.Row(2 * y), fine.Row(2 * y + 1), coarse.width(), coarse.Row(y));
    }
  }
}

// The blur, in pixels of `to_level`, that leads from Gaussian `from` on from_level to Gaussian `to` on
// to_level.
const SymmetricKernel& PyramidConvolver::Kernel(int from_level, int from, int to_level, int to) {
  SymmetricKernel& kernel = kernels_[{from_level, from, to_level, to}];
  if (!kernel.empty()) return kernel;
  const double from_px2 = from < 0 ? 0.0 : GaussianVariance_px2(from, pixel_size_mm_);
  const double to_px2 = GaussianVariance_px2(to, pixel_size_mm_);
  if (to_level == 0) {
    kernel = BlurKernel(from_px2, to_px2);
    return kernel;
  }
  const double scale = 1 << to_level;
  const auto transfer = [&](double omega_level) {
    const double omega = omega_level / scale;
    double already = SplineTransfer(to_level, omega) / SplineTransfer(from_level, omega);
    for (int level = from_level; level < to_level; ++level) already *= std::cos(0.5 * omega * (1 << level));
    return std::exp(-0.5 * (to_px2 - from_px2) * omega * omega) / already;
  };
  kernel = KernelFromTransfer(transfer, (to_px2 - from_px2) / (scale * scale));
  return kernel;
}

// Which of a level's rows stands for `row`, which may lie beyond the border; -1: none.
int PyramidConvolver::LevelRow(int row, int height) const {
  if (row >= 0 && row < height) return row;
  return border_ == Border::kMirror ? MirroredIndex(row, height) : -1;
}

const float* PyramidConvolver::UpsampledRow(const PlaneF& plane, const Upsampler& upsampler, int y) {
  const int scale = upsampler.scale, n = plane.width();
  const int base_y = static_cast<int>(std::floor(LevelPosition(y, scale)));
  const float* rows[4];
  for (int k = 0; k < 4; ++k) {
    const int row = LevelRow(base_y - 1 + k, plane.height());
    rows[k] = row >= 0 ? plane.Row(row) : zero_row_.data();
  }
  float* spline = spline_row_.data() + kSplinePad;
  CombineRows(rows, upsampler.along_y[y % scale].data(), n, spline);
  for (int k = 1; k <= kSplinePad; ++k) {
    spline[-k] = border_ == Border::kMirror ? spline[MirroredIndex(-k, n)] : 0.0f;
    spline[n - 1 + k] = border_ == Border::kMirror ? spline[MirroredIndex(n - 1 + k, n)] : 0.0f;
  }
  // expanded[x + scale] is the coefficient at or before pixel x; coefficient j serves the pixels from scale
  // (j + 1/2).
  float* expanded = expanded_row_.data();
  for (int x = -scale, j = -kSplinePad; j < n + kSplinePad; ++j) {
    const int end = std::min(scale / 2 + (j + 1) * scale, domain_.width + 2 * scale);
    for (; x < end; ++x) expanded[x + scale] = spline[j];
  }
  EvaluateSpline(expanded, scale, upsampler.along_x[0].data(), upsampler.along_x[1].data(),
                 upsampler.along_x[2].data(), upsampler.along_x[3].data(), domain_.width, full_row_.data());
  return full_row_.data();
}

void PyramidConvolver::Accumulate(const PlaneF& plane, int level, int gaussian,
                                  std::span<const ConvolutionTarget> targets) {
  for (int y = 0; y < domain_.height; ++y) {
    const float* values = nullptr;
    for (const ConvolutionTarget& target : targets) {
      const Region& region = target.weights->region();
      const int row = y - region.y;
      if (!target.weights->active(gaussian) || row < 0 || row >= region.height) continue;
      if (!values) values = level == 0 ? plane.Row(y) : UpsampledRow(plane, upsamplers_[level], y);
      AccumulateTarget(target, gaussian, row, values + region.x);
    }
  }
}

void PyramidConvolver::Convolve(const PlaneF& input, std::span<const ConvolutionTarget> targets) {
  assert(input.SameShape(domain_.width, domain_.height));
  ClearTargets(targets);
  int level = 0, last = -1;
  for (int gaussian = 0; gaussian < kGaussianCount; ++gaussian) {
    if (!AnyActive(targets, gaussian)) continue;
    const int last_level = level;
    level = LevelAfter(level, last);
    Descend(last_level, level);
    blurs_[level].Apply(last < 0 ? input : planes_[level], Kernel(last_level, last, level, gaussian),
                        planes_[level]);
    last = gaussian;
    Accumulate(planes_[level], level, gaussian, targets);
  }
}

void PyramidConvolver::Ascend(int from_level, int to_level) {
  for (int level = from_level; level > to_level; --level) {
    const PlaneF& coarse = planes_[level];
    PlaneF& fine = planes_[level - 1];
    for (int y = 0; y < fine.height(); ++y) SpreadPairs(coarse.Row(y / 2), coarse.width(), fine.Row(y));
  }
}

void PyramidConvolver::AddWeighted(const PlaneF& result, const ResponseWeights& weights, int gaussian,
                                   int level) {
  const Region& region = weights.region();
  const PlaneF& plane = weights.plane(gaussian);
  if (level == 0) {
    for (int y = 0; y < region.height; ++y)
      AccumulateRow(plane.Row(y), result.Row(y), region.width, planes_[0].Row(y + region.y) + region.x);
    return;
  }
  const Upsampler& upsampler = upsamplers_[level];
  const int height = planes_[level].height();
  Fill(rows_coarsened_, domain_.width, height, 0.0f);
  std::fill(full_row_.begin(), full_row_.end(), 0.0f);
  for (int y = 0; y < region.height; ++y) {
    std::fill_n(full_row_.data() + region.x, region.width, 0.0f);
    AccumulateRow(plane.Row(y), result.Row(y), region.width, full_row_.data() + region.x);
    const int fine_y = y + region.y;
    const int base_y = static_cast<int>(std::floor(LevelPosition(fine_y, upsampler.scale)));
    for (int k = 0; k < 4; ++k) {
      const int row = LevelRow(base_y - 1 + k, height);
      if (row < 0) continue;
      AddScaledRow(full_row_.data(), upsampler.along_y[fine_y % upsampler.scale][k], domain_.width,
                   rows_coarsened_.Row(row));
    }
  }
  AddCoarsened(level);
}

// planes_[level] += rows_coarsened_, made coarser along x.
void PyramidConvolver::AddCoarsened(int level) {
  const Upsampler& upsampler = upsamplers_[level];
  PlaneF& plane = planes_[level];
  const int n = plane.width(), scale = upsampler.scale;
  float* spline = spline_row_.data() + kSplinePad;
  for (int y = 0; y < plane.height(); ++y) {
    std::fill(spline_row_.begin(), spline_row_.end(), 0.0f);
    const float* row = rows_coarsened_.Row(y);
    for (int x = 0; x < domain_.width; ++x) {
      float* from = spline + (x + scale / 2) / scale - 2;
      for (int k = 0; k < 4; ++k) from[k] += upsampler.along_x[k][x] * row[x];
    }
    for (int k = 1; border_ == Border::kMirror && k <= kSplinePad; ++k) {
      spline[MirroredIndex(-k, n)] += spline[-k];
      spline[MirroredIndex(n - 1 + k, n)] += spline[n - 1 + k];
    }
    AddScaledRow(spline, 1.0f, n, plane.Row(y));
  }
}

// The same steps from the widest Gaussian down. A blur is its own transpose.
void PyramidConvolver::ConvolveTransposed(const PlaneF& result, const ResponseWeights& weights,
                                          PlaneF& input) {
  assert(result.SameShape(weights.region().width, weights.region().height));
  std::array<int, kGaussianCount> levels{};
  int level = 0, last = -1;
  for (int gaussian = 0; gaussian < kGaussianCount; ++gaussian) {
    if (!weights.active(gaussian)) continue;
    levels[gaussian] = level = LevelAfter(level, last);
    last = gaussian;
  }
  Fill(planes_[level], planes_[level].width(), planes_[level].height(), 0.0f);
  for (int gaussian = last; gaussian >= 0; gaussian = weights.ActiveBefore(gaussian)) {
    const int before = weights.ActiveBefore(gaussian), next_level = before < 0 ? 0 : levels[before];
    level = levels[gaussian];
    AddWeighted(result, weights, gaussian, level);
    blurs_[level].Apply(planes_[level], Kernel(next_level, before, level, gaussian), planes_[level]);
    Ascend(level, next_level);
  }
  EnsureShape(input, domain_.width, domain_.height);
  std::copy(planes_[0].values().begin(), planes_[0].values().end(), input.values().begin());
}

}  // namespace dermap
