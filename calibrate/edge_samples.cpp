// SPDX-License-Identifier: Apache-2.0
// Photosites within reach of an edge, with their place and their weight.
#include "calibrate/edge_samples.h"

#include <algorithm>
#include <cmath>

namespace dermap {
namespace {

constexpr double kLeastReach_px = 7.0;  // to either side
constexpr double kMostInside_px = 40.0;
constexpr double kMostOutside_px = 12.0;
constexpr double kInside_mm = 0.45;  // how far skin is seen to darken towards the tape
constexpr double kOutside_mm = 0.2;
// Along an edge, with levels of its own: skin's structure must not look like the lens's blur.
constexpr double kSegment_mm = 0.4;
constexpr double kLeastSegment_px = 10.0;
constexpr double kReadNoiseDn = 20.0;  // signal at which shot noise equals read noise, about

EdgeReach ReachOf(const std::array<Edge, 4>& edges, std::size_t i, double window_mm) {
  // Across an edge the picture's scale is that of its two neighbours.
  const double px_per_mm = 0.5 * (edges[(i + 1) % 4].length() + edges[(i + 3) % 4].length()) / window_mm;
  return {std::clamp(kInside_mm * px_per_mm, kLeastReach_px, kMostInside_px),
          std::clamp(kOutside_mm * px_per_mm, kLeastReach_px, kMostOutside_px), px_per_mm};
}

void Collect(const Mosaic& mosaic, const Edge& edge, const EdgeReach& reach, int index, int first_segment,
             int segments, std::vector<EdgeSample>& samples) {
  const double first = kCornerShare * edge.length();
  const double last = (1.0 - kCornerShare) * edge.length();
  const Point along = edge.along();
  const Point inwards = edge.inwards();
  const Point a = mosaic.lens.PhotositesFromIdeal(edge.from);
  const Point b = mosaic.lens.PhotositesFromIdeal(edge.to);
  const Point m = mosaic.lens.PhotositesFromIdeal(edge.At(0.5 * edge.length(), 0.0));
  const double bow = std::hypot(m.x - 0.5 * (a.x + b.x), m.y - 0.5 * (a.y + b.y));
  const double margin = std::max(reach.inside_px, reach.outside_px) + bow;
  const auto low = [&](double p, double q) { return static_cast<int>(std::floor(std::min(p, q) - margin)); };
  const auto high = [&](double p, double q) { return static_cast<int>(std::ceil(std::max(p, q) + margin)); };
  const int x0 = std::max(0, low(a.x, b.x) - mosaic.x0);
  const int x1 = std::min(mosaic.width(), high(a.x, b.x) - mosaic.x0);
  const int y0 = std::max(0, low(a.y, b.y) - mosaic.y0);
  const int y1 = std::min(mosaic.height(), high(a.y, b.y) - mosaic.y0);
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const Point ideal = mosaic.lens.IdealFromPhotosites({mosaic.x0 + x + 0.5, mosaic.y0 + y + 0.5});
      const double dx = ideal.x - edge.from.x;
      const double dy = ideal.y - edge.from.y;
      const double t = dx * along.x + dy * along.y;
      const double s = dx * inwards.x + dy * inwards.y;
      const double white = mosaic.spectralon(x, y);
      if (s > reach.inside_px || s < -reach.outside_px || t < first || t >= last || mosaic.mask(x, y) != 0 ||
          white <= kReadNoiseDn / 4) {
        continue;
      }
      const double place = (t - first) / (last - first) * segments;
      const int segment = std::min(segments - 1, static_cast<int>(place));
      // Shot noise: variance of skin / white goes as 1 / white, beneath the read noise as 1 / white^2.
      const double weight = white * white / (white + kReadNoiseDn);
      samples.push_back({s, t, mosaic.scale * mosaic.skin(x, y) / white, weight, index,
                         first_segment + segment, 2 * (place - segment) - 1});
    }
  }
}

// Every n-th sample of a window of many photosites; n is odd, so that all colours stay.
void Thin(std::size_t most, std::vector<EdgeSample>& samples) {
  std::size_t every = samples.size() / most + 1;
  if (every == 1) return;
  every |= 1U;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < samples.size(); i += every) samples[kept++] = samples[i];
  samples.resize(kept);
}

}  // namespace

EdgeSamples CollectEdgeSamples(const Mosaic& mosaic, const std::array<Edge, 4>& edges, double window_mm,
                               std::size_t most_samples) {
  EdgeSamples out;
  for (std::size_t i = 0; i < 4; ++i) {
    out.reach[i] = ReachOf(edges, i, window_mm);
    const double used_px = (1.0 - 2.0 * kCornerShare) * edges[i].length();
    const double segment_px = std::max(kLeastSegment_px, kSegment_mm * edges[i].length() / window_mm);
    const int own = std::max(1, static_cast<int>(used_px / segment_px));
    Collect(mosaic, edges[i], out.reach[i], static_cast<int>(i), out.segments, own, out.samples);
    out.segments += own;
  }
  Thin(most_samples, out.samples);
  return out;
}

}  // namespace dermap
