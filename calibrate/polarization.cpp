// SPDX-License-Identifier: Apache-2.0
// Means over the window's middle against the gray card, position against position.
#include "calibrate/polarization.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "calibrate/band_frames.h"
#include "calibrate/frame_checks.h"
#include "calibrate/statistics.h"
#include "common/core/error.h"

namespace dermap {
namespace {

constexpr double kMiddleFrom = 0.15;  // of the window's side: clear of the tape and of its shadow

struct Signals {
  std::vector<double> over_card;  // mean signal in the window's middle over that of the gray card
  std::vector<double> card;       // exposure and ISO taken out
};

double MeanInWindow(const SignalFrame& frame, const Window& window) {
  const Homography unit_from_camera = window.camera_from_unit.Inverse();
  double sum = 0.0;
  double count = 0.0;
  for (int y = 0; y < frame.signal.height(); ++y) {
    for (int x = 0; x < frame.signal.width(); ++x) {
      if (frame.mask(x, y) != 0) continue;
      const Point p = unit_from_camera({x + 0.5, y + 0.5});
      if (std::min({p.x, p.y, 1.0 - p.x, 1.0 - p.y}) < kMiddleFrom) continue;
      sum += frame.signal(x, y);
      count += 1.0;
    }
  }
  return count > 0.0 ? sum / count : std::nan("");
}

std::vector<FrameRecord> FramesOf(const Session& session, FrameRole role, double nm,
                                  const std::string& position) {
  std::vector<FrameRecord> found;
  for (const FrameRecord& frame : session.frames) {
    if (frame.role == role && frame.wavelength_nm == nm && frame.polarizer == position)
      found.push_back(frame);
  }
  if (found.empty()) {
    throw InputError(
        "there is no " + std::string(RoleName(role)) + " frame at " + Short(nm) +
        " nm with the polarizer at " + position +
        "; expected Spectralon and skin at s and at p for every wavelength: capture it, or leave this "
        "wavelength out");
  }
  return found;
}

struct Position {
  Signals spectralon, skin;
};

Position Measure(const Session& session, const FrameReader& read, const BlackFrames& blacks,
                 const PixelRegion& card, double nm, const std::string& position) {
  Position out;
  const auto add = [&](const SignalFrame& frame, const Window& window, Signals& to) {
    const double brightness = GrayCardSignal(frame, card);
    to.over_card.push_back(MeanInWindow(frame, window) / brightness);
    to.card.push_back(brightness / frame.record.iso);
  };
  std::vector<SignalFrame> whites;
  for (const FrameRecord& record : FramesOf(session, FrameRole::kSpectralon, nm, position)) {
    whites.push_back(ReadSignal(record, read, blacks));
    CheckLit(whites.back(), card, blacks.FullScale(*whites.back().black));
  }
  Window window;
  for (const FrameRecord& record : FramesOf(session, FrameRole::kSkin, nm, position)) {
    const SignalFrame skin = ReadSignal(record, read, blacks);
    CheckLit(skin, card, blacks.FullScale(*skin.black));
    Mosaic mosaic;
    mosaic.skin = skin.signal;
    mosaic.spectralon = whites[0].signal;
    mosaic.mask = skin.mask;
    mosaic.period = skin.period;
    mosaic.scale = 1.0 / CompareGrayCard(skin, whites[0], card).ratio;
    window = FindWindow(mosaic, card, session.rig.window_mm, record.file);
    add(skin, window, out.skin);
  }
  for (const SignalFrame& white : whites) add(white, window, out.spectralon);
  return out;
}

double Mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

double Scatter(const std::vector<double>& values, double mean) {
  double sum = 0.0;
  for (const double v : values) sum += (v - mean) * (v - mean);
  return values.size() > 1 ? std::sqrt(sum / static_cast<double>(values.size() - 1)) : 0.0;
}

double Amplitude(double ratio) {
  return (ratio - 1.0) / (ratio + 1.0);
}

// Amplitude of a target from its signals over the card's, with the card's own put back.
Known AmplitudeOf(const Signals& s, const Signals& p, const Known& card) {
  const double mean_s = Mean(s.over_card), mean_p = Mean(p.over_card);
  const double card_ratio = (1.0 + card.value) / (1.0 - card.value);
  const double own =
      std::hypot(Scatter(s.over_card, mean_s) / mean_s / std::sqrt(double(s.over_card.size())),
                 Scatter(p.over_card, mean_p) / mean_p / std::sqrt(double(p.over_card.size())));
  return {Amplitude(mean_s / mean_p * card_ratio), std::hypot(0.5 * own, card.sigma)};
}

}  // namespace

PolarizationMeasurement MeasurePolarization(const Session& session, const FrameReader& read) {
  const BlackFrames blacks(session, read);
  const PixelRegion card = GrayCardRegion(session.rig, blacks.sensor().width, blacks.sensor().height);
  std::map<double, std::array<Position, 2>> positions;
  for (const Band& band : BandsOfSession(session)) {
    positions[band.wavelength_nm] = {Measure(session, read, blacks, card, band.wavelength_nm, "s"),
                                     Measure(session, read, blacks, card, band.wavelength_nm, "p")};
  }
  PolarizationMeasurement result;
  std::vector<double> cards;  // log ratio, position s over p, of frames paired in order
  for (const auto& [nm, both] : positions) {
    for (const auto& [s, p] :
         {std::pair{&both[0].spectralon, &both[1].spectralon}, {&both[0].skin, &both[1].skin}}) {
      for (std::size_t i = 0; i < std::min(s->card.size(), p->card.size()); ++i)
        cards.push_back(std::log(s->card[i] / p->card[i]));
    }
  }
  const double mean = Mean(cards);
  const double scatter = Scatter(cards, mean);
  result.flash_scatter = scatter / std::sqrt(2.0);
  result.gray_card = {Amplitude(std::exp(mean)), 0.5 * scatter / std::sqrt(double(cards.size()))};
  for (const auto& [nm, both] : positions) {
    result.bands.push_back({nm, AmplitudeOf(both[0].spectralon, both[1].spectralon, result.gray_card),
                            AmplitudeOf(both[0].skin, both[1].skin, result.gray_card)});
  }
  return result;
}

std::string PolarizationToml(const PolarizationMeasurement& measurement) {
  std::string nm, spectralon, skin;
  double spectralon_sigma = 0.0, skin_sigma = 0.0, sum = 0.0;
  for (const PolarizationBand& band : measurement.bands) sum += band.skin.value;
  const double sign = sum < 0.0 ? -1.0 : 1.0;  // amplitudes are written for "the stronger position is +"
  for (const PolarizationBand& band : measurement.bands) {
    const char* comma = nm.empty() ? "" : ", ";
    char text[64];
    const auto add = [&](std::string& to, double value) {
      std::snprintf(text, sizeof text, "%s%.4g", comma, value);
      to += text;
    };
    add(nm, band.wavelength_nm);
    add(spectralon, sign * band.spectralon.value);
    add(skin, sign * band.skin.value);
    spectralon_sigma = std::max(spectralon_sigma, band.spectralon.sigma);
    skin_sigma = std::max(skin_sigma, band.skin.sigma);
  }
  const bool list = measurement.bands.size() > 1;
  std::string toml =
      "# Measured by dermap calibrate --polarization: put this table into rig.toml.\n[polarization]\n";
  toml += std::string("sign = -1  # sessions are taken where skin is weaker: the camera's polarizer at ") +
          (sign > 0.0 ? "p" : "s") + "\n";
  if (list) toml += "wavelengths_nm = [" + nm + "]\n";
  toml += "spectralon = [" + spectralon + "]\n";
  toml += "spectralon_sigma = " + Short(spectralon_sigma) + "\n";
  toml += "skin = [" + skin + "]\n";
  toml += "skin_sigma = " + Short(skin_sigma) + "\n";
  return toml;
}

}  // namespace dermap
