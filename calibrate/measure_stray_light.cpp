// SPDX-License-Identifier: Apache-2.0
// Lines through what the tape seems to reflect over the frames' means: one a stretch of tape, of one slope.
#include "calibrate/measure_stray_light.h"

#include <algorithm>
#include <cmath>

#include "calibrate/corrections.h"
#include "calibrate/linearity.h"
#include "calibrate/statistics.h"
#include "calibrate/stray_light.h"
#include "calibrate/target_frames.h"
#include "common/core/error.h"

namespace dermap {
namespace {

constexpr double kFewestOfStretch = 20;  // photosites
constexpr double kDifferent = 0.05;      // of white: means of a bright and of a dark target's frame
constexpr double kMostSigma = 0.004;     // of the share
constexpr double kUneven = 0.006;        // of the share, by one stretch of tape against all
constexpr double kNegative = 3.0;        // sigmas
constexpr double kDarkTarget = 0.1;      // reflectance
constexpr int kRounds = 6;

struct LinePoint {
  double by_share = 0.0;  // what a share of 1 would add to what the tape seems to reflect
  double seems = 0.0;
  double sigma = 0.0;
};

// Sums for the slope of a line; lines of one slope add up.
struct Line {
  double covariance = 0.0, variance = 0.0, noise = 0.0;
  double intercept = 0.0;
  double slope() const { return covariance / variance; }
};

Line LineThrough(const std::vector<LinePoint>& points) {
  const auto count = static_cast<double>(points.size());
  double mean_x = 0.0, mean_y = 0.0;
  for (const LinePoint& p : points) {
    mean_x += p.by_share / count;
    mean_y += p.seems / count;
  }
  Line line;
  for (const LinePoint& p : points) {
    line.covariance += (p.by_share - mean_x) * (p.seems - mean_y);
    line.variance += (p.by_share - mean_x) * (p.by_share - mean_x);
    line.noise += std::pow(p.sigma * (p.by_share - mean_x), 2);
  }
  line.intercept = mean_y - line.slope() * mean_x;
  return line;
}

// Reflectance of a photosite for which target and Spectralon give equal signals.
double ScaleOf(const BandTargets& band, const TargetFrame& frame, double share) {
  return band.white / CardRatioWithout(share, frame.means, frame.card);
}

// What a frame's offset against its black frames makes of a region's reflectance, one standard deviation.
double OffsetSigma(const RegionSignals& region, double scale) {
  return scale * kBlackDrift_dn * region.count / region.spectralon;
}

// scale (skin - share mean_skin) = tape (spectralon - share mean_spectralon), scale itself freed of stray
// light.
LinePoint PointOf(const BandTargets& band, const TargetFrame& frame, const RegionSignals& region,
                  double share, double tape) {
  const double scale = ScaleOf(band, frame, share);
  return {(scale * region.skin_mean - tape * region.spectralon_mean) / region.spectralon,
          scale * region.skin / region.spectralon, OffsetSigma(region, scale)};
}

RegionSignals WholeTape(const TapeSignals& tape) {
  RegionSignals whole;
  for (const RegionSignals& stretch : tape) whole.Add(stretch);
  return whole;
}

// Of one stretch, or of the whole tape, in all frames of a band; and black tape's own point, where it is
// stated.
template <class Region>
std::vector<LinePoint> PointsOf(const BandTargets& band, const Region& region_of, double share, double tape,
                                const std::optional<Known>& stated) {
  std::vector<LinePoint> points;
  if (stated) points.push_back({0.0, stated->value, stated->sigma});
  for (const TargetFrame& frame : band.frames) {
    const RegionSignals region = region_of(frame);
    if (region.count >= kFewestOfStretch && region.spectralon > 0.0)
      points.push_back(PointOf(band, frame, region, share, tape));
  }
  return points;
}

// The lines of all stretches of tape that are seen, by the share and the tape's reflectance so far.
std::vector<Line> LinesOf(const BandTargets& band, double share, double tape,
                          const std::optional<Known>& stated) {
  std::vector<Line> lines;
  for (std::size_t j = 0; j < kTapeStretches; ++j) {
    const auto stretch = [&](const TargetFrame& frame) { return frame.tape[j]; };
    const std::vector<LinePoint> points = PointsOf(band, stretch, share, tape, stated);
    const Line line = points.size() > 1 ? LineThrough(points) : Line{};
    if (line.variance > 0.0) lines.push_back(line);
  }
  if (lines.size() > 1) return lines;
  throw InputError(band.frames[0].file +
                   ": too little tape is seen around the window; expected tape in view and lit, an eighth of "
                   "the window's side wide, in every frame");
}

// Tape that moved lets a target be seen in its place, on one side.
void CheckEven(const BandTargets& band, const std::vector<Line>& lines, double share) {
  for (const Line& line : lines) {
    if (std::abs(line.slope() - share) < kUneven) continue;
    throw InputError(band.frames[0].file + ": a stretch of tape tells a stray light of " +
                     Short(100 * line.slope()) + " %, all of it one of " + Short(100 * share) +
                     " %; expected the same all around the window: the tape moved between the targets, or "
                     "something shades it: capture both anew");
  }
}

StrayLightBand ShareOf(const BandTargets& band, const std::optional<Known>& stated) {
  StrayLightBand found;
  found.wavelength_nm = band.band.wavelength_nm;
  std::vector<Line> lines;
  Line sum;
  for (int round = 0; round < kRounds; ++round) {
    lines = LinesOf(band, found.share.value, found.tape, stated);
    sum = {};
    for (const Line& line : lines) {
      sum.covariance += line.covariance;
      sum.variance += line.variance;
      sum.intercept += line.intercept / static_cast<double>(lines.size());
    }
    found.share.value = sum.slope();
    found.tape = sum.intercept;
  }
  if (!stated) CheckEven(band, lines, found.share.value);  // else texture counts
  // What stretches differ by, texture that moved and light that is not spread evenly, and what they share.
  double scatter = 0.0;
  for (const Line& line : lines) scatter += std::pow(line.covariance - found.share.value * line.variance, 2);
  const auto count = static_cast<double>(lines.size());
  const auto whole = [](const TargetFrame& frame) { return WholeTape(frame.tape); };
  const Line all = LineThrough(PointsOf(band, whole, found.share.value, found.tape, stated));
  found.share.sigma = std::hypot(std::sqrt(scatter * count / (count - 1.0)) / sum.variance,
                                 std::sqrt(all.noise) / all.variance);
  return found;
}

void SetBrightness(const BandTargets& band, StrayLightBand& found) {
  found.darkest = 1e9;
  for (const TargetFrame& frame : band.frames) {
    const double mean = PointOf(band, frame, WholeTape(frame.tape), 0.0, 0.0).by_share;
    found.darkest = std::min(found.darkest, mean);
    found.brightest = std::max(found.brightest, mean);
  }
}

// By inverse variance; bands that agree worse than they say widen the error.
Known Mean(const std::vector<Known>& values) {
  constexpr double kLeastSigma = 1e-9;
  double sum = 0.0, total = 0.0, chi2 = 0.0;
  for (const Known& v : values) {
    const double weight = std::pow(std::max(kLeastSigma, v.sigma), -2);
    sum += weight * v.value;
    total += weight;
  }
  for (const Known& v : values) chi2 += std::pow((v.value - sum / total) / std::max(kLeastSigma, v.sigma), 2);
  const double degrees = std::max(1.0, static_cast<double>(values.size()) - 1.0);
  return {sum / total, std::sqrt(std::max(1.0, chi2 / degrees) / total)};
}

double MiddleReflectance(const BandTargets& band, const TargetFrame& frame, double share) {
  const RegionSignals& m = frame.middle;
  return ScaleOf(band, frame, share) * (m.skin - share * m.skin_mean) /
         (m.spectralon - share * m.spectralon_mean);
}

// What the darkest target shows beyond what comes from below its surface; sigma by the frame's offset.
Known LeakOf(const BandTargets& band, double share, double from_below) {
  const auto darkest = std::ranges::min_element(
      band.frames, {}, [&](const TargetFrame& f) { return MiddleReflectance(band, f, share); });
  const double found = MiddleReflectance(band, *darkest, share);
  if (!(found < kDarkTarget)) {
    throw InputError(darkest->file + ": the darkest target reflects " + Short(found) +
                     "; expected a black one, below " + Short(kDarkTarget) +
                     ", for the leak to be told: add its frames (--dark-target SESSION), or leave out "
                     "--dark-reflectance");
  }
  return {found - from_below, OffsetSigma(darkest->middle, ScaleOf(band, *darkest, share))};
}

Known MeasureLeak(const std::vector<BandTargets>& targets, const RigOptics& optics, const Known& share,
                  const Known& dark_target, std::vector<StrayLightBand>& bands) {
  const PolarizationConfig polarization = optics.polarization.value_or(PolarizationConfig{});
  std::vector<Known> leaks;
  double by_share = 0.0, of_target = 0.0;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    // How far light from below varies with the polarizer is known of skin alone: it counts as uncertainty.
    const double varies =
        std::abs(1.0 / LeakInReflectance(polarization, targets[i].band.wavelength_nm, true) - 1.0);
    leaks.push_back(LeakOf(targets[i], share.value, dark_target.value));
    bands[i].leak = leaks.back();
    by_share =
        std::max(by_share, std::abs(LeakOf(targets[i], share.value + share.sigma, dark_target.value).value -
                                    leaks.back().value));
    of_target = std::max(of_target, std::hypot(dark_target.sigma, varies * dark_target.value));
  }
  const Known mean = Mean(leaks);
  const double of_white = optics.polarization ? polarization.spectralon_sigma * mean.value : 0.0;
  return {mean.value, std::hypot(std::hypot(mean.sigma, by_share), std::hypot(of_target, of_white))};
}

// Within its error a negative share is none.
Known NotNegative(const Known& found, const std::string& what, const std::string& remedy) {
  if (found.value >= -kNegative * found.sigma) return {std::max(0.0, found.value), found.sigma};
  throw InputError(what + " comes out at " + Short(100 * found.value) + " +- " + Short(100 * found.sigma) +
                   " %, less than none: " + remedy);
}

void CheckTold(const Known& share, const std::vector<StrayLightBand>& bands) {
  if (share.sigma <= kMostSigma) return;
  throw InputError(
      "the lens's share of stray light is told to " + Short(100 * share.sigma) +
      " % only, by frames that are between " +
      Short(100 * std::ranges::min_element(bands, {}, &StrayLightBand::darkest)->darkest) + " and " +
      Short(100 * std::ranges::max_element(bands, {}, &StrayLightBand::brightest)->brightest) +
      " % as bright as white; expected a white and a black target behind a window in tape that stays where "
      "it is: capture both anew");
}

}  // namespace

StrayLightMeasurement MeasureStrayLight(const Session& session, const FrameReader& read,
                                        const std::optional<Known>& dark_target) {
  BlackFrames blacks(session, read);
  const PixelRegion card = GrayCardRegion(session.rig, blacks.sensor().width, blacks.sensor().height);
  const Linearity linearity = FindLinearity(session, read, blacks, card);
  if (linearity.used) blacks.SetNonlinearity(linearity.used->value);
  const std::vector<BandTargets> targets = ReadTargets(session, read, blacks, card);
  const RigOptics& optics = session.rig.optics;
  StrayLightMeasurement found;
  bool differ = true;
  for (const BandTargets& band : targets) {
    StrayLightBand one;
    SetBrightness(band, one);
    differ = differ && one.brightest - one.darkest > kDifferent;
  }
  if (!differ && !optics.tape_reflectance) {
    throw InputError(
        session.directory.string() +
        ": all targets are equally bright, and the rig states no tape_reflectance; expected a "
        "white and a black one behind the same window: add the other one's frames (--dark-target "
        "SESSION)");
  }
  std::optional<Known> stated = optics.tape_reflectance;
  if (differ) stated.reset();
  std::vector<Known> shares;
  for (const BandTargets& band : targets) {
    found.bands.push_back(ShareOf(band, stated));
    SetBrightness(band, found.bands.back());
    shares.push_back(found.bands.back().share);
  }
  found.share = Mean(shares);
  // What bands have in common does not average out.
  const double of_tape = stated ? std::ranges::min_element(shares, {}, &Known::sigma)->sigma : 0.0;
  const double of_linearity = linearity.used ? linearity.used->sigma * found.share.value : 0.0;
  found.share.sigma = std::hypot(std::hypot(found.share.sigma, of_tape), of_linearity);
  CheckTold(found.share, found.bands);
  found.share = NotNegative(found.share, "the lens's share of stray light",
                            "the tape moved between the targets, or the gray card's region is wrong");
  if (dark_target) {
    const Known leak = MeasureLeak(targets, optics, found.share, *dark_target, found.bands);
    found.leak = NotNegative(leak, "the leak", "the dark target reflects less than --dark-reflectance says");
  }
  return found;
}

std::string StrayLightToml(const StrayLightMeasurement& measurement) {
  std::string toml =
      "# Measured by dermap calibrate --stray-light: put these keys into the tables of rig.toml.\n"
      "[calibration]\n";
  toml += "stray_light = " + Short(measurement.share.value) + "\n";
  toml += "stray_light_sigma = " + Short(measurement.share.sigma) + "\n";
  if (!measurement.leak) return toml;
  toml += "\n[polarization]\n";
  toml += "leak = " + Short(measurement.leak->value) + "\n";
  toml += "leak_sigma = " + Short(measurement.leak->sigma) + "\n";
  return toml;
}

}  // namespace dermap
