// SPDX-License-Identifier: Apache-2.0
// Black subtraction photosite by photosite [D08 6.2], and masks for saturated, hot and dead photosites.
#include "calibrate/frames.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "calibrate/statistics.h"
#include "common/core/error.h"

namespace dermap {
namespace {

constexpr double kSaturationMarginDn = 4.0;  // below white: the last steps of a converter are not linear
constexpr double kHotSigmas = 8.0;           // of the robust scatter among photosites of one colour
constexpr double kSmallestScatterDn = 0.75;  // where rounding hides the scatter
constexpr double kDeadDeviation = 0.3;       // share of what the neighbours answer
constexpr double kDeadSigmas = 8.0;

std::string Shape(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

void CheckSensor(const FrameRecord& record, const BayerFrame& frame, const SensorFormat& sensor) {
  if (!frame.values.SameShape(sensor.width, sensor.height)) {
    throw InputError(
        record.file + ": " + Shape(frame.values.width(), frame.values.height()) +
        " photosites, but the session's first black frame has " + Shape(sensor.width, sensor.height) +
        "; all frames of a session must come from one camera at one size: capture this frame again");
  }
  if (frame.colours != sensor.colours || frame.white_level != sensor.white_level) {
    throw InputError(
        record.file +
        ": another filter pattern or white level than the session's first black frame; all "
        "frames of a session must come from one camera at one setting: capture this frame again");
  }
}

// Every second photosite of every second row.
PlaneF Lattice(const PlaneF& plane, int lattice) {
  const int ox = lattice & 1;
  const int oy = lattice >> 1;
  PlaneF out((plane.width() - ox + 1) / 2, (plane.height() - oy + 1) / 2);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) out(x, y) = plane(2 * x + ox, 2 * y + oy);
  }
  return out;
}

// The photosites of the same colour around a saturated one are clipped now and then: their means would be too
// low.
void MarkSaturated(const BayerFrame& frame, SignalFrame& out) {
  const double limit = frame.white_level - kSaturationMarginDn;
  const int width = frame.values.width();
  const int height = frame.values.height();
  std::size_t count = 0;
  for (int y = 0; y < height; ++y) {
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

BlackFrames::BlackFrames(const Session& session, const FrameReader& read) {
  for (const FrameRecord& record : session.frames) {
    if (record.role == FrameRole::kBlack) Add(record, read(record));
  }
  if (levels_.empty()) {
    throw InputError(session.directory.string() +
                     ": the session has no black frame; at least one through the wheel's "
                     "opaque slot is needed: capture it with the same plan");
  }
  FindHotPhotosites();
  FindTemporalVariance();
  squares_.clear();
}

void BlackFrames::Add(const FrameRecord& record, const BayerFrame& frame) {
  if (levels_.empty()) {
    sensor_ = {frame.values.width(), frame.values.height(), frame.colours, frame.white_level};
  }
  CheckSensor(record, frame, sensor_);
  std::size_t i = 0;
  while (i < levels_.size() && (levels_[i].exposure_ms != record.exposure_ms || levels_[i].iso != record.iso))
    ++i;
  if (i == levels_.size()) {
    levels_.push_back({record.exposure_ms, record.iso, 0, PlaneF(sensor_.width, sensor_.height), 0.0});
    squares_.emplace_back(sensor_.width, sensor_.height);
  }
  BlackReference& level = levels_[i];
  ++level.frames;
  for (std::size_t k = 0; k < frame.values.size(); ++k) {  // Welford's running mean and sum of squares
    const float delta = frame.values.data()[k] - level.mean.data()[k];
    level.mean.data()[k] += delta / static_cast<float>(level.frames);
    squares_[i].data()[k] += delta * (frame.values.data()[k] - level.mean.data()[k]);
  }
}

void BlackFrames::FindHotPhotosites() {
  hot_ = MaskPlane(sensor_.width, sensor_.height, 0);
  for (const BlackReference& level : levels_) {
    for (int lattice = 0; lattice < kLatticeCount; ++lattice) {
      const PlaneF values = Lattice(level.mean, lattice);
      const RobustScatter scatter = MedianAndScatter(values.values());
      const double limit = kHotSigmas * std::max(scatter.sigma, kSmallestScatterDn);
      for (int y = 0; y < values.height(); ++y) {
        for (int x = 0; x < values.width(); ++x) {
          if (std::abs(values(x, y) - scatter.median) <= limit) continue;
          hot_(2 * x + (lattice & 1), 2 * y + (lattice >> 1)) = kPhotositeHot;
        }
      }
    }
  }
}

void BlackFrames::FindTemporalVariance() {
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t k = 0; k < hot_.size(); ++k) {
      if (hot_.data()[k] != 0) continue;
      sum += squares_[i].data()[k];
      ++count;
    }
    const int degrees = levels_[i].frames - 1;
    levels_[i].temporal_variance = degrees > 0 && count > 0 ? sum / (static_cast<double>(count) * degrees)
                                                            : std::numeric_limits<double>::quiet_NaN();
  }
}

double BlackFrames::hot_share() const {
  const auto count = std::count_if(hot_.values().begin(), hot_.values().end(), [](auto m) { return m != 0; });
  return static_cast<double>(count) / static_cast<double>(hot_.size());
}

BlackFrames::Match BlackFrames::Find(double exposure_ms, int iso) const {
  const auto distance = [&](const BlackReference& level) {
    // ISO scales the offset's noise and the read noise, exposure only the dark current: ISO first.
    return 1000.0 * std::abs(std::log(double(level.iso) / iso)) +
           std::abs(std::log(level.exposure_ms / exposure_ms));
  };
  const auto nearest = std::min_element(levels_.begin(), levels_.end(), [&](const auto& a, const auto& b) {
    return distance(a) < distance(b);
  });
  Match match{&*nearest, ""};
  if (nearest->exposure_ms != exposure_ms || nearest->iso != iso) {
    match.note = "no black frame at " + Short(exposure_ms) + " ms, ISO " + std::to_string(iso) +
                 ": the nearest was subtracted (" + Short(nearest->exposure_ms) + " ms, ISO " +
                 std::to_string(nearest->iso) + ")";
  }
  return match;
}

SignalFrame ReadSignal(const FrameRecord& record, const FrameReader& read, const BlackFrames& blacks) {
  const BayerFrame frame = read(record);
  CheckSensor(record, frame, blacks.sensor());
  const BlackFrames::Match match = blacks.Find(record.exposure_ms, record.iso);
  SignalFrame out{record,       match.level, PlaneF(frame.values.width(), frame.values.height()),
                  blacks.hot(), 0.0,         {}};
  if (!match.note.empty()) out.notes.push_back(match.note);
  if (frame.iso > 0 && record.iso > 0 && frame.iso != record.iso) {
    out.notes.push_back(record.file + " itself says ISO " + std::to_string(frame.iso) +
                        ", the session says ISO " + std::to_string(record.iso));
  }
  for (std::size_t i = 0; i < frame.values.size(); ++i) {
    out.signal.data()[i] = static_cast<float>(frame.values.data()[i]) - match.level->mean.data()[i];
  }
  MarkSaturated(frame, out);
  return out;
}

void MarkDead(const PlaneF& spectralon, MaskPlane& mask) {
  for (int lattice = 0; lattice < kLatticeCount; ++lattice) {
    PlaneF values = Lattice(spectralon, lattice);
    PlaneF around(values.width(), values.height());
    const cv::Mat in(values.height(), values.width(), CV_32F, values.data());
    cv::Mat out(values.height(), values.width(), CV_32F, around.data());
    cv::medianBlur(in, out, 5);
    std::vector<float> difference(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) difference[i] = values.data()[i] - around.data()[i];
    const double scatter = std::max(MedianAndScatter(difference).sigma, kSmallestScatterDn);
    for (int y = 0; y < values.height(); ++y) {
      for (int x = 0; x < values.width(); ++x) {
        const double off = std::abs(values(x, y) - around(x, y));
        if (off > kDeadDeviation * around(x, y) && off > kDeadSigmas * scatter) {
          mask(2 * x + (lattice & 1), 2 * y + (lattice >> 1)) |= kPhotositeDead;
        }
      }
    }
  }
}

}  // namespace dermap
