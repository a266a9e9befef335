// SPDX-License-Identifier: Apache-2.0
// Values, variances, correlation and blur of pixels from their photosites' weights.
#include "calibrate/resample.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/resampler.h"

namespace dermap {
namespace {

constexpr double kWeakestSignal = 3.0;  // of its own noise: weaker Spectralon photosites say nothing
constexpr int kCorrelationStep = 16;    // pixels between the places where correlation is reckoned

// Deviations by photosites of one Spectralon frame that several skin frames may share: those of one photosite
// add up before they are squared.
class SharedNoise {
 public:
  void Clear() { entries_.clear(); }
  void Add(int x, int y, double deviation) { entries_.push_back({y, x, deviation}); }
  double Variance() {
    std::sort(entries_.begin(), entries_.end(),
              [](const Entry& a, const Entry& b) { return a.y != b.y ? a.y < b.y : a.x < b.x; });
    double sum = 0.0;
    for (std::size_t i = 0; i < entries_.size();) {
      double one = 0.0;
      const Entry& first = entries_[i];
      for (; i < entries_.size() && entries_[i].x == first.x && entries_[i].y == first.y; ++i)
        one += entries_[i].deviation;
      sum += one * one;
    }
    return sum;
  }

 private:
  struct Entry {
    int y, x;
    double deviation;
  };
  std::vector<Entry> entries_;
};

}  // namespace

PhotositeNoise NoiseOfPhotosites(const Mosaic& mosaic, const MosaicNoise& noise) {
  const SmoothSignals smooth = LatticeSmooth(mosaic);
  PhotositeNoise out;
  out.signals = Plane<PhotositeSignal>(mosaic.width(), mosaic.height());
  out.skin_variance = PlaneF(mosaic.width(), mosaic.height());
  out.spectralon_variance = PlaneF(mosaic.width(), mosaic.height());
  const std::size_t width = static_cast<std::size_t>(mosaic.width());
  for (std::size_t i = 0; i < out.signals.size(); ++i) {
    const int kind = KindOf(mosaic.x0 + static_cast<int>(i % width), mosaic.y0 + static_cast<int>(i / width),
                            mosaic.period);
    const double s = smooth.skin.data()[i];
    const double w = smooth.spectralon.data()[i];
    const double ratio = w > 0.0 ? s / w : 0.0;
    const double of_skin =
        noise.skin.Variance(s + mosaic.skin_off[kind]) + noise.skin_black * noise.skin.read_variance;
    const double one_white = noise.spectralon.Variance(w + mosaic.spectralon_off[kind]);
    const double of_white =
        one_white / noise.spectralon_frames + noise.spectralon_black * noise.spectralon.read_variance;
    // d(s/w) by the black of both: -(1 - s/w) / w.
    const double shared = (1.0 - ratio) * (1.0 - ratio) * noise.shared_black * noise.skin.read_variance;
    const double as_seen = ratio * ratio * of_white + shared;
    out.skin_variance.data()[i] = static_cast<float>(of_skin);
    out.spectralon_variance.data()[i] = static_cast<float>(as_seen);
    const bool strong = w > 0.0 && w * w > kWeakestSignal * kWeakestSignal * one_white;
    const bool usable = strong && mosaic.mask.data()[i] == 0;
    out.signals.data()[i] = {mosaic.skin.data()[i], mosaic.spectralon.data()[i], static_cast<float>(w),
                             usable ? static_cast<float>(w * w / (of_skin + as_seen)) : 0.0f};
  }
  return out;
}

ResampledPatch ResamplePatch(std::span<const PatchSource> sources, int patch_px, bool draft) {
  std::vector<Resampler> resamplers;
  for (const PatchSource& source : sources) resamplers.emplace_back(source, patch_px, draft);
  constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();
  ResampledPatch patch{PlaneF(patch_px, patch_px, kMissing), PlaneF(patch_px, patch_px, kMissing)};
  PixelWeights weights;
  SharedNoise shared;
  for (int y = 0; y < patch_px; ++y) {
    for (int x = 0; x < patch_px; ++x) {
      double sum = 0.0;
      double variance = 0.0;
      int count = 0;
      shared.Clear();
      for (const Resampler& resampler : resamplers) {
        resampler.Pixel(x, y, weights);
        if (!weights.valid) continue;
        ++count;
        sum += weights.value;
        if (resamplers.size() == 1) {
          variance = resampler.Variance(weights);
          continue;
        }
        variance += resampler.SkinVariance(weights);
        resampler.SpectralonDeviations(weights, [&](int px, int py, double d) { shared.Add(px, py, d); });
      }
      if (count == 0) continue;
      patch.reflectance(x, y) = static_cast<float>(sum / count);
      patch.sigma(x, y) = static_cast<float>(std::sqrt(variance + shared.Variance()) / count);
    }
  }
  return patch;
}

NoiseCorrelation CorrelationOfNoise(const PatchSource& source, int patch_px) {
  constexpr int kReach = NoiseCorrelation::kReach;
  const Resampler resampler(source, patch_px);
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

Point BlurOfPatch(const PatchSource& source, double lens_blur_px, int patch_px) {
  const Resampler resampler(source, patch_px);
  const Homography unit_from_camera = source.map.camera_from_unit.Inverse();
  Point sum;
  int places = 0;
  PixelWeights weights;
  for (int py = kCorrelationStep / 2; py < patch_px; py += kCorrelationStep) {
    for (int px = kCorrelationStep / 2; px < patch_px; px += kCorrelationStep) {
      resampler.Pixel(px, py, weights);
      if (!weights.valid) continue;
      const Point middle = source.map({(px + 0.5) / patch_px, (py + 0.5) / patch_px});
      const auto patch_of = [&](Point camera) {
        const Point unit = unit_from_camera(camera);
        return Point{unit.x * patch_px, unit.y * patch_px};
      };
      const Point origin = patch_of(middle);
      double total = 0.0, mx = 0.0, my = 0.0, xx = 0.0, yy = 0.0;
      resampler.ForEachPhotosite(weights, [&](double camera_x, double camera_y, double c) {
        const Point p = patch_of({camera_x, camera_y});
        total += c;
        mx += c * (p.x - origin.x), my += c * (p.y - origin.y);
        xx += c * (p.x - origin.x) * (p.x - origin.x), yy += c * (p.y - origin.y) * (p.y - origin.y);
      });
      const Point right = patch_of({middle.x + lens_blur_px, middle.y});
      const Point below = patch_of({middle.x, middle.y + lens_blur_px});
      sum.x += xx / total - mx * mx / (total * total) + std::pow(right.x - origin.x, 2);
      sum.y += yy / total - my * my / (total * total) + std::pow(below.y - origin.y, 2);
      ++places;
    }
  }
  return {std::sqrt(std::max(0.0, sum.x / std::max(1, places))),
          std::sqrt(std::max(0.0, sum.y / std::max(1, places)))};
}

}  // namespace dermap
