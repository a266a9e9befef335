// SPDX-License-Identifier: Apache-2.0
// False colours, scales and PNG on OpenCV.
#include "common/files/picture.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/core/error.h"
#include "common/files/atomic_file.h"

namespace dermap {
namespace {

constexpr int kPngLevel = 6;  // zlib's default; OpenCV's is 1, which makes reports half as large again

using Palette = std::array<Rgb8, 256>;

Palette FromOpenCv(int opencv_map) {
  cv::Mat ramp(1, 256, CV_8U);
  for (int i = 0; i < 256; ++i) ramp.at<std::uint8_t>(i) = static_cast<std::uint8_t>(i);
  cv::Mat bgr;
  cv::applyColorMap(ramp, bgr, opencv_map);
  Palette palette;
  for (int i = 0; i < 256; ++i) {
    const auto& c = bgr.at<cv::Vec3b>(i);
    palette[i] = {c[2], c[1], c[0]};
  }
  return palette;
}

Palette Gray() {
  Palette palette;
  for (int i = 0; i < 256; ++i) palette[i] = EncodeSrgb8(LinearRgb{i / 255.0, i / 255.0, i / 255.0});
  return palette;
}

// Straight lines in CIE L*a*b*, so that equal differences look equal on both sides of zero.
Palette Diverging() {
  const std::array<cv::Vec3f, 5> anchors{cv::Vec3f{28, 18, -52}, cv::Vec3f{60, -4, -38}, cv::Vec3f{96, 0, 1},
                                         cv::Vec3f{60, 42, 30}, cv::Vec3f{28, 50, 34}};
  cv::Mat lab(1, 256, CV_32FC3);
  for (int i = 0; i < 256; ++i) {
    const float position = static_cast<float>(i) / 255.0f * 4.0f;
    const int anchor = std::min(3, static_cast<int>(position));
    const float share = position - static_cast<float>(anchor);
    lab.at<cv::Vec3f>(i) = anchors[anchor] * (1.0f - share) + anchors[anchor + 1] * share;
  }
  cv::Mat rgb;
  cv::cvtColor(lab, rgb, cv::COLOR_Lab2RGB);
  Palette palette;
  for (int i = 0; i < 256; ++i) {
    for (int c = 0; c < 3; ++c) {
      palette[i][c] = cv::saturate_cast<std::uint8_t>(255.0f * rgb.at<cv::Vec3f>(i)[c]);
    }
  }
  return palette;
}

const Palette& PaletteOf(ColourMap map) {
  static const std::array<Palette, 5> kPalettes{Gray(), FromOpenCv(cv::COLORMAP_VIRIDIS),
                                                FromOpenCv(cv::COLORMAP_MAGMA),
                                                FromOpenCv(cv::COLORMAP_INFERNO), Diverging()};
  return kPalettes[static_cast<std::size_t>(map)];
}

// Element of rank share * (n - 1), without interpolation.
float Quantile(std::vector<float>& values, double share) {
  const auto rank = static_cast<std::ptrdiff_t>(std::lround(share * static_cast<double>(values.size() - 1)));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[rank];
}

Scale ScaleOf(std::vector<float> finite, double tail_percent) {
  if (finite.empty()) return {};
  Scale scale{Quantile(finite, tail_percent / 100.0), Quantile(finite, 1.0 - tail_percent / 100.0)};
  const double smallest = std::max(1e-12, 1e-5 * std::max(std::abs(scale.low), std::abs(scale.high)));
  if (scale.high - scale.low < smallest) {  // uniform: its one value in the middle
    const double half = scale.low == 0.0 ? 0.5 : 0.1 * std::abs(scale.low);
    scale = {scale.low - half, scale.high + half};
  }
  return scale;
}

void AppendFinite(std::span<const float> values, std::vector<float>& finite) {
  std::copy_if(values.begin(), values.end(), std::back_inserter(finite),
               [](float v) { return std::isfinite(v); });
}

std::vector<std::byte> EncodeMat(const cv::Mat& picture) {
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".png", picture, bytes, {cv::IMWRITE_PNG_COMPRESSION, kPngLevel}))
    throw StorageError("A picture could not be encoded as PNG.");
  const auto* begin = reinterpret_cast<const std::byte*>(bytes.data());
  return {begin, begin + bytes.size()};
}

}  // namespace

Scale RobustScale(std::span<const float> values, double tail_percent) {
  std::vector<float> finite;
  AppendFinite(values, finite);
  return ScaleOf(std::move(finite), tail_percent);
}

Scale RobustScale(std::span<const PlaneF> planes, double tail_percent) {
  std::vector<float> finite;
  for (const PlaneF& plane : planes) AppendFinite(plane.values(), finite);
  return ScaleOf(std::move(finite), tail_percent);
}

Scale SymmetricScale(std::span<const float> values, double tail_percent) {
  const Scale scale = RobustScale(values, tail_percent);
  const double reach = std::max(std::abs(scale.low), std::abs(scale.high));
  return {-reach, reach};
}

Rgb8 ColourAt(ColourMap map, double fraction) {
  return PaletteOf(map)[static_cast<std::size_t>(std::lround(255.0 * std::clamp(fraction, 0.0, 1.0)))];
}

Plane<Rgb8> Colourise(const PlaneF& plane, ColourMap map, const Scale& scale) {
  assert(scale.high > scale.low);
  const Palette& palette = PaletteOf(map);
  const double factor = 1.0 / (scale.high - scale.low);
  Plane<Rgb8> picture(plane.width(), plane.height());
  for (std::size_t i = 0; i < plane.size(); ++i) {
    const double fraction = (plane.data()[i] - scale.low) * factor;
    const bool finite = std::isfinite(plane.data()[i]);
    picture.data()[i] =
        finite ? palette[static_cast<std::size_t>(std::lround(255.0 * std::clamp(fraction, 0.0, 1.0)))]
               : kMissingColour;
  }
  return picture;
}

PlaneF ResizeByArea(const PlaneF& plane, int width, int height) {
  assert(!plane.empty() && width > 0 && height > 0);
  if (plane.SameShape(width, height)) return plane;
  cv::Mat values(plane.height(), plane.width(), CV_32F);
  cv::Mat present(plane.height(), plane.width(), CV_32F);
  for (int y = 0; y < plane.height(); ++y) {
    for (int x = 0; x < plane.width(); ++x) {
      const bool finite = std::isfinite(plane(x, y));
      values.at<float>(y, x) = finite ? plane(x, y) : 0.0f;
      present.at<float>(y, x) = finite ? 1.0f : 0.0f;
    }
  }
  const bool shrinks = width <= plane.width() && height <= plane.height();
  const int method = shrinks ? cv::INTER_AREA : cv::INTER_LINEAR;
  cv::Mat sum;
  cv::Mat weight;
  cv::resize(values, sum, {width, height}, 0, 0, method);
  cv::resize(present, weight, {width, height}, 0, 0, method);
  PlaneF result(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float w = weight.at<float>(y, x);
      result(x, y) = w > 1e-4f ? sum.at<float>(y, x) / w : NAN;
    }
  }
  return result;
}

double DisplayExposure(std::span<const PlaneF> reflectance) {
  double brightest = 0.0;
  for (const PlaneF& plane : reflectance) {
    std::vector<float> finite;
    AppendFinite(plane.values(), finite);
    if (!finite.empty()) brightest = std::max<double>(brightest, Quantile(finite, 0.99));
  }
  return std::clamp(0.8 / std::max(1e-3, brightest), 1.0, 2.0);
}

std::vector<double> NiceTicks(double low, double high, int count) {
  assert(high > low && count > 1);
  const double rough = (high - low) / count;
  const double decade = std::pow(10.0, std::floor(std::log10(rough)));
  std::vector<double> ticks;
  for (const double factor : {10.0, 5.0, 2.0, 1.0, 0.5}) {
    const double step = factor * decade;
    if (ticks.size() >= 2 && step < rough * (1.0 - 1e-9)) break;
    ticks.clear();
    const double slack = 1e-9 * (high - low);
    for (double k = std::ceil((low - slack) / step); k * step <= high + slack; k += 1.0) {
      ticks.push_back(k == 0.0 ? 0.0 : k * step);  // no -0
    }
  }
  return ticks;
}

std::string FormatTick(double value, double step) {
  char text[48];
  if (step < 1e-4 || std::abs(value) >= 1e6) {
    std::snprintf(text, sizeof text, "%.3g", value);
  } else {
    const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
    std::snprintf(text, sizeof text, "%.*f", decimals, value);
  }
  return text;
}

std::string FormatValue(double value, int digits) {
  if (std::isnan(value)) return "-";
  char text[48];
  const bool whole = std::abs(value) >= std::pow(10.0, digits) - 0.5 && std::abs(value) < 1e7;
  if (whole) {
    std::snprintf(text, sizeof text, "%.0f", value);
  } else {
    std::snprintf(text, sizeof text, "%.*g", digits, value);
  }
  return text;
}

std::vector<std::byte> EncodePng(const Plane<Rgb8>& picture) {
  assert(!picture.empty());
  const cv::Mat rgb(picture.height(), picture.width(), CV_8UC3, const_cast<Rgb8*>(picture.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  return EncodeMat(bgr);
}

std::vector<std::byte> EncodePng(const Plane<std::uint8_t>& picture) {
  assert(!picture.empty());
  return EncodeMat(
      cv::Mat(picture.height(), picture.width(), CV_8U, const_cast<std::uint8_t*>(picture.data())));
}

void WritePng(const std::filesystem::path& path, const Plane<Rgb8>& picture) {
  WriteFileAtomically(path, std::span<const std::byte>(EncodePng(picture)));
}

std::string DataUri(std::span<const std::byte> bytes, std::string_view mime_type) {
  std::string base64(4 * ((bytes.size() + 2) / 3) + 1, '\0');  // and the NUL that OpenSSL writes
  const int length =
      EVP_EncodeBlock(reinterpret_cast<unsigned char*>(base64.data()),
                      reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
  base64.resize(static_cast<std::size_t>(length));
  return "data:" + std::string(mime_type) + ";base64," + base64;
}

}  // namespace dermap
