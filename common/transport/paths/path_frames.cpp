// SPDX-License-Identifier: Apache-2.0
// Sizes and positions of the path engine's grids.
#include "common/transport/paths/path_frames.h"

#include <algorithm>
#include <cmath>

namespace dermap {
namespace {

// Pixels of the transforms' grid are at most this wide: what comes through the epidermis twice and the dermis
// once has next to no finer structure.
constexpr double kTransformPixel_mm = 0.13, kStrictTransformPixel_mm = 0.065;
constexpr int kMostHalvings = 8;
constexpr int kGranule = 4;  // pixels of the transforms' grid: it and the rest's have even sides
// Around the patch, in the grids between: as much as interpolation from the coarser one needs.
constexpr int kRing_px = 4;
// On each side, where what arrives is lost. Mirrored light crosses it twice before it is back in the skin;
// what the mirror gives too much and the lost skin too little nearly cancel at this width (window_test.cpp).
constexpr double kRim_mm = 1.3;
constexpr double kRimBeyondMargin_mm = 0.55;
constexpr double kRimShare = 0.53;  // of what lies around the patch, at most

int RoundUp(int value, int multiple) {
  return (value + multiple - 1) / multiple * multiple;
}

}  // namespace

PathFrames::PathFrames(int patch_width, int patch_height, const ImagingConditions& conditions, double margin,
                       const ForwardOptions& options)
    : pixel_size_mm(conditions.pixel_size_mm),
      margin_mm(margin),
      beneath_tape(options.beneath_tape),
      window(conditions.illumination == Illumination::kWindow) {
  const double coarsest =
      options.tolerance >= kStrictTolerance ? kTransformPixel_mm : kStrictTransformPixel_mm;
  while (halvings < kMostHalvings && pixel_at(halvings + 1) <= coarsest &&
         std::min(patch_width, patch_height) >> (halvings + 1) >= kGranule)
    ++halvings;
  const int granule = kGranule << halvings;
  patch.width = RoundUp(patch_width, granule);
  patch.height = RoundUp(patch_height, granule);
  patch.patch = {(patch.width - patch_width) / 2, (patch.height - patch_height) / 2, patch_width,
                 patch_height};
  const auto pixels = [&](double length_mm) {
    return static_cast<int>(std::ceil(length_mm / pixel_at(halvings)));
  };
  const int around_px = window ? RoundUp(pixels(margin_mm) + pixels(kRimBeyondMargin_mm), kGranule / 2) : 0;
  const int rim =
      window ? static_cast<int>(std::min(kRim_mm / pixel_at(halvings), kRimShare * around_px)) : 0;
  for (int level = 0; level <= halvings; ++level) {
    const int width = patch.width >> level, height = patch.height >> level;
    const int around = level == halvings ? around_px : (window && level > 0 ? kRing_px : 0);
    levels.push_back({width + 2 * around, height + 2 * around, around, around});
  }
  if (halvings == 0) levels.insert(levels.begin(), {patch.width, patch.height, 0, 0});
  const Frame& whole = transforms();
  rest = {whole.width / 2, whole.height / 2, whole.x / 2, whole.y / 2};
  skin = {rim, rim, whole.width - 2 * rim, whole.height - 2 * rim};
}

PlaneMap PathFrames::LightDown(int level) const {
  const Frame &fine = levels[level], &coarse = levels[level + 1];
  const LineEnd end = window ? LineEnd::kZero : LineEnd::kMirror;
  if (halvings == 0)
    return {LineMap::Shift(fine.width, coarse.width, -coarse.x, end),
            LineMap::Shift(fine.height, coarse.height, -coarse.y, end)};
  return {LineMap::Halving(Halver::kSmooth, fine.width, coarse.width, fine.x - 2 * coarse.x, end),
          LineMap::Halving(Halver::kSmooth, fine.height, coarse.height, fine.y - 2 * coarse.y, end)};
}

std::vector<PlaneMap> PathFrames::SkinDown() const {
  const bool mirrored = !window || beneath_tape == BeneathTape::kMirrored;
  const LineEnd end = mirrored ? LineEnd::kMirror : LineEnd::kReplicate;
  const LineEnd around = window && beneath_tape == BeneathTape::kMean ? LineEnd::kMean : end;
  std::vector<PlaneMap> maps;
  int width = patch.width, height = patch.height;
  for (int level = 0; level < halvings; ++level) {
    maps.emplace_back(LineMap::Halving(Halver::kFlat, width, width / 2, 0, end),
                      LineMap::Halving(Halver::kFlat, height, height / 2, 0, end));
    width /= 2, height /= 2;
  }
  const Frame& whole = transforms();
  maps.emplace_back(LineMap::Shift(width, whole.width, -whole.x, around),
                    LineMap::Shift(height, whole.height, -whole.y, around));
  return maps;
}

PlaneMap PathFrames::ToRest() const {
  const Frame& whole = transforms();
  return {LineMap::Halving(Halver::kFlat, whole.width, rest.width, 0, LineEnd::kMirror),
          LineMap::Halving(Halver::kFlat, whole.height, rest.height, 0, LineEnd::kMirror)};
}

PlaneF PathFrames::PatchShareAtRest() const {
  const double pixel = 2.0 * (1 << halvings);  // of the rest's grid, in pixels of the patch
  const auto share = [&](int i, int origin, int first, int count) {
    const double from = (i - origin) * pixel, to = from + pixel;  // origin: half a pixel off where it is odd
    return std::clamp(std::min(to, first + double(count)) - std::max(from, double(first)), 0.0, pixel) /
           pixel;
  };
  PlaneF plane(rest.width, rest.height);
  for (int y = 0; y < rest.height; ++y)
    for (int x = 0; x < rest.width; ++x)
      plane(x, y) = static_cast<float>(share(x, rest.x, patch.patch.x, patch.patch.width) *
                                       share(y, rest.y, patch.patch.y, patch.patch.height));
  return plane;
}

PlaneF PathFrames::SkinShare() const {
  PlaneF plane(transforms().width, transforms().height);
  for (int y = skin.y; y < skin.y + skin.height; ++y) std::fill_n(plane.Row(y) + skin.x, skin.width, 1.0f);
  return plane;
}

double PathFrames::GainDown(int to_level, double omega) const {
  double gain = 1.0;
  for (int level = 0; level < std::min(to_level, halvings); ++level)
    gain *= LineMap::Gain(Halver::kSmooth, omega * (1 << level));
  return gain;
}

}  // namespace dermap
