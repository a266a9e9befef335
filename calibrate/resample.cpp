// SPDX-License-Identifier: Apache-2.0
// Resampling with explicit weights: every pixel is a list of photosites and their coefficients, from which
// both its value and its variance follow.
#include "calibrate/resample.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

namespace dermap {
namespace {

constexpr double kWeakestSignal = 3.0;  // of its own noise: weaker Spectralon photosites say nothing
constexpr double kFewestSamples = 0.5;  // share of a pixel's samples that must exist
constexpr double kSampleStep_px = 1.5;  // photosites; a bilinear sample reaches two to either side
constexpr double kPlaneReach_px = 3.5;  // X-Trans: every colour lies within it several times
constexpr int kCorrelationStep = 16;    // pixels between the places where correlation is reckoned

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

// Deviations by photosites of one Spectralon frame that several skin frames may share: those of one photosite
// add up before they are squared.
class SharedNoise {
 public:
  void Clear() { entries_.clear(); }
  void Add(int x, int y, double deviation) { entries_.push_back({y, x, deviation}); }
  double Variance(bool repeated) {
    if (!repeated) {  // no photosite occurs twice
      double plain = 0.0;
      for (const Entry& e : entries_) plain += e.deviation * e.deviation;
      return plain;
    }
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

class Resampler {
 public:
  Resampler(const PatchSource& source, int patch_px, bool draft = false)
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

  void Pixel(int px, int py, PixelWeights& out) const {
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
    for (double& c : out.coefficients) c /= used;
  }

  double SkinVariance(const PixelWeights& w) const {
    double sum = 0.0;
    ForEach(w, [&](int x, int y, double c) { sum += c * c * noise_.skin_variance(x, y); });
    return sum;
  }

  // What each photosite of the Spectralon frame contributes to a pixel, in standard deviations; photosites of
  // the whole frame.
  template <class Add>
  void SpectralonDeviations(const PixelWeights& w, const Add& add) const {
    ForEach(w, [&](int x, int y, double c) {
      add(mosaic_.x0 + x, mosaic_.y0 + y, c * std::sqrt(double(noise_.spectralon_variance(x, y))));
    });
  }

  // Photosites of a pixel with their ideal camera coordinates.
  template <class Body>
  void ForEachPhotosite(const PixelWeights& w, const Body& body) const {
    ForEach(w, [&](int x, int y, double c) {
      const Point p = mosaic_.lens.IdealFromPhotosites({mosaic_.x0 + x + 0.5, mosaic_.y0 + y + 0.5});
      body(p.x, p.y, c * noise_.spectralon(x, y));
    });
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
  template <class Body>
  static void ForEach(const PixelWeights& w, const Body& body) {
    for (int y = w.y0; y < w.y0 + w.height; ++y) {
      for (int x = w.x0; x < w.x0 + w.width; ++x) {
        if (const double c = w.Of(x, y); c != 0.0) body(x, y, c);
      }
    }
  }

  // Photosites of a sample, between those of the pixel's corners: over one pixel the map is straight to 1e-3.
  Point SamplePoint(int px, int py, int i, int j) const {
    const double fx = (i + 0.5) / samples_, fy = (j + 0.5) / samples_;
    const Point* top = &corners_[static_cast<std::size_t>(py) * (patch_px_ + 1) + px];
    const Point* bottom = top + patch_px_ + 1;
    const auto between = [&](double a, double b, double c, double d) {
      return (1 - fy) * ((1 - fx) * a + fx * b) + fy * ((1 - fx) * c + fx * d);
    };
    return {between(top[0].x, top[1].x, bottom[0].x, bottom[1].x),
            between(top[0].y, top[1].y, bottom[0].y, bottom[1].y)};
  }

  // All photosites within reach of the pixel's corner samples.
  void StartBox(int px, int py, PixelWeights& out) const {
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

  // One bilinear sample: each lattice for itself, combined by inverse variance. False where nothing is
  // usable.
  bool Sample(Point p, PixelWeights& out, double& value) const {
    return mosaic_.period == 2 ? SampleLattices(p, out, value) : SamplePlane(p, out, value);
  }

  // Where a lattice holds several colours: a plane through the reflectances of the photosites around,
  // weighted by their noise and nearness, read at the point. Exact on gradients whatever the weights.
  bool SamplePlane(Point p, PixelWeights& out, double& value) const {
    const double cx = p.x - mosaic_.x0, cy = p.y - mosaic_.y0;
    const int x0 = std::max({0, out.x0, static_cast<int>(std::floor(cx - kPlaneReach_px))});
    const int y0 = std::max({0, out.y0, static_cast<int>(std::floor(cy - kPlaneReach_px))});
    const int x1 = std::min({mosaic_.width(), out.x0 + out.width, static_cast<int>(cx + kPlaneReach_px) + 1});
    const int y1 =
        std::min({mosaic_.height(), out.y0 + out.height, static_cast<int>(cy + kPlaneReach_px) + 1});
    const auto weight_of = [&](int x, int y, double dx, double dy) {
      const double r2 = (dx * dx + dy * dy) / (kPlaneReach_px * kPlaneReach_px);
      const bool usable = r2 < 1.0 && mosaic_.mask(x, y) == 0 && mosaic_.spectralon(x, y) > 0.0f;
      return usable ? noise_.weight(x, y) * (1.0 - r2) * (1.0 - r2) : 0.0;
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
        value += share * mosaic_.scale * mosaic_.skin(x, y) / mosaic_.spectralon(x, y);
        out.At(x, y) += share * mosaic_.scale / noise_.spectralon(x, y);
      }
    }
    return true;
  }

  bool SampleLattices(Point p, PixelWeights& out, double& value) const {
    struct Lattice {
      LatticeCell cell;
      std::array<double, 4> b;
      double skin = 0, white = 0, smooth_white = 0, weight = 0;
    };
    std::array<Lattice, kLatticeCount> lattices;
    double total = 0.0;
    for (int l = 0; l < kLatticeCount; ++l) {
      Lattice& lattice = lattices[l];
      const LatticeCell c = lattice.cell = CellAt(mosaic_, l, p);
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
  const PhotositeNoise& noise_;
  int patch_px_;
  std::vector<Point> corners_;  // of the pixels, row by row: photosites of the frame
  int samples_ = 2;             // a pixel and axis
};

}  // namespace

PhotositeNoise NoiseOfPhotosites(const Mosaic& mosaic, const MosaicNoise& noise) {
  PhotositeNoise out;
  out.spectralon = LatticeSmooth(mosaic.spectralon, mosaic.mask, mosaic.period);
  const PlaneF skin = LatticeSmooth(mosaic.skin, mosaic.mask, mosaic.period);
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
      double skin = 0.0;
      int count = 0;
      shared.Clear();
      for (const Resampler& resampler : resamplers) {
        resampler.Pixel(x, y, weights);
        if (!weights.valid) continue;
        ++count;
        sum += weights.value;
        skin += resampler.SkinVariance(weights);
        resampler.SpectralonDeviations(weights, [&](int px, int py, double d) { shared.Add(px, py, d); });
      }
      if (count == 0) continue;
      patch.reflectance(x, y) = static_cast<float>(sum / count);
      patch.sigma(x, y) = static_cast<float>(std::sqrt(skin + shared.Variance(count > 1)) / count);
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
