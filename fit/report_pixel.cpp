// SPDX-License-Identifier: Apache-2.0
// The section on one pixel: what was measured there, what the model predicts, what the fit found. Values of
// at most 64 x 64 pixels are part of the page, in 16 bits each between the least and the most of their plane.
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "fit/report_parts.h"
#include "fit/report_sections.h"

namespace dermap {
namespace {

constexpr int kMostPixels = 64;  // along a side
constexpr std::uint16_t kMissing = 65535;

// Every `step`-th pixel, from the middle of the squares they stand for: a pixel's own error bars, which means
// over areas have not.
struct Sampling {
  int step, width, height;
  int Index(int i) const { return i * step + step / 2; }
};

Sampling SamplingOf(const PlaneF& plane) {
  const int step = (std::max(plane.width(), plane.height()) + kMostPixels - 1) / kMostPixels;
  return {step, std::max(plane.width() / step, 1), std::max(plane.height() / step, 1)};
}

class PackedPlanes {
 public:
  explicit PackedPlanes(Sampling sampling) : sampling_(sampling) {}

  void Add(const PlaneF& plane) {
    std::vector<float> values;
    for (int y = 0; y < sampling_.height; ++y)
      for (int x = 0; x < sampling_.width; ++x)
        values.push_back(plane(std::min(sampling_.Index(x), plane.width() - 1),
                               std::min(sampling_.Index(y), plane.height() - 1)));
    float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
    for (const float value : values)
      if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
    if (!(low < high)) high = low + 1.0f;
    ranges_.push_back({low, high});
    for (const float value : values) {
      const double share = (static_cast<double>(value) - low) / (static_cast<double>(high) - low);
      const auto code =
          std::isfinite(value) ? static_cast<std::uint16_t>(std::lround(share * (kMissing - 1))) : kMissing;
      bytes_.push_back(static_cast<std::byte>(code & 255));
      bytes_.push_back(static_cast<std::byte>(code >> 8));
    }
  }
  const nlohmann::json& ranges() const { return ranges_; }
  std::string Base64() const {
    const std::string uri = DataUri(bytes_, "");
    return uri.substr(uri.find(',') + 1);
  }

 private:
  Sampling sampling_;
  nlohmann::json ranges_ = nlohmann::json::array();
  std::vector<std::byte> bytes_;
};

PlaneF FlagsAsNumbers(const FitResult& fit) {
  PlaneF plane(fit.maps.width(), fit.maps.height());
  for (std::size_t i = 0; i < fit.flags.size(); ++i)
    plane.data()[i] = static_cast<float>(fit.flags.data()[i]);
  return plane;
}

// JSON inside an element: no text in it may end the element.
std::string ScriptSafe(const nlohmann::json& json) {
  std::string out;
  for (const char c : json.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace))
    out += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return out;
}

std::string Frame(const ReportContext& context) {
  const FitResult& fit = context.fit();
  const auto picture =
      context.observer.Picture(context.wavelengths_nm, fit.measured, DisplayExposure(fit.measured));
  return "<div class=\"split even\"><div><div class=\"stage\" id=\"pixel-stage\" tabindex=\"0\" "
         "role=\"application\" "
         "aria-label=\"The patch in colour; arrow keys choose a pixel\" aria-describedby=\"pixel-how\">" +
         ImageTag(picture, "the patch in colour") +
         "<span id=\"pixel-mark\" class=\"point\"></span></div><p class=\"note\" id=\"pixel-how\">Click the "
         "picture, or any map above; or move with the arrow keys (with Shift ten steps).</p></div>\n<div>"
         "<svg id=\"pixel-chart\" class=\"chart\" viewBox=\"0 0 560 330\" role=\"img\" "
         "aria-label=\"Measured and predicted spectrum of the chosen pixel\"></svg>"
         "<p class=\"note\">Dots: measured, with one standard deviation of their noise. Line: what the model "
         "predicts from the values below.</p><p id=\"pixel-said\" aria-live=\"polite\"></p>"
         "<div class=\"wide\"><table><thead><tr><th>name</th><th>what</th><th>value</th><th>one standard "
         "deviation</th><th>unit</th></tr></thead><tbody "
         "id=\"pixel-rows\"></tbody></table></div></div></div>\n"
         "<noscript><p class=\"note\">This section needs JavaScript, which is switched off "
         "here.</p></noscript>\n";
}

}  // namespace

std::string PixelSection(const ReportContext& context) {
  const FitResult& fit = context.fit();
  const Sampling sampling = SamplingOf(fit.maps.planes[0]);
  PackedPlanes planes(sampling);
  const PlaneF unknown(fit.maps.width(), fit.maps.height(), std::numeric_limits<float>::quiet_NaN());
  for (std::size_t b = 0; b < fit.bands.size(); ++b) {
    planes.Add(fit.measured[b]);
    planes.Add(b < fit.noise.size() ? fit.noise[b] : unknown);
    planes.Add(fit.predicted[b]);
  }
  nlohmann::json info{{"width", sampling.width}, {"height", sampling.height}, {"step", sampling.step}};
  info["bands"] = context.wavelengths_nm;
  info["maps"] = nlohmann::json::array();
  for (const ReportedMap& map : context.maps) {
    planes.Add(*map.value);
    planes.Add(map.sigma != nullptr ? *map.sigma : unknown);
    info["maps"].push_back(
        {{"name", map.name}, {"description", map.description}, {"unit", map.unit}, {"free", map.free}});
  }
  planes.Add(FlagsAsNumbers(fit));
  info["flags"] = kFitFlagNames;
  info["start"] = {sampling.width / 2, sampling.height / 2};
  info["ranges"] = planes.ranges();
  std::string lead = "The light of a single pixel, beside what the model makes of it.";
  if (sampling.step > 1)
    lead += " One pixel in " + std::to_string(sampling.step) + " along each side is part of this page.";
  return Section("pixel", "One pixel", lead,
                 Frame(context) + "<script type=\"application/json\" id=\"pixel-info\">" + ScriptSafe(info) +
                     "</script>\n<script type=\"text/plain\" id=\"pixel-values\">" + planes.Base64() +
                     "</script>\n<script>" + std::string(PixelScript()) + "</script>\n");
}

}  // namespace dermap
