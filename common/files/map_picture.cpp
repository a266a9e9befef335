// SPDX-License-Identifier: Apache-2.0
// Lays out a map, its colour bar and its labels with OpenCV, at three times the size for smooth text.
#include "common/files/map_picture.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "common/files/atomic_file.h"

namespace dermap {
namespace {

// All lengths in px of the finished picture.
constexpr int kOversampling = 3;
constexpr int kMapSide = 512;
constexpr int kMinBarHeight = 180;
constexpr int kMargin = 20;
constexpr int kHeader = 62;
constexpr int kFooter = 34;
constexpr int kBarGap = 22;
constexpr int kBarWidth = 20;
constexpr int kTickRoom = 84;
constexpr int kMinPageWidth = 360;

const cv::Scalar kPaper(255, 255, 255);
const cv::Scalar kInk(34, 30, 28);
const cv::Scalar kFaint(110, 104, 100);
const cv::Scalar kOutline(170, 166, 162);

cv::Scalar AsScalar(const Rgb8& c) {
  return {double(c[0]), double(c[1]), double(c[2])};
}

// A canvas in px of the finished picture that draws enlarged.
class Canvas {
 public:
  Canvas(int width, int height) : canvas_(height * kOversampling, width * kOversampling, CV_8UC3, kPaper) {}

  enum class Anchor { kLeft, kRight, kCentre };
  void Text(const std::string& text, double x, double baseline, double height_px, const cv::Scalar& colour,
            Anchor anchor = Anchor::kLeft, bool bold = false) {
    const int font = cv::FONT_HERSHEY_DUPLEX;
    const int thickness = bold ? 4 : 2;
    const double size =
        cv::getFontScaleFromHeight(font, int(std::lround(height_px * kOversampling)), thickness);
    const double width = cv::getTextSize(text, font, size, thickness, nullptr).width;
    const double shift = anchor == Anchor::kLeft ? 0.0 : anchor == Anchor::kRight ? width : 0.5 * width;
    cv::putText(canvas_, text, {int(std::lround(x * kOversampling - shift)), Scaled(baseline)}, font, size,
                colour, thickness, cv::LINE_AA);
  }
  void Fill(double x, double y, double width, double height, const cv::Scalar& colour) {
    cv::rectangle(canvas_, cv::Rect(Scaled(x), Scaled(y), Scaled(width), Scaled(height)), colour, cv::FILLED);
  }
  void Outline(double x, double y, double width, double height) {
    cv::rectangle(canvas_, cv::Rect(Scaled(x), Scaled(y), Scaled(width), Scaled(height)), kOutline, 2);
  }
  void Line(double x1, double y1, double x2, double y2) {
    cv::line(canvas_, {Scaled(x1), Scaled(y1)}, {Scaled(x2), Scaled(y2)}, kFaint, 3);
  }
  void Triangle(cv::Point2d a, cv::Point2d b, cv::Point2d c, const cv::Scalar& colour) {
    const std::array<cv::Point, 3> corners{cv::Point(a * kOversampling), cv::Point(b * kOversampling),
                                           cv::Point(c * kOversampling)};
    cv::fillConvexPoly(canvas_, corners.data(), 3, colour, cv::LINE_AA);
  }
  void Picture(const Plane<Rgb8>& picture, int x, int y, int width, int height) {
    const cv::Mat source(picture.height(), picture.width(), CV_8UC3, const_cast<Rgb8*>(picture.data()));
    cv::resize(source, canvas_(cv::Rect(Scaled(x), Scaled(y), Scaled(width), Scaled(height))),
               {Scaled(width), Scaled(height)}, 0, 0, cv::INTER_NEAREST);
  }
  Plane<Rgb8> Finish() const {
    Plane<Rgb8> result(canvas_.cols / kOversampling, canvas_.rows / kOversampling);
    cv::Mat target(result.height(), result.width(), CV_8UC3, result.data());
    cv::resize(canvas_, target, target.size(), 0, 0, cv::INTER_AREA);
    return result;
  }

 private:
  static int Scaled(double length) { return int(std::lround(length * kOversampling)); }
  cv::Mat canvas_;
};

struct Layout {
  int map_width, map_height, bar_height;
  int map_x, bar_x, page_width, page_height;
};

Layout MakeLayout(int width, int height) {
  const int longest = std::max(width, height);
  const double zoom = longest <= kMapSide ? kMapSide / longest : double(kMapSide) / longest;
  Layout l{};
  l.map_width = std::max(1, int(std::lround(width * zoom)));
  l.map_height = std::max(1, int(std::lround(height * zoom)));
  l.bar_height = std::max(l.map_height, kMinBarHeight);
  const int content = l.map_width + kBarGap + kBarWidth + kTickRoom;
  l.page_width = std::max(content + 2 * kMargin, kMinPageWidth);
  l.page_height = kHeader + l.bar_height + kFooter;
  l.map_x = kMargin;
  l.bar_x = l.map_x + l.map_width + kBarGap;
  return l;
}

struct Extent {
  bool below = false, above = false, missing = false;
};

Extent ExtentOf(const PlaneF& plane, const Scale& scale) {
  Extent extent;
  const double slack = 1e-6 * (scale.high - scale.low);
  for (const float value : plane.values()) {
    extent.missing = extent.missing || !std::isfinite(value);
    extent.below = extent.below || value < scale.low - slack;
    extent.above = extent.above || value > scale.high + slack;
  }
  return extent;
}

void DrawBar(Canvas& canvas, const Layout& l, ColourMap map, const Scale& scale, const Extent& extent) {
  constexpr double kArrow = 13.0;
  const double top = kHeader + (extent.above ? kArrow : 0.0);
  const double bottom = kHeader + l.bar_height - (extent.below ? kArrow : 0.0);
  const double height = bottom - top;
  const int steps = int(height * kOversampling);
  for (int i = 0; i < steps; ++i) {
    canvas.Fill(l.bar_x, top + double(i) / kOversampling, kBarWidth, 1.0 / kOversampling,
                AsScalar(ColourAt(map, 1.0 - (i + 0.5) / steps)));
  }
  canvas.Outline(l.bar_x, top, kBarWidth, height);
  const double left = l.bar_x, right = l.bar_x + kBarWidth, middle = 0.5 * (left + right);
  if (extent.above) {
    canvas.Triangle({left, top - 1}, {right, top - 1}, {middle, kHeader + 0.0}, AsScalar(ColourAt(map, 1.0)));
  }
  if (extent.below) {
    canvas.Triangle({left, bottom + 2}, {right, bottom + 2}, {middle, bottom + kArrow},
                    AsScalar(ColourAt(map, 0.0)));
  }
  const auto ticks = NiceTicks(scale.low, scale.high, 5);
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : scale.high - scale.low;
  for (const double tick : ticks) {
    const double y = bottom - (tick - scale.low) / (scale.high - scale.low) * height;
    canvas.Line(right, y, right + 5, y);
    canvas.Text(FormatTick(tick, step), right + 10, y + 5, 10, kInk);
  }
}

// A round length of about a quarter of the map's width, in mm.
void DrawLengthBar(Canvas& canvas, const Layout& l, double map_width_mm) {
  const auto lengths = NiceTicks(0.0, map_width_mm, 4);
  if (lengths.size() < 2) return;
  const double length_mm = lengths[1];
  const double length = length_mm / map_width_mm * l.map_width;
  const double y = kHeader + l.map_height + 14.0;
  canvas.Fill(l.map_x, y, length, 3, kInk);
  canvas.Text(FormatValue(length_mm) + " mm", l.map_x + length + 8, y + 6, 10, kInk);
}

}  // namespace

Plane<Rgb8> DrawMap(const PlaneF& plane, const MapPicture& options) {
  assert(!plane.empty());
  const Layout l = MakeLayout(plane.width(), plane.height());
  const Scale scale = options.scale.value_or(RobustScale(plane.values()));
  const Extent extent = ExtentOf(plane, scale);
  const PlaneF shown = plane.width() > l.map_width || plane.height() > l.map_height
                           ? ResizeByArea(plane, l.map_width, l.map_height)
                           : plane;
  Canvas canvas(l.page_width, l.page_height);
  canvas.Text(options.title, kMargin, 28, 14, kInk, Canvas::Anchor::kLeft, true);
  const std::string range = "bar " + FormatValue(scale.low) + " to " + FormatValue(scale.high);
  canvas.Text(options.unit.empty() ? range : options.unit + "; " + range, kMargin, 49, 10.5, kFaint);
  canvas.Picture(Colourise(shown, options.map, scale), l.map_x, kHeader, l.map_width, l.map_height);
  DrawBar(canvas, l, options.map, scale, extent);
  if (options.pixel_size_mm && l.map_height == l.bar_height) {
    DrawLengthBar(canvas, l, *options.pixel_size_mm * plane.width());
  }
  if (extent.missing) {
    const double right = l.page_width - kMargin;
    canvas.Fill(right - 92, l.page_height - 22, 11, 11, AsScalar(kMissingColour));
    canvas.Text("no value", right, l.page_height - 12, 10, kInk, Canvas::Anchor::kRight);
  }
  return canvas.Finish();
}

void WriteMapPng(const std::filesystem::path& path, const PlaneF& plane, const MapPicture& options) {
  WritePng(path, DrawMap(plane, options));
}

}  // namespace dermap
