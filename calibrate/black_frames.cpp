// SPDX-License-Identifier: Apache-2.0
// Means of black frames [D08 6.2], and photosites that stand out of them.
#include "calibrate/black_frames.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "calibrate/failure.h"
#include "calibrate/frame_picture.h"
#include "calibrate/statistics.h"
#include "common/core/kernel.h"
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

// Black frames take few different values: medians are found by counting.
using Histogram = std::vector<std::uint32_t>;

Histogram HistogramOf(const Plane<std::uint16_t>& steps, int lattice) {
  Histogram histogram(65536, 0);
  for (int y = lattice >> 1; y < steps.height(); y += 2) {
    const std::uint16_t* row = steps.Row(y);
    for (int x = lattice & 1; x < steps.width(); x += 2) ++histogram[row[x]];
  }
  return histogram;
}

std::size_t MedianOf(const Histogram& counts) {
  const std::uint64_t total = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  std::uint64_t below = 0;
  std::size_t i = 0;
  while (i + 1 < counts.size() && 2 * (below + counts[i]) < total) below += counts[i++];
  return i;
}

StepScatter ScatterOf(const Histogram& histogram) {
  const std::size_t median = MedianOf(histogram);
  Histogram deviations(histogram.size(), 0);
  for (std::size_t i = 0; i < histogram.size(); ++i)
    deviations[i > median ? i - median : median - i] += histogram[i];
  return {double(median), 1.4826 * double(MedianOf(deviations))};
}

// One more frame: its values into the sums and, from the second on (Welford), the squared deviations.
DERMAP_KERNEL void AddValues(const std::uint16_t* values, std::size_t count, std::uint32_t* sum) {
  for (std::size_t k = 0; k < count; ++k) sum[k] += values[k];
}

DERMAP_KERNEL void AddValuesAndSquares(const std::uint16_t* values, std::size_t count, float frames_before,
                                       std::uint32_t* sum, float* squares) {
  const float per_frame = 1.0f / frames_before, share = frames_before / (frames_before + 1.0f);
  for (std::size_t k = 0; k < count; ++k) {
    const float delta =
        static_cast<float>(values[k]) - static_cast<float>(static_cast<std::int32_t>(sum[k])) * per_frame;
    squares[k] += delta * delta * share;
    sum[k] += values[k];
  }
}

DERMAP_KERNEL void ToSteps(const std::uint32_t* sum, std::size_t count, float to_steps,
                           std::uint16_t* steps) {
  for (std::size_t k = 0; k < count; ++k) {
    const float value = static_cast<float>(static_cast<std::int32_t>(sum[k])) * to_steps + 0.5f;
    steps[k] = static_cast<std::uint16_t>(static_cast<std::int32_t>(value < 65535.0f ? value : 65535.0f));
  }
}

// Calls body(first, count) for strips of `size` photosites, in parallel.
template <class Body>
void ForStrips(std::size_t size, const Body& body) {
  ParallelFor(kStrips, [&](int strip) {
    const std::size_t first = size * static_cast<std::size_t>(strip) / kStrips;
    body(strip, first, size * static_cast<std::size_t>(strip + 1) / kStrips - first);
  });
}

// Sums over the black frames of one level.
struct BlackSums {
  Plane<std::uint32_t> sum;
  PlaneF squares;  // of deviations from the running mean, from the second frame on
  int frames = 0;

  void Add(const BayerFrame& frame) {
    if (frames == 0) sum = Plane<std::uint32_t>(frame.values.width(), frame.values.height());
    if (frames == 1) squares = PlaneF(sum.width(), sum.height());
    ForStrips(sum.size(), [&](int, std::size_t first, std::size_t count) {
      const std::uint16_t* values = frame.values.data() + first;
      if (frames == 0) return AddValues(values, count, sum.data() + first);
      AddValuesAndSquares(values, count, static_cast<float>(frames), sum.data() + first,
                          squares.data() + first);
    });
    ++frames;
  }

  Plane<std::uint16_t> MeanIn(float step_dn) const {
    Plane<std::uint16_t> mean(sum.width(), sum.height());
    const float to_steps = 1.0f / (step_dn * static_cast<float>(frames));
    ForStrips(sum.size(), [&](int, std::size_t first, std::size_t count) {
      ToSteps(sum.data() + first, count, to_steps, mean.data() + first);
    });
    return mean;
  }

  // Of one frame, from frame to frame; NaN with one frame.
  double Variance(const MaskPlane& hot) const {
    std::array<double, kStrips> totals{}, counts{};
    ForStrips(squares.size(), [&](int strip, std::size_t first, std::size_t count) {
      const auto s = static_cast<std::size_t>(strip);
      for (std::size_t k = first; k < first + count; ++k) {
        const bool usable = hot.data()[k] == 0;
        totals[s] += usable ? squares.data()[k] : 0.0f;
        counts[s] += usable ? 1.0 : 0.0;
      }
    });
    const double count = std::accumulate(counts.begin(), counts.end(), 0.0);
    const double total = std::accumulate(totals.begin(), totals.end(), 0.0);
    return count > 0.0 ? total / (count * (frames - 1)) : std::numeric_limits<double>::quiet_NaN();
  }
};

// What the frame's darkest photosites show: some cameras' files state no black level.
double DarkLevel(const BayerFrame& frame) {
  if (frame.black_level > 0.0) return frame.black_level;
  Histogram counts(65536, 0);
  for (const std::uint16_t v : frame.values.values()) ++counts[v];
  const auto dark = static_cast<std::uint64_t>(kDarkShare * double(frame.values.size()));
  std::size_t value = 0;
  for (std::uint64_t below = counts[0]; below <= dark && value + 1 < counts.size();) below += counts[++value];
  return double(value);
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
      sensor_ = {frame.values.width(), frame.values.height(), frame.colours,
                 frame.period,         frame.white_level,     frame.black_level};
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
  level.level_dn = FindHotPhotosites(level);
  level.temporal_variance = sums.Variance(hot_);
  levels_.push_back(std::move(level));
}

double BlackFrames::FindHotPhotosites(const BlackReference& level) {
  std::array<Histogram, kLatticeCount> histograms;
  ParallelFor(kLatticeCount, [&](int lattice) {
    Histogram& own = histograms[static_cast<std::size_t>(lattice)];
    own = HistogramOf(level.mean_steps, lattice);
    if (!options_.mask_hot) return;
    const StepScatter scatter = ScatterOf(own);
    const double limit =
        kHotSigmas * std::max(double(level.step_dn) * scatter.sigma, kSmallestScatterDn) / level.step_dn;
    const double darkest = scatter.median - limit, brightest = scatter.median + limit;
    for (int y = lattice >> 1; y < sensor_.height; y += 2) {
      const std::uint16_t* steps = level.mean_steps.Row(y);
      for (int x = lattice & 1; x < sensor_.width; x += 2) {
        if (steps[x] < darkest || steps[x] > brightest) hot_(x, y) = kPhotositeHot;
      }
    }
  });
  Histogram all = histograms[0];
  for (std::size_t lattice = 1; lattice < kLatticeCount; ++lattice)
    std::transform(all.begin(), all.end(), histograms[lattice].begin(), all.begin(), std::plus<>());
  return level.step_dn * static_cast<double>(MedianOf(all));
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
