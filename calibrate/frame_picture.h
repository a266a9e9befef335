// SPDX-License-Identifier: Apache-2.0
// Captured frames as pictures for people, with what was found in them drawn on top.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "calibrate/frames.h"
#include "calibrate/gray_card.h"
#include "calibrate/homography.h"
#include "common/files/picture.h"

namespace dermap {

struct FramePicture {
  PlaneF picture;      // 0 ... 1, the brightest thousandth clipped
  double scale = 1.0;  // picture pixels a photosite
};

// Cells of four photosites, reduced to at most `width` pixels.
FramePicture PictureOf(const PlaneF& signal, int width = 480);

// A closed line through points in photosites.
void DrawOutline(Plane<Rgb8>& canvas, double scale, std::span<const Point> points, Rgb8 colour);
void DrawLine(Plane<Rgb8>& canvas, double scale, Point from, Point to, Rgb8 colour);

// The whole picture scaled into a box of the canvas, its shape kept.
void PasteScaled(Plane<Rgb8>& picture, int x, int y, int width, int height, Plane<Rgb8>& canvas);
// Light on dark; red for an alarm. `size`: 0.42 is 10 pixels high.
void WriteText(Plane<Rgb8>& canvas, int x, int baseline, const std::string& text, double size,
               bool alarm = false);

// A picture of a frame, 0 ... 1, with its window outlined.
Plane<Rgb8> OutlinedFrame(const PlaneF& picture, double scale, std::span<const Point> window);

// The frame with the gray card's region outlined, and other outlines where something else was found.
Plane<Rgb8> FailurePicture(const PlaneF& signal, const PixelRegion& card,
                           std::span<const std::vector<Point>> outlines = {});

}  // namespace dermap
