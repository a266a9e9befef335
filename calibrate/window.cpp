// SPDX-License-Identifier: Apache-2.0
// Rough search for the window: threshold, contours, quadrilaterals.
#include "calibrate/window.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "calibrate/failure.h"
#include "calibrate/frame_picture.h"
#include "common/core/error.h"

namespace dermap {
namespace {

constexpr double kDarkestSpectralon =
    0.05;                           // share of the bright cells: darker ones lie outside of the light
constexpr double kDarkest = 0.003;  // reflectance range of the search, on a logarithmic scale
constexpr double kBrightest = 1.2;
constexpr double kSmallestArea = 0.01;  // of the frame
constexpr double kOpposite = 0.7;       // opposite sides' ratio
constexpr double kNeighbouring = 0.5;   // neighbouring sides' ratio: a square seen at up to 60 degrees
constexpr double kFilled = 0.85;        // share of its quadrilateral that a window fills
constexpr double kSecondWindow = 0.2;   // of the largest one's area
constexpr double kSameSize = 0.9;       // ratio of diagonals
constexpr double kMoreRegular = 0.03;
constexpr int kThresholds = 8;  // tried after Otsu's
constexpr double kMostCells =
    7e5;  // of the search: of larger frames, cells are averaged until they are no more

using Contour = std::vector<cv::Point>;

struct Found {
  std::vector<std::array<Point, 4>> windows;  // largest first; cell coordinates
  int bright_regions = 0;
};

// Reflectance of cells of `cell_px` photosites a side, on a logarithmic scale.
cv::Mat LogarithmicPicture(PlaneF cells, int& cell_px) {
  cv::Mat mean(cells.height(), cells.width(), CV_32F, cells.data());
  for (cell_px = 2; static_cast<double>(mean.total()) > kMostCells; cell_px *= 2)
    cv::resize(mean(cv::Rect(0, 0, mean.cols & ~1, mean.rows & ~1)), mean, {}, 0.5, 0.5, cv::INTER_AREA);
  cv::Mat picture(mean.size(), CV_8U);
  const double range = std::log(kBrightest / kDarkest);
  for (int y = 0; y < mean.rows; ++y) {
    for (int x = 0; x < mean.cols; ++x) {
      const double r = std::clamp(static_cast<double>(mean.at<float>(y, x)), kDarkest, kBrightest);
      picture.at<std::uint8_t>(y, x) =
          static_cast<std::uint8_t>(std::lround(255.0 * std::log(r / kDarkest) / range));
    }
  }
  return picture;
}

double Length(Point a, Point b) {
  return std::hypot(b.x - a.x, b.y - a.y);
}

// Clockwise in the picture, from the corner nearest to the upper left.
std::array<Point, 4> Ordered(const Contour& quad) {
  std::array<Point, 4> corners;
  Point centre;
  for (int i = 0; i < 4; ++i) {
    corners[i] = {static_cast<double>(quad[i].x), static_cast<double>(quad[i].y)};
    centre.x += corners[i].x / 4;
    centre.y += corners[i].y / 4;
  }
  std::sort(corners.begin(), corners.end(), [&](Point a, Point b) {
    return std::atan2(a.y - centre.y, a.x - centre.x) < std::atan2(b.y - centre.y, b.x - centre.x);
  });
  const auto first = std::min_element(corners.begin(), corners.end(),
                                      [](Point a, Point b) { return a.x + a.y < b.x + b.y; });
  std::rotate(corners.begin(), first, corners.end());
  return corners;
}

// How alike opposite sides are, 1 for a square seen from anywhere far away. A corner that is lost to the
// tape, since skin is dark there, shows here.
double Regularity(const std::array<Point, 4>& c) {
  const auto ratio = [](double a, double b) { return std::min(a, b) / std::max(a, b); };
  return ratio(Length(c[0], c[1]), Length(c[2], c[3])) * ratio(Length(c[1], c[2]), Length(c[3], c[0]));
}

// Whether `other`, of about the same size, is so much more regular that `corners` must miss a corner.
bool HasLostCorner(const std::array<Point, 4>& corners, const std::array<Point, 4>& other) {
  const auto diagonal = [](const std::array<Point, 4>& c) {
    return std::max(Length(c[0], c[2]), Length(c[1], c[3]));
  };
  const double size = diagonal(other) / diagonal(corners);
  return size > kSameSize && size < 1.0 / kSameSize && Regularity(other) > Regularity(corners) + kMoreRegular;
}

bool LooksLikeSquare(const std::array<Point, 4>& c) {
  const std::array<double, 4> side{Length(c[0], c[1]), Length(c[1], c[2]), Length(c[2], c[3]),
                                   Length(c[3], c[0])};
  const auto ratio = [](double a, double b) { return std::min(a, b) / std::max(a, b); };
  return ratio(side[0], side[2]) > kOpposite && ratio(side[1], side[3]) > kOpposite &&
         ratio(side[0], side[1]) > kNeighbouring && ratio(side[2], side[3]) > kNeighbouring;
}

bool TouchesBorder(const Contour& contour, const cv::Mat& picture) {
  const cv::Rect box = cv::boundingRect(contour);
  return box.x <= 0 || box.y <= 0 || box.x + box.width >= picture.cols || box.y + box.height >= picture.rows;
}

// The card belongs to a region that covers a good part of its box.
bool IsGrayCard(const Contour& contour, const cv::Rect& card) {
  const cv::Rect shared = cv::boundingRect(contour) & card;
  return shared.area() > card.area() / 4 &&
         cv::pointPolygonTest(contour, cv::Point2f(card.x + card.width / 2.0f, card.y + card.height / 2.0f),
                              false) >= 0;
}

Found WindowsAt(const cv::Mat& picture, int threshold, const cv::Rect& card) {
  cv::Mat bright = picture > threshold;
  const cv::Mat small = cv::Mat::ones(3, 3, CV_8U);
  cv::morphologyEx(bright, bright, cv::MORPH_OPEN, small);
  cv::morphologyEx(bright, bright, cv::MORPH_CLOSE, small);
  std::vector<Contour> contours;
  cv::findContours(bright, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  std::sort(contours.begin(), contours.end(),
            [](const Contour& a, const Contour& b) { return cv::contourArea(a) > cv::contourArea(b); });
  Found found;
  double largest = 0.0;
  for (const Contour& contour : contours) {
    const double area = cv::contourArea(contour);
    if (area < kSmallestArea * static_cast<double>(picture.total()) || IsGrayCard(contour, card)) continue;
    ++found.bright_regions;
    if (TouchesBorder(contour, picture)) continue;
    Contour hull;
    Contour quad;
    cv::convexHull(contour, hull);
    cv::approxPolyDP(hull, quad, 0.04 * cv::arcLength(hull, true), true);
    if (quad.size() != 4 || area < kFilled * cv::contourArea(hull)) continue;
    const auto corners = Ordered(quad);
    if (!LooksLikeSquare(corners) || area < kSecondWindow * largest) continue;
    largest = std::max(largest, area);
    found.windows.push_back(corners);
  }
  return found;
}

int OtsuThreshold(const cv::Mat& picture, const cv::Rect& card) {
  std::vector<std::uint8_t> values;
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const auto v = picture.at<std::uint8_t>(y, x);
      if (v > 0 && !card.contains({x, y})) values.push_back(v);
    }
  }
  if (values.empty()) return 0;
  cv::Mat unused;
  return static_cast<int>(
      cv::threshold(cv::Mat(values), unused, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU));
}

}  // namespace

Window FindWindow(const Mosaic& mosaic, const PixelRegion& gray_card, double window_mm,
                  const std::string& frame_name) {
  int cell_px = 2;
  const cv::Mat picture = LogarithmicPicture(CellReflectance(mosaic, kDarkestSpectralon), cell_px);
  const cv::Rect card((gray_card.x - mosaic.x0) / cell_px, (gray_card.y - mosaic.y0) / cell_px,
                      gray_card.width / cell_px, gray_card.height / cell_px);
  const auto photosites = [&](Point cell) {
    return Point{mosaic.x0 + cell_px * (cell.x + 0.5), mosaic.y0 + cell_px * (cell.y + 0.5)};
  };
  std::vector<int> thresholds{OtsuThreshold(picture, card)};
  for (int i = 1; i <= kThresholds; ++i) thresholds.push_back(255 * i / (kThresholds + 1));
  int regions = 0;
  std::optional<std::array<Point, 4>> best;
  for (const int threshold : thresholds) {
    const Found found = WindowsAt(picture, threshold, card);
    regions = std::max(regions, found.bright_regions);
    if (found.windows.size() > 1 && !best) {
      std::vector<std::vector<Point>> outlines;
      for (const auto& w : found.windows) {
        outlines.emplace_back();
        for (const Point& p : w) outlines.back().push_back(photosites(p));
      }
      throw CaptureFailure(
          frame_name + ": " + std::to_string(found.windows.size()) +
              " windows in the tape were found, expected one; cover the others with black tape "
              "and capture this frame again",
          FailurePicture(mosaic.skin, gray_card, outlines));
    }
    if (found.windows.size() != 1) continue;
    if (!best || HasLostCorner(*best, found.windows[0])) best = found.windows[0];
  }
  if (best) {
    for (Point& p : *best) p = mosaic.lens.IdealFromPhotosites(photosites(p));
    try {
      return RefineWindow(mosaic, *best, window_mm, frame_name);
    } catch (const InputError& error) {
      const std::vector<std::vector<Point>> outline{{best->begin(), best->end()}};
      throw CaptureFailure(error.what(), FailurePicture(mosaic.skin, gray_card, outline));
    }
  }
  throw CaptureFailure(
      frame_name + ": no window in the tape was found (" + std::to_string(regions) +
          " bright regions, none of them a square that lies whole within the frame); expected one bright "
          "square "
          "on black tape: check the tape, the focus and that the whole window is in view, then capture this "
          "frame again",
      FailurePicture(mosaic.skin, gray_card));
}

}  // namespace dermap
