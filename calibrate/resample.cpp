// SPDX-License-Identifier: Apache-2.0
// Resampling with explicit weights: every pixel is a list of photosites and their coefficients, from which
// both its value and its variance follow.
#include "calibrate/resample.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dermap {
namespace {

constexpr double kWeakestSignal = 3.0;  // of its own noise: weaker Spectralon photosites say nothing
constexpr double kFewestSamples = 0.5;  // share of a pixel's samples that must exist
constexpr int kCorrelationStep = 16;    // pixels between the places where correlation is reckoned

// Variances of each photosite from smoothed signals, in DN^2 of skin and Spectralon.
struct PhotositeNoise {
  PlaneF spectralon;     // smoothed signal
  PlaneF skin_variance;  // of the skin frame and its own black
  PlaneF
      spectralon_variance;  // of the Spectralon frame, its own and the shared black, as seen in reflectance
  PlaneF weight;            // 1 / variance of a single photosite's reflectance, 0 where too weak
};

PhotositeNoise NoiseOfPhotosites(const Mosaic& mosaic, const MosaicNoise& noise) {
  PhotositeNoise out;
  out.spectralon = LatticeSmooth(mosaic.spectralon, mosaic.mask);
  const PlaneF skin = LatticeSmooth(mosaic.skin, mosaic.mask);
  out.skin_variance = out.spectralon_variance = out.weight = PlaneF(mosaic.width(), mosaic.height());
  for (std::size_t i = 0; i < skin.size(); ++i) {
    const double s = skin.data()[i];
    const double w = out.spectralon.data()[i];
    const double ratio = w > 0.0 ? s / w : 0.0;
    const double of_skin = noise.skin.Variance(s) + noise.skin_black * noise.skin.read_variance;
    const double of_white = noise.spectralon.Variance(w) / noise.spectralon_frames +
                            noise.spectralon_black * noise.spectralon.read_variance;
    // d(s/w) by the black of both: -(1 - s/w) / w.
    const double shared = (1.0 - ratio) * (1.0 - ratio) * noise.shared_black * noise.skin.read_variance;
    out.skin_variance.data()[i] = static_cast<float>(of_skin);
    out.spectralon_variance.data()[i] = static_cast<float>(ratio * ratio * of_white + shared);
    const double total = of_skin + ratio * ratio * of_white + shared;
    const bool strong = w > kWeakestSignal * std::sqrt(noise.spectralon.Variance(w));
    out.weight.data()[i] = strong ? static_cast<float>(w * w / total) : 0.0f;
  }
  return out;
}

// The photosites that one pixel is made of: coefficients of the skin's signal within a box.
struct PixelWeights {
  int x0 = 0, y0 = 0, width = 0, height = 0;
  std::vector<double> coefficients;
  double value = 0.0;  // reflectance
  bool valid = false;

  void Clear(int left, int top, int right, int bottom) {
    x0 = left, y0 = top, width = std::max(0, right - left), height = std::max(0, bottom - top);
    coefficients.assign(static_cast<std::size_t>(width) * height, 0.0);
    value = 0.0;
    valid = false;
  }
  double& At(int x, int y) { return coefficients[static_cast<std::size_t>(y - y0) * width + (x - x0)]; }
  double Of(int x, int y) const {
    if (x < x0 || y < y0 || x >= x0 + width || y >= y0 + height) return 0.0;
    return coefficients[static_cast<std::size_t>(y - y0) * width + (x - x0)];
  }
};

class Resampler {
 public:
  Resampler(const Mosaic& mosaic, const Homography& camera_from_unit, const MosaicNoise& noise, int patch_px)
      : mosaic_(mosaic),
        map_(camera_from_unit),
        noise_(NoiseOfPhotosites(mosaic, noise)),
        patch_px_(patch_px) {
    const Point a = map_({0, 0});
    const Point b = map_({1, 0});
    const Point c = map_({1, 1});
    const double side = std::max(std::hypot(b.x - a.x, b.y - a.y), std::hypot(c.x - b.x, c.y - b.y));
    samples_ = std::max(2, static_cast<int>(std::ceil(side / patch_px - 0.25)));  // 2 as in [D08 7.2]
  }

  void Pixel(int px, int py, PixelWeights& out) const {
    StartBox(px, py, out);
    int used = 0;
    double skin_sum = 0.0;
    for (int j = 0; j < samples_; ++j) {
      for (int i = 0; i < samples_; ++i) {
        double value = 0.0;
        if (!Sample(map_(UnitPoint(px, py, i, j)), out, value)) continue;
        skin_sum += value;
        ++used;
      }
    }
    out.valid = used > 0 && used >= kFewestSamples * samples_ * samples_;
    if (!out.valid) return;
    out.value = skin_sum / used;
    for (double& c : out.coefficients) c /= used;
  }

  void Variances(const PixelWeights& w, double& skin, double& spectralon) const {
    skin = spectralon = 0.0;
    for (int y = w.y0; y < w.y0 + w.height; ++y) {
      for (int x = w.x0; x < w.x0 + w.width; ++x) {
        const double c = w.Of(x, y);
        if (c == 0.0) continue;
        skin += c * c * noise_.skin_variance(x, y);
        spectralon += c * c * noise_.spectralon_variance(x, y);
      }
    }
  }

  double Covariance(const PixelWeights& a, const PixelWeights& b) const {
    double sum = 0.0;
    for (int y = a.y0; y < a.y0 + a.height; ++y) {
      for (int x = a.x0; x < a.x0 + a.width; ++x) {
        sum += a.Of(x, y) * b.Of(x, y) * (noise_.skin_variance(x, y) + noise_.spectralon_variance(x, y));
      }
    }
    return sum;
  }

 private:
  Point UnitPoint(int px, int py, int i, int j) const {
    return {(px + (i + 0.5) / samples_) / patch_px_, (py + (j + 0.5) / samples_) / patch_px_};
  }

  // All photosites within reach of the pixel's corner samples.
  void StartBox(int px, int py, PixelWeights& out) const {
    double left = 1e30, top = 1e30, right = -1e30, bottom = -1e30;
    for (const int i : {0, samples_ - 1}) {
      for (const int j : {0, samples_ - 1}) {
        const Point p = map_(UnitPoint(px, py, i, j));
        left = std::min(left, p.x), right = std::max(right, p.x);
        top = std::min(top, p.y), bottom = std::max(bottom, p.y);
      }
    }
    const auto clip = [](double v, int limit) { return static_cast<int>(std::clamp(v, 0.0, double(limit))); };
    out.Clear(clip(std::floor(left) - mosaic_.x0 - 3, mosaic_.width()),
              clip(std::floor(top) - mosaic_.y0 - 3, mosaic_.height()),
              clip(std::floor(right) - mosaic_.x0 + 4, mosaic_.width()),
              clip(std::floor(bottom) - mosaic_.y0 + 4, mosaic_.height()));
  }

  // One bilinear sample: each lattice for itself, combined by inverse variance. False where nothing is
  // usable.
  bool Sample(Point p, PixelWeights& out, double& value) const {
    struct Lattice {
      LatticeCell cell;
      std::array<double, 4> b;
      double skin = 0, white = 0, smooth_white = 0, weight = 0;
    };
    std::array<Lattice, kLatticeCount> lattices;
    double total = 0.0;
    for (int l = 0; l < kLatticeCount; ++l) {
      Lattice& lattice = lattices[l];
      const LatticeCell c = lattice.cell = CellAt(mosaic_, l, p.x, p.y);
      if (!c.inside) continue;
      lattice.b = {(1 - c.fx) * (1 - c.fy), c.fx * (1 - c.fy), (1 - c.fx) * c.fy, c.fx * c.fy};
      bool usable = true;
      for (int i = 0; i < 4; ++i) {
        const int x = c.x + 2 * (i & 1);
        const int y = c.y + 2 * (i >> 1);
        usable = usable && (mosaic_.mask(x, y) == 0 || lattice.b[i] < 1e-9) && noise_.weight(x, y) > 0.0f;
        lattice.skin += lattice.b[i] * mosaic_.skin(x, y);
        lattice.white += lattice.b[i] * mosaic_.spectralon(x, y);
        lattice.smooth_white += lattice.b[i] * noise_.spectralon(x, y);
        lattice.weight += lattice.b[i] * noise_.weight(x, y);
      }
      if (!usable || !(lattice.white > 0.0)) lattice.weight = 0.0;
      total += lattice.weight;
    }
    if (!(total > 0.0)) return false;
    value = 0.0;
    for (const Lattice& lattice : lattices) {
      if (lattice.weight == 0.0) continue;
      const double share = lattice.weight / total;
      value += share * mosaic_.scale * lattice.skin / lattice.white;
      for (int i = 0; i < 4; ++i) {
        out.At(lattice.cell.x + 2 * (i & 1), lattice.cell.y + 2 * (i >> 1)) +=
            share * mosaic_.scale * lattice.b[i] / lattice.smooth_white;
      }
    }
    return true;
  }

  const Mosaic& mosaic_;
  Homography map_;
  PhotositeNoise noise_;
  int patch_px_;
  int samples_ = 2;  // a pixel and axis
};

}  // namespace

ResampledPatch ResamplePatch(const Mosaic& mosaic, const Homography& camera_from_unit,
                             const MosaicNoise& noise, int patch_px) {
  const Resampler resampler(mosaic, camera_from_unit, noise, patch_px);
  constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();
  ResampledPatch patch;
  patch.reflectance = PlaneF(patch_px, patch_px, kMissing);
  patch.skin_variance = patch.spectralon_variance = patch.reflectance;
  PixelWeights weights;
  for (int y = 0; y < patch_px; ++y) {
    for (int x = 0; x < patch_px; ++x) {
      resampler.Pixel(x, y, weights);
      if (!weights.valid) continue;
      double skin = 0.0;
      double spectralon = 0.0;
      resampler.Variances(weights, skin, spectralon);
      patch.reflectance(x, y) = static_cast<float>(weights.value);
      patch.skin_variance(x, y) = static_cast<float>(skin);
      patch.spectralon_variance(x, y) = static_cast<float>(spectralon);
    }
  }
  return patch;
}

NoiseCorrelation CorrelationOfNoise(const Mosaic& mosaic, const Homography& camera_from_unit,
                                    const MosaicNoise& noise, int patch_px) {
  constexpr int kReach = NoiseCorrelation::kReach;
  const Resampler resampler(mosaic, camera_from_unit, noise, patch_px);
  NoiseCorrelation result;
  result.along_x.assign(kReach + 1, 0.0);
  result.along_y.assign(kReach + 1, 0.0);
  int places = 0;
  PixelWeights here;
  PixelWeights there;
  const auto correlation = [&](int x, int y, double own) {
    resampler.Pixel(x, y, there);
    const double other = there.valid ? resampler.Covariance(there, there) : 0.0;
    return other > 0.0 ? resampler.Covariance(here, there) / std::sqrt(own * other) : 0.0;
  };
  for (int y = kCorrelationStep / 2; y + kReach < patch_px; y += kCorrelationStep) {
    for (int x = kCorrelationStep / 2; x + kReach < patch_px; x += kCorrelationStep) {
      resampler.Pixel(x, y, here);
      const double own = here.valid ? resampler.Covariance(here, here) : 0.0;
      if (!(own > 0.0)) continue;
      ++places;
      for (int lag = 0; lag <= kReach; ++lag) {
        result.along_x[lag] += correlation(x + lag, y, own);
        result.along_y[lag] += correlation(x, y + lag, own);
      }
      result.diagonal += correlation(x + 1, y + 1, own);
    }
  }
  for (double& c : result.along_x) c /= std::max(1, places);
  for (double& c : result.along_y) c /= std::max(1, places);
  result.diagonal /= std::max(1, places);
  return result;
}

}  // namespace dermap
