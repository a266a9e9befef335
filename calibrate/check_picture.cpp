// SPDX-License-Identifier: Apache-2.0
// Two panels a band, bands in columns.
#include "calibrate/check_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "calibrate/frame_picture.h"

namespace dermap {
namespace {

constexpr int kPanelWidth = 480;
constexpr int kPanelHeight = 360;
constexpr int kTitleHeight = 24;
constexpr int kMostColumns = 2;  // pairs of panels
constexpr int kGridLines = 8;
constexpr int kLineSteps = 16;
constexpr double kResidualScale = 2.0;  // standard deviations of the bands' structure at the colours' ends
constexpr Rgb8 kWindowColour{255, 176, 0};
constexpr Rgb8 kGridColour{64, 200, 120};
constexpr Rgb8 kDroppedColour{255, 64, 64};

Plane<Rgb8> FrameWithGrid(const BandCalibration& band, double patch_px) {
  Plane<Rgb8> picture = Colourise(band.picture, ColourMap::kGray, {0.0, 1.0});
  if (band.windows.empty()) return picture;
  const PatchMap map{band.windows[0].camera_from_unit, band.alignment.warp, patch_px};
  for (int line = 0; line <= kGridLines; ++line) {
    const double at = double(line) / kGridLines;
    for (int i = 0; i < kLineSteps; ++i) {
      const double a = double(i) / kLineSteps, b = double(i + 1) / kLineSteps;
      DrawLine(picture, band.picture_scale, map({at, a}), map({at, b}), kGridColour);
      DrawLine(picture, band.picture_scale, map({a, at}), map({b, at}), kGridColour);
    }
  }
  DrawOutline(picture, band.picture_scale, band.windows[0].corners,
              band.dropped ? kDroppedColour : kWindowColour);
  return picture;
}

void WriteTitle(Plane<Rgb8>& canvas, int x, int y, const std::string& text, bool alarm) {
  WriteText(canvas, x + 6, y + kTitleHeight - 7, text, 0.42, alarm);
}

}  // namespace

std::string WindowCaption(const BandCalibration& band) {
  char text[160];
  const double edge = band.windows.empty() ? 0.0 : band.windows[0].edge_uncertainty_px;
  std::snprintf(text, sizeof text, "%g nm%s  window +-%.3f px", band.band.wavelength_nm,
                band.dropped ? "  DROPPED" : "", edge);
  return text;
}

std::string ResidualCaption(const BandCalibration& band) {
  char text[160];
  const BandAlignment& a = band.alignment;
  if (!a.applied) return "aligned by the window alone";
  std::snprintf(text, sizeof text, "residual; moved %.2f, %.2f px, %.2f deg, stretch %.2f px, +-%.2f",
                a.dx_px, a.dy_px, a.angle_rad * 57.29578, a.stretch_px, a.uncertainty_px);
  return text;
}

Plane<Rgb8> CheckPicture(const CalibrationResult& result) {
  const auto count = static_cast<int>(result.bands.size());
  const int columns = std::clamp(count, 1, kMostColumns);
  const int rows = (count + columns - 1) / columns;
  Plane<Rgb8> canvas(columns * 2 * kPanelWidth, rows * (kPanelHeight + kTitleHeight), Rgb8{24, 24, 28});
  for (int i = 0; i < count; ++i) {
    const BandCalibration& band = result.bands[static_cast<std::size_t>(i)];
    const int x = i % columns * 2 * kPanelWidth;
    const int y = i / columns * (kPanelHeight + kTitleHeight);
    WriteTitle(canvas, x, y, WindowCaption(band), band.dropped);
    Plane<Rgb8> frame = FrameWithGrid(band, result.stack.valid.width());
    PasteScaled(frame, x, y + kTitleHeight, kPanelWidth, kPanelHeight, canvas);
    WriteTitle(canvas, x + kPanelWidth, y, ResidualCaption(band), band.dropped);
    if (band.alignment.residual.empty()) continue;
    PlaneF shown = band.alignment.residual;
    for (float& v : shown.values()) v = std::isfinite(v) ? v : 0.0f;
    Plane<Rgb8> residual = Colourise(shown, ColourMap::kDiverging, {-kResidualScale, kResidualScale});
    PasteScaled(residual, x + kPanelWidth, y + kTitleHeight, kPanelWidth, kPanelHeight, canvas);
  }
  return canvas;
}

}  // namespace dermap
