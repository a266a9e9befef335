// SPDX-License-Identifier: Apache-2.0
// Two by two photosites are one gray pixel: no demosaicing is needed for a glance.
#include "acquire/daemon/frame_view.h"

#include <libraw/libraw.h>

#include <algorithm>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "common/files/raw_guard.h"

namespace dermap {
namespace {

constexpr int kWidth_px = 240;
constexpr double kSmallestWindow = 0.02, kLargestWindow = 0.7;  // shares of the picture

cv::Mat GrayOf(const RawFrame& frame) {
  if (!SurvivesLibRaw(frame.bytes)) return {};
  const auto raw = std::make_unique<LibRaw>(LIBRAW_OPIONS_NO_DATAERR_CALLBACK);
  // LibRaw only reads from the buffer; its interface lacks the const.
  if (raw->open_buffer(const_cast<std::byte*>(frame.bytes.data()), frame.bytes.size()) != LIBRAW_SUCCESS ||
      raw->unpack() != LIBRAW_SUCCESS || raw->imgdata.rawdata.raw_image == nullptr) {
    return {};
  }
  const auto& s = raw->imgdata.sizes;
  const double black = static_cast<double>(raw->imgdata.color.black) + raw->imgdata.color.cblack[0];
  const double range = std::max(1.0, raw->imgdata.color.maximum - black);
  cv::Mat gray(s.height / 2, s.width / 2, CV_32F);
  for (int y = 0; y < gray.rows; ++y) {
    const auto* row = raw->imgdata.rawdata.raw_image +
                      static_cast<std::size_t>(2 * y + s.top_margin) * (s.raw_pitch / 2) + s.left_margin;
    for (int x = 0; x < gray.cols; ++x) {
      const int sum =
          row[2 * x] + row[2 * x + 1] + row[2 * x + s.raw_pitch / 2] + row[2 * x + 1 + s.raw_pitch / 2];
      gray.at<float>(y, x) = static_cast<float>(std::max(0.0, (sum / 4.0 - black) / range));
    }
  }
  return gray;
}

bool FindWindow(const cv::Mat& picture) {
  cv::Mat smooth, bright;
  cv::GaussianBlur(picture, smooth, {5, 5}, 0);
  cv::threshold(smooth, bright, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(bright, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
  const double whole = static_cast<double>(picture.rows) * picture.cols;
  return std::any_of(outlines.begin(), outlines.end(), [&](const std::vector<cv::Point>& outline) {
    const double share = cv::contourArea(outline) / whole;
    const cv::Rect box = cv::boundingRect(outline);
    if (share < kSmallestWindow || share > kLargestWindow) return false;
    // Inside the picture (the gray card touches or nears its border), about as wide as high, and full.
    const double aspect = static_cast<double>(box.width) / box.height;
    const bool inside =
        box.x > 1 && box.y > 1 && box.br().x < picture.cols - 1 && box.br().y < picture.rows - 1;
    return inside && aspect > 0.6 && aspect < 1.7 && cv::contourArea(outline) > 0.75 * box.area();
  });
}

}  // namespace

FrameView MakeFrameView(const RawFrame& frame) {
  FrameView view;
  const cv::Mat gray = GrayOf(frame);
  if (gray.empty()) return view;
  cv::Mat laplacian;
  cv::Laplacian(gray, laplacian, CV_32F);
  const double level = cv::mean(gray.mul(gray))[0];
  view.sharpness = level > 0.0 ? cv::mean(laplacian.mul(laplacian))[0] / level : 0.0;
  cv::Mat small = gray;
  const double scale = static_cast<double>(kWidth_px) / gray.cols;
  if (scale < 1.0) cv::resize(gray, small, {}, scale, scale, cv::INTER_AREA);
  cv::sqrt(small, small);
  cv::Mat picture;
  small.convertTo(picture, CV_8U, 255.0);
  view.window_found = FindWindow(picture);
  std::vector<unsigned char> png;
  cv::imencode(".png", picture, png);
  view.png.assign(png.begin(), png.end());
  return view;
}

}  // namespace dermap
