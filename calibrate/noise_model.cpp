// SPDX-License-Identifier: Apache-2.0
// Photon transfer by frame differences, and the weighted line through its points.
#include "calibrate/noise_model.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "calibrate/statistics.h"
#include "common/core/error.h"

namespace dermap {
namespace {

constexpr int kFewestSamples = 50;
constexpr double kRoundingVariance = 1.0 / 12.0;  // of one step: no camera reads better
constexpr int kReweightings = 5;
constexpr double kVagueSlope = 0.25;  // one standard deviation, relative: points at one level tell no slope
// Relative scatter of cameras' gains about the ratio of their ISO values.
constexpr double kGainScatter = 0.03;

// Differences between neighbours of one kind: whatever varies slowly over the card drops out.
// value(x, y) is called where both photosites are usable.
template <class Value, class Usable>
PhotonTransferPoint PointOfKind(int kind, int period, const PixelRegion& card, const Value& value,
                                const Usable& usable) {
  std::vector<float> halves;
  for (int y = card.y + kind / period; y < card.y + card.height; y += period) {
    for (int x = card.x + kind % period; x + period < card.x + card.width; x += period) {
      if (!usable(x, y) || !usable(x + period, y)) continue;
      halves.push_back(static_cast<float>((value(x, y) - value(x + period, y)) / std::sqrt(2.0)));
    }
  }
  PhotonTransferPoint point;
  // Differences that share a photosite count less: the variance of their mean square is 3 / n, not 2 / n.
  point.samples = static_cast<int>(halves.size() * 2 / 3);
  if (point.samples >= kFewestSamples) point.variance = ClippedVariance(halves);
  return point;
}

double MeanOfKind(int kind, int period, const PixelRegion& card, const SignalFrame& frame) {
  double sum = 0.0;
  double count = 0.0;
  for (int y = card.y + kind / period; y < card.y + card.height; y += period) {
    for (int x = card.x + kind % period; x < card.x + card.width; x += period) {
      if (frame.mask(x, y) != 0) continue;
      sum += frame.signal(x, y);
      count += 1.0;
    }
  }
  return count > 0.0 ? sum / count : 0.0;
}

struct Line {
  double slope, offset, slope_variance;
};

// Least squares of variance = slope signal + offset reads; a variance of n samples has the variance 2
// variance^2 / n.
Line WeightedLine(const std::vector<PhotonTransferPoint>& points, const Line* expected) {
  double ss = 0, sr = 0, rr = 0, sv = 0, rv = 0;
  for (const auto& p : points) {
    const double v =
        expected != nullptr ? expected->slope * p.signal + expected->offset * p.reads : p.variance;
    const double weight = p.samples / (2.0 * v * v);
    ss += weight * p.signal * p.signal;
    sr += weight * p.signal * p.reads;
    rr += weight * p.reads * p.reads;
    sv += weight * p.signal * p.variance;
    rv += weight * p.reads * p.variance;
  }
  const double determinant = ss * rr - sr * sr;
  const Line slope_alone{(sv - kRoundingVariance * sr) / ss, kRoundingVariance, 1.0 / ss};
  if (!(determinant > 1e-9 * ss * rr)) return slope_alone;
  const Line line{(sv * rr - rv * sr) / determinant, (rv * ss - sv * sr) / determinant, rr / determinant};
  // All points at about one level (a sensor without filters), or an offset below what rounding alone makes.
  const bool one_level = std::sqrt(line.slope_variance) > kVagueSlope * std::abs(slope_alone.slope);
  if (one_level || line.offset < kRoundingVariance) return slope_alone;
  return line;
}

// Gain goes as ISO, nearly: what all ISO values say together about the gain at ISO 1 helps each of them.
void ShareGain(const std::map<int, double>& gain_variances, std::map<int, NoiseModel>& models) {
  double sum = 0.0;
  double total = 0.0;
  for (const auto& [iso, model] : models) {
    const double relative = gain_variances.at(iso) / (model.gain * model.gain) + kGainScatter * kGainScatter;
    const double unit_gain = model.gain / iso;
    const double weight = 1.0 / (relative * unit_gain * unit_gain);
    sum += weight * unit_gain;
    total += weight;
  }
  for (auto& [iso, model] : models) {
    const double common = iso * sum / total;
    const double own_weight = 1.0 / gain_variances.at(iso);
    const double common_weight = 1.0 / std::pow(kGainScatter * common, 2);
    model.gain = (own_weight * model.gain + common_weight * common) / (own_weight + common_weight);
  }
}

}  // namespace

std::vector<PhotonTransferPoint> PhotonTransfer(const SignalFrame& a, const SignalFrame& b, int frames_b,
                                                const PixelRegion& card) {
  assert(a.record.iso == b.record.iso);
  std::vector<PhotonTransferPoint> points;
  const double k = CompareGrayCard(a, b, card).ratio;
  const int period = a.period;
  for (int kind = 0; kind < period * period; ++kind) {
    PhotonTransferPoint point = PointOfKind(
        kind, period, card, [&](int x, int y) { return a.signal(x, y) - k * b.signal(x, y); },
        [&](int x, int y) { return a.mask(x, y) == 0 && b.mask(x, y) == 0; });
    if (point.samples < kFewestSamples) continue;
    point.iso = a.record.iso;
    const double mean_a = MeanOfKind(kind, period, card, a);
    const double mean_b = MeanOfKind(kind, period, card, b);
    point.signal = std::max(0.0, mean_a + k * k * mean_b / frames_b);
    // Another black frame was subtracted from each, or the same one: then its noise cancels but for (1 - k).
    const double black = a.black == b.black ? (1 - k) * (1 - k) / a.black->frames
                                            : 1.0 / a.black->frames + k * k / b.black->frames;
    point.reads = 1.0 + k * k / frames_b + black;
    points.push_back(point);
  }
  return points;
}

std::vector<PhotonTransferPoint> PhotonTransferOfOne(const SignalFrame& frame, const PixelRegion& card) {
  std::vector<PhotonTransferPoint> points;
  const int period = frame.period;
  for (int kind = 0; kind < period * period; ++kind) {
    PhotonTransferPoint point = PointOfKind(
        kind, period, card, [&](int x, int y) { return frame.signal(x, y); },
        [&](int x, int y) { return frame.mask(x, y) == 0; });
    if (point.samples < kFewestSamples) continue;
    point.iso = frame.record.iso;
    point.signal = std::max(0.0, MeanOfKind(kind, period, card, frame));
    point.reads = 1.0 + 1.0 / frame.black->frames;
    points.push_back(point);
  }
  return points;
}

std::vector<PhotonTransferPoint> PhotonTransferOfBlack(const BlackFrames& blacks) {
  std::vector<PhotonTransferPoint> points;
  for (const BlackReference& level : blacks.levels()) {
    if (level.frames < 2) continue;
    const double degrees =
        static_cast<double>(level.frames - 1) * static_cast<double>(level.mean_steps.size());
    points.push_back(
        {level.iso, 0.0, 1.0, level.temporal_variance, static_cast<int>(std::min(degrees, 1e9))});
  }
  return points;
}

std::map<int, NoiseModel> FitNoise(const std::vector<PhotonTransferPoint>& points) {
  std::map<int, std::vector<PhotonTransferPoint>> by_iso;
  for (const auto& point : points) {
    if (point.samples >= kFewestSamples && point.variance > 0.0) by_iso[point.iso].push_back(point);
  }
  std::map<int, NoiseModel> models;
  std::map<int, double> gain_variances;
  for (const auto& [iso, own] : by_iso) {
    const bool lit = std::any_of(own.begin(), own.end(), [](const auto& p) { return p.signal > 0.0; });
    if (!lit) continue;  // black frames alone
    Line line = WeightedLine(own, nullptr);
    for (int i = 0; i < kReweightings && line.slope > 0.0; ++i) line = WeightedLine(own, &line);
    if (!(line.slope > 0.0)) {
      throw InputError(
          "the gray card's noise at ISO " + std::to_string(iso) +
          " does not grow with its brightness, as shot noise must; expected untouched raw frames of a card "
          "that stands still: check the rig's gray_card_region and that the camera reduces no noise");
    }
    models[iso] = {line.slope, line.offset, static_cast<int>(own.size())};
    gain_variances[iso] = line.slope_variance;
  }
  ShareGain(gain_variances, models);
  return models;
}

}  // namespace dermap
