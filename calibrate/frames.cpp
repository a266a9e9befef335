// SPDX-License-Identifier: Apache-2.0
// Black subtraction photosite by photosite [D08 6.2], and masks for saturated and dead photosites.
#include "calibrate/frames.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "calibrate/saturation.h"
#include "calibrate/statistics.h"
#include "common/core/kernel.h"

namespace dermap {
namespace {

constexpr double kSaturationMarginDn = 4.0;  // below white: the last steps of a converter are not linear
constexpr double kSmallestScatterDn = 0.75;  // where rounding hides the scatter
constexpr double kDeadDeviation = 0.3;       // share of what the neighbours answer
constexpr double kDeadSigmas = 8.0;
constexpr std::size_t kMostDifferences = 50'000;  // of a kind, of which the scatter is told

struct SignalScale {
  float step_dn;  // of the black level
  float curve;    // light = signal (1 + curve signal), 1 / DN
};

DERMAP_KERNEL void SubtractBlack(const std::uint16_t* values, const std::uint16_t* black, SignalScale scale,
                                 std::size_t count, float* signal) {
  for (std::size_t i = 0; i < count; ++i) {
    const float s = static_cast<float>(values[i]) - scale.step_dn * static_cast<float>(black[i]);
    signal[i] = s * (1.0f + scale.curve * s);
  }
}

DERMAP_KERNEL std::uint16_t Largest(const std::uint16_t* values, int count) {
  std::uint16_t largest = 0;
  for (int i = 0; i < count; ++i) largest = values[i] > largest ? values[i] : largest;
  return largest;
}

// Every period-th photosite of every period-th row.
PlaneF Lattice(const PlaneF& plane, int ox, int oy, int period) {
  PlaneF out((plane.width() - ox + period - 1) / period, (plane.height() - oy + period - 1) / period);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) out(x, y) = plane(period * x + ox, period * y + oy);
  }
  return out;
}

// The photosites of the same colour around a saturated one are clipped now and then: their means would be too
// low.
void MarkSaturated(const BayerFrame& frame, SignalFrame& out) {
  const double level = SaturationLevel(frame, frame.white_level);
  if (level < frame.white_level) {
    out.notes.push_back(out.record.file + ": values stop at " + Short(level) +
                        " DN, below the white level of " + Short(frame.white_level) +
                        " DN that the file states: taken as saturated from there");
  }
  const double limit = level - kSaturationMarginDn;
  const int width = frame.values.width();
  const int height = frame.values.height();
  std::size_t count = 0;
  for (int y = 0; y < height; ++y) {
    if (Largest(frame.values.Row(y), width) < limit) continue;
    for (int x = 0; x < width; ++x) {
      if (frame.values(x, y) < limit || (out.mask(x, y) & kPhotositeHot) != 0) continue;
      ++count;
      for (int dy = -2; dy <= 2; dy += 2) {
        for (int dx = -2; dx <= 2; dx += 2) {
          const int nx = x + dx;
          const int ny = y + dy;
          if (nx >= 0 && ny >= 0 && nx < width && ny < height) out.mask(nx, ny) |= kPhotositeSaturated;
        }
      }
    }
  }
  out.saturated_share = static_cast<double>(count) / static_cast<double>(frame.values.size());
}

}  // namespace

SignalFrame ReadSignal(const FrameRecord& record, const FrameReader& read, const BlackFrames& blacks) {
  const BayerFrame frame = read(record);
  CheckSensor(record, frame, blacks.sensor());
  const BlackFrames::Match match = blacks.Find(record.exposure_ms, record.iso);
  SignalFrame out{
      record, match.level, frame.period, PlaneF(frame.values.width(), frame.values.height()), blacks.hot(),
      0.0,    {}};
  if (!match.note.empty()) out.notes.push_back(match.note);
  if (frame.iso > 0 && record.iso > 0 && frame.iso != record.iso) {
    out.notes.push_back(record.file + " itself says ISO " + std::to_string(frame.iso) +
                        ", the session says ISO " + std::to_string(record.iso));
  }
  const SignalOptions& options = blacks.options();
  const auto curve = static_cast<float>(options.nonlinearity / blacks.FullScale(*match.level));
  if (options.subtract_black) {
    SubtractBlack(frame.values.data(), match.level->mean_steps.data(), {match.level->step_dn, curve},
                  frame.values.size(), out.signal.data());
  } else {
    for (std::size_t i = 0; i < frame.values.size(); ++i) {
      const auto s = static_cast<float>(frame.values.data()[i] - frame.black_level);
      out.signal.data()[i] = s * (1.0f + curve * s);
    }
  }
  MarkSaturated(frame, out);
  return out;
}

OfKinds KindMeans(const SignalFrame& frame) {
  constexpr int kLanes = 24;  // sums side by side, for the compiler to keep in vectors; whole patterns
  OfKinds sum{}, count{};
  for (int y = 0; y < frame.signal.height(); ++y) {
    const float* signal = frame.signal.Row(y);
    const std::uint8_t* mask = frame.mask.Row(y);
    std::array<float, kLanes> row{}, used{};
    int x = 0;
    const auto add = [&](int lane) {
      // Saturated ones are bright: they count here.
      const float usable = (mask[x + lane] & kPhotositeHot) != 0 ? 0.0f : 1.0f;
      row[lane] += usable * signal[x + lane];
      used[lane] += usable;
    };
    for (; x + kLanes <= frame.signal.width(); x += kLanes) {
      for (int lane = 0; lane < kLanes; ++lane) add(lane);
    }
    for (int lane = 0; x + lane < frame.signal.width(); ++lane) add(lane);
    for (int lane = 0; lane < kLanes; ++lane) {
      const int kind = KindOf(lane, y, frame.period);
      sum[kind] += row[lane];
      count[kind] += used[lane];
    }
  }
  for (int i = 0; i < kMostKinds; ++i) sum[i] = count[i] > 0.0 ? sum[i] / count[i] : 0.0;
  return sum;
}

void MarkDead(const PlaneF& spectralon, int period, MaskPlane& mask) {
  for (int kind = 0; kind < period * period; ++kind) {
    const int ox = kind % period;
    const int oy = kind / period;
    PlaneF values = Lattice(spectralon, ox, oy, period);
    if (values.empty()) continue;
    PlaneF around(values.width(), values.height());
    const cv::Mat in(values.height(), values.width(), CV_32F, values.data());
    cv::Mat out(values.height(), values.width(), CV_32F, around.data());
    cv::medianBlur(in, out, 5);
    std::vector<float> difference;
    const std::size_t step = values.size() / kMostDifferences + 1;
    for (std::size_t i = 0; i < values.size(); i += step)
      difference.push_back(values.data()[i] - around.data()[i]);
    const double scatter = std::max(MedianAndScatter(difference).sigma, kSmallestScatterDn);
    for (int y = 0; y < values.height(); ++y) {
      for (int x = 0; x < values.width(); ++x) {
        const double off = std::abs(values(x, y) - around(x, y));
        if (off > kDeadDeviation * around(x, y) && off > kDeadSigmas * scatter) {
          mask(period * x + ox, period * y + oy) |= kPhotositeDead;
        }
      }
    }
  }
}

}  // namespace dermap
