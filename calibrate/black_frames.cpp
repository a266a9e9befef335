// SPDX-License-Identifier: Apache-2.0
// Means of black frames [D08 6.2], and photosites that stand out of them.
#include "calibrate/black_frames.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/failure.h"
#include "calibrate/frame_picture.h"
#include "calibrate/statistics.h"
#include "common/core/parallel.h"

namespace dermap {
namespace {

constexpr double kSmallestScatterDn = 0.75;  // where rounding hides the scatter
constexpr double kHotSigmas = 8.0;           // of the robust scatter among photosites of one colour
constexpr double kFineSteps = 20000.0;  // white level above which steps of 1/16 DN would not reach far enough
constexpr std::size_t kReadAhead = 2;   // black frames decoded at once
constexpr int kStrips = 8;              // of a frame, for threads
constexpr double kLitBlack = 0.03;      // of full scale, mean
constexpr double kDarkShare = 0.01;     // of a frame's photosites: darkness, where the file states none

std::string Shape(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

struct StepScatter {
  double median = 0.0, sigma = 0.0;  // robust, in steps
};

// By counting: black frames take few different values.
StepScatter MedianOfSteps(const Plane<std::uint16_t>& steps, int lattice, int stride) {
  std::vector<std::uint32_t> histogram(65536, 0);
  std::uint32_t total = 0;
  for (int y = lattice >> 1; y < steps.height(); y += stride) {
    for (int x = lattice & 1; x < steps.width(); x += stride) {
      ++histogram[steps(x, y)];
      ++total;
    }
  }
  const auto median_of = [&](const std::vector<std::uint32_t>& counts) {
    std::uint32_t below = 0;
    std::size_t i = 0;
    while (i + 1 < counts.size() && 2 * (below + counts[i]) < total) below += counts[i++];
    return i;
  };
  const std::size_t median = median_of(histogram);
  std::vector<std::uint32_t> deviations(65536, 0);
  for (std::size_t i = 0; i < histogram.size(); ++i)
    deviations[i > median ? i - median : median - i] += histogram[i];
  return {double(median), 1.4826 * double(median_of(deviations))};
}

// Sums over the black frames of one level.
struct BlackSums {
  Plane<std::uint32_t> sum;
  PlaneF squares;  // sum of squared deviations from the running mean (Welford), from the second frame on
  int frames = 0;

  void Add(const BayerFrame& frame) {
    if (frames == 0) sum = Plane<std::uint32_t>(frame.values.width(), frame.values.height());
    if (frames == 1) squares = PlaneF(sum.width(), sum.height());
    const auto before = static_cast<float>(frames);
    ++frames;
    ParallelFor(kStrips, [&](int strip) {
      const std::size_t first = sum.size() * strip / kStrips, last = sum.size() * (strip + 1) / kStrips;
      const std::uint16_t* values = frame.values.data();
      if (frames > 1) {
        const float per_frame = 1.0f / before, share = before / (before + 1.0f);
        for (std::size_t k = first; k < last; ++k) {
          const float delta = static_cast<float>(values[k]) - static_cast<float>(sum.data()[k]) * per_frame;
          squares.data()[k] += delta * delta * share;
        }
      }
      for (std::size_t k = first; k < last; ++k) sum.data()[k] += values[k];
    });
  }

  Plane<std::uint16_t> MeanIn(float step_dn) const {
    Plane<std::uint16_t> mean(sum.width(), sum.height());
    const float to_steps = 1.0f / (step_dn * static_cast<float>(frames));
    for (std::size_t k = 0; k < sum.size(); ++k) {
      const float steps = static_cast<float>(sum.data()[k]) * to_steps;
      mean.data()[k] = static_cast<std::uint16_t>(std::min(steps + 0.5f, 65535.0f));
    }
    return mean;
  }

  // Of one frame, from frame to frame; NaN with one frame.
  double Variance(const MaskPlane& hot) const {
    double total = 0.0;
    double count = 0.0;
    for (std::size_t k = 0; k < squares.size(); ++k) {
      if (hot.data()[k] != 0) continue;
      total += squares.data()[k];
      count += 1.0;
    }
    return count > 0.0 ? total / (count * (frames - 1)) : std::numeric_limits<double>::quiet_NaN();
  }
};

// What the frame's darkest photosites show: some cameras' files state no black level.
double DarkLevel(const BayerFrame& frame) {
  if (frame.black_level > 0.0) return frame.black_level;
  std::vector<std::uint16_t> values(frame.values.values().begin(), frame.values.values().end());
  const auto dark = values.begin() + static_cast<std::ptrdiff_t>(kDarkShare * double(values.size()));
  std::nth_element(values.begin(), dark, values.end());
  return *dark;
}

// A lit frame in a black one's place would be subtracted from everything.
void CheckBlack(const RigConfig& rig, const FrameRecord& record, const BayerFrame& frame) {
  std::uint64_t sum = 0;
  for (const auto v : frame.values.values()) sum += v;
  const double mean = double(sum) / static_cast<double>(frame.values.size());
  const double black = DarkLevel(frame);
  const double share = (mean - black) / (frame.white_level - black);
  if (share < kLitBlack) return;
  PlaneF signal(frame.values.width(), frame.values.height());
  for (std::size_t i = 0; i < signal.size(); ++i)
    signal.data()[i] = static_cast<float>(frame.values.data()[i] - black);
  throw CaptureFailure(
      record.file + ": this black frame is lit (" + Short(100 * share) +
          " % of full scale on average); expected darkness through the wheel's opaque slot: was a skin or "
          "Spectralon frame put in its place? Restore it or capture it again",
      FailurePicture(signal, GrayCardRegion(rig, signal.width(), signal.height())));
}

}  // namespace

void CheckSensor(const FrameRecord& record, const BayerFrame& frame, const SensorFormat& sensor) {
  if (!frame.values.SameShape(sensor.width, sensor.height)) {
    throw InputError(
        record.file + ": " + Shape(frame.values.width(), frame.values.height()) +
        " photosites, but the session's first black frame has " + Shape(sensor.width, sensor.height) +
        "; all frames of a session must come from one camera at one size: capture this frame again");
  }
  if (frame.colours != sensor.colours || frame.period != sensor.period ||
      frame.white_level != sensor.white_level) {
    throw InputError(
        record.file +
        ": another filter pattern or white level than the session's first black frame; all "
        "frames of a session must come from one camera at one setting: capture this frame again");
  }
}

BlackFrames::BlackFrames(const Session& session, const FrameReader& read, const SignalOptions& options)
    : options_(options) {
  for (const FrameRecord& record : session.frames) {
    if (record.role != FrameRole::kBlack) continue;
    const bool known = std::any_of(levels_.begin(), levels_.end(), [&](const BlackReference& level) {
      return level.exposure_ms == record.exposure_ms && level.iso == record.iso;
    });
    if (!known) AddLevel(session, read, record.exposure_ms, record.iso);
  }
  if (levels_.empty()) {
    throw InputError(session.directory.string() +
                     ": the session has no black frame; at least one through the wheel's "
                     "opaque slot is needed: capture it with the same plan");
  }
}

// One exposure and ISO at a time, so that sums live no longer than needed.
void BlackFrames::AddLevel(const Session& session, const FrameReader& read, double exposure_ms, int iso) {
  std::vector<const FrameRecord*> records;
  for (const FrameRecord& record : session.frames) {
    if (record.role == FrameRole::kBlack && record.exposure_ms == exposure_ms && record.iso == iso)
      records.push_back(&record);
  }
  BlackSums sums;
  std::array<BayerFrame, kReadAhead> ahead;
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (i % kReadAhead == 0) {
      ParallelFor(static_cast<int>(std::min(kReadAhead, records.size() - i)), [&](int k) {
        ahead[static_cast<std::size_t>(k)] = read(*records[i + static_cast<std::size_t>(k)]);
      });
    }
    const BayerFrame& frame = ahead[i % kReadAhead];
    if (hot_.empty()) {
      sensor_ = {frame.values.width(), frame.values.height(), frame.colours, frame.period, frame.white_level};
      hot_ = MaskPlane(sensor_.width, sensor_.height, 0);
    }
    CheckSensor(*records[i], frame, sensor_);
    CheckBlack(session.rig, *records[i], frame);
    sums.Add(frame);
  }
  BlackReference level;
  level.exposure_ms = exposure_ms;
  level.iso = iso;
  level.frames = sums.frames;
  level.step_dn = sensor_.white_level > kFineSteps ? 0.25f : 1.0f / 16.0f;
  level.mean_steps = sums.MeanIn(level.step_dn);
  FindHotPhotosites(level);
  level.level_dn = level.step_dn * MedianOfSteps(level.mean_steps, 0, 1).median;
  level.temporal_variance = sums.Variance(hot_);
  levels_.push_back(std::move(level));
}

void BlackFrames::FindHotPhotosites(const BlackReference& level) {
  if (!options_.mask_hot) return;
  for (int lattice = 0; lattice < kLatticeCount; ++lattice) {
    const StepScatter scatter = MedianOfSteps(level.mean_steps, lattice, 2);
    const double limit =
        kHotSigmas * std::max(double(level.step_dn) * scatter.sigma, kSmallestScatterDn) / level.step_dn;
    for (int y = lattice >> 1; y < sensor_.height; y += 2) {
      for (int x = lattice & 1; x < sensor_.width; x += 2) {
        if (std::abs(level.mean_steps(x, y) - scatter.median) > limit) hot_(x, y) = kPhotositeHot;
      }
    }
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

}  // namespace dermap
