// SPDX-License-Identifier: Apache-2.0
// Pictures by area means, lines by OpenCV.
#include "calibrate/frame_picture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "common/core/kernel.h"

namespace dermap {
namespace {

constexpr int kFractionBits = 4;  // of a drawn coordinate
constexpr Rgb8 kCardColour{0, 158, 255};
constexpr Rgb8 kFoundColour{255, 64, 64};
constexpr Rgb8 kWindowColour{255, 176, 0};
constexpr Rgb8 kText{235, 235, 235}, kAlarmText{255, 90, 90};
constexpr double kLeastBrightest = 4.0;  // DN: noise alone must not be stretched to a picture

DERMAP_KERNEL void AddPairs(const float* values, std::size_t cells, float* sums) {
  for (std::size_t i = 0; i < cells; ++i) sums[i] += values[2 * i] + values[2 * i + 1];
}

cv::Point Fixed(Point p, double scale) {  // drawing has the first pixel's centre at 0
  const auto fixed = [&](double v) {
    return static_cast<int>(std::lround((v * scale - 0.5) * (1 << kFractionBits)));
  };
  return {fixed(p.x), fixed(p.y)};
}

cv::Mat Canvas(Plane<Rgb8>& picture) {
  static_assert(sizeof(Rgb8) == 3);
  return {picture.height(), picture.width(), CV_8UC3, picture.data()};
}

cv::Scalar ColourOf(Rgb8 c) {
  return {double(c[0]), double(c[1]), double(c[2])};
}

}  // namespace

FramePicture PictureOf(const PlaneF& signal, int width) {
  PlaneF cells(signal.width() / 2, signal.height() / 2);
  for (int y = 0; y < 2 * cells.height(); ++y)
    AddPairs(signal.Row(y), static_cast<std::size_t>(cells.width()), cells.Row(y / 2));
  FramePicture out;
  const int picture_width = std::min(width, cells.width());
  const int height = std::max(1, cells.height() * picture_width / cells.width());
  out.picture = ResizeByArea(cells, picture_width, height);
  out.scale = double(picture_width) / signal.width();
  const double brightest = std::max(kLeastBrightest, RobustScale(out.picture.values(), 0.1).high);
  for (float& v : out.picture.values()) v = static_cast<float>(std::clamp(v / brightest, 0.0, 1.0));
  return out;
}

void DrawOutline(Plane<Rgb8>& canvas, double scale, std::span<const Point> points, Rgb8 colour) {
  std::vector<cv::Point> outline;
  for (const Point& p : points) outline.push_back(Fixed(p, scale));
  cv::Mat mat = Canvas(canvas);
  cv::polylines(mat, outline, true, ColourOf(colour), 1, cv::LINE_AA, kFractionBits);
}

void DrawLine(Plane<Rgb8>& canvas, double scale, Point from, Point to, Rgb8 colour) {
  cv::Mat mat = Canvas(canvas);
  cv::line(mat, Fixed(from, scale), Fixed(to, scale), ColourOf(colour), 1, cv::LINE_AA, kFractionBits);
}

void PasteScaled(Plane<Rgb8>& picture, int x, int y, int width, int height, Plane<Rgb8>& canvas) {
  const double scale = std::min(double(width) / picture.width(), double(height) / picture.height());
  cv::Mat scaled;
  cv::resize(Canvas(picture), scaled, {}, scale, scale, scale < 1.0 ? cv::INTER_AREA : cv::INTER_CUBIC);
  scaled = scaled(cv::Rect(0, 0, std::min(scaled.cols, width), std::min(scaled.rows, height)));
  cv::Mat target = Canvas(canvas)(cv::Rect(x, y, scaled.cols, scaled.rows));
  scaled.copyTo(target);
}

void WriteText(Plane<Rgb8>& canvas, int x, int baseline, const std::string& text, double size, bool alarm) {
  cv::Mat mat = Canvas(canvas);
  cv::putText(mat, text, {x, baseline}, cv::FONT_HERSHEY_SIMPLEX, size, ColourOf(alarm ? kAlarmText : kText),
              1, cv::LINE_AA);
}

Plane<Rgb8> OutlinedFrame(const PlaneF& picture, double scale, std::span<const Point> window) {
  Plane<Rgb8> canvas = Colourise(picture, ColourMap::kGray, {0.0, 1.0});
  DrawOutline(canvas, scale, window, kWindowColour);
  return canvas;
}

Plane<Rgb8> FailurePicture(const PlaneF& signal, const PixelRegion& card,
                           std::span<const std::vector<Point>> outlines) {
  const FramePicture frame = PictureOf(signal);
  Plane<Rgb8> picture = Colourise(frame.picture, ColourMap::kGray, {0.0, 1.0});
  const double x0 = card.x, y0 = card.y, x1 = card.x + card.width, y1 = card.y + card.height;
  const std::vector<Point> box{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
  DrawOutline(picture, frame.scale, box, kCardColour);
  for (const auto& outline : outlines) DrawOutline(picture, frame.scale, outline, kFoundColour);
  return picture;
}

}  // namespace dermap
