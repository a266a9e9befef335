// SPDX-License-Identifier: Apache-2.0
// Every pixel of the patch as a list of photosites and their coefficients, from which its value and its
// variance follow.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "calibrate/resample.h"

namespace dermap {

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
  Resampler(const PatchSource& source, int patch_px, bool draft = false);

  void Pixel(int px, int py, PixelWeights& out) const;

  double SkinVariance(const PixelWeights& w) const {
    double sum = 0.0;
    ForEach(w, [&](int x, int y, double c) { sum += c * c * noise_.skin_variance(x, y); });
    return sum;
  }

  // Of skin and Spectralon together, for a Spectralon frame that no other pixel source shares.
  double Variance(const PixelWeights& w) const {
    double sum = 0.0;
    ForEach(w, [&](int x, int y, double c) {
      sum += c * c * (noise_.skin_variance(x, y) + noise_.spectralon_variance(x, y));
    });
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
      body(p.x, p.y, c * noise_.signals(x, y).smooth);
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
    const double* c = w.coefficients.data();
    for (int y = w.y0; y < w.y0 + w.height; ++y) {
      for (int x = w.x0; x < w.x0 + w.width; ++x, ++c) {
        if (*c != 0.0) body(x, y, *c);
      }
    }
  }

  // Photosites of a sample, between those of the pixel's corners: over one pixel the map is straight to 1e-3.
  Point SamplePoint(int px, int py, int i, int j) const;

  // All photosites within reach of the pixel's corner samples.
  void StartBox(int px, int py, PixelWeights& out) const;

  // One bilinear sample: each lattice for itself, combined by inverse variance. False where nothing is
  // usable.
  bool Sample(Point p, PixelWeights& out, double& value) const {
    return mosaic_.period == 2 ? SampleLattices(p, out, value) : SamplePlane(p, out, value);
  }

  // Where a lattice holds several colours: a plane through the reflectances of the photosites around,
  // weighted by their noise and nearness, read at the point. Exact on gradients whatever the weights.
  bool SamplePlane(Point p, PixelWeights& out, double& value) const;

  bool SampleLattices(Point p, PixelWeights& out, double& value) const;

  const Mosaic& mosaic_;
  const PhotositeNoise& noise_;
  int patch_px_;
  std::vector<Point> corners_;  // of the pixels, row by row: photosites of the frame
  int samples_ = 2;             // a pixel and axis
};

}  // namespace dermap
