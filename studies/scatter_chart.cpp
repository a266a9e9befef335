// SPDX-License-Identifier: Apache-2.0
// Placed by hand: axes in decades, the front as steps, labels kept apart.
#include "studies/scatter_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/files/picture.h"
#include "fit/report_parts.h"

namespace dermap {
namespace {

constexpr double kWidth = 640, kHeight = 460, kLeft = 70, kRight = 24, kTop = 64, kBottom = 56;  // px
constexpr double kLegendLine = 18, kGap = 16, kLabelHeight = 13;
constexpr std::array<const char*, 6> kColours{"#0072b2", "#d55e00", "#009e73",
                                              "#b0579a", "#8a6d00", "#5b626b"};

bool Drawable(const ScatterPoint& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && p.x > 0.0 && p.y > 0.0;
}

// A logarithmic axis from `low` to `high` onto pixels.
struct Axis {
  double low = 1e300, high = -1e300, from = 0.0, to = 1.0;
  void Add(double v) {
    low = std::min(low, std::log10(v));
    high = std::max(high, std::log10(v));
  }
  void Finish(double from_px, double to_px) {
    const double pad = std::max(0.08 * (high - low), 0.15);
    low -= pad;
    high += pad;
    from = from_px;
    to = to_px;
  }
  // Of what lies beyond the axis: its end.
  double Pixel(double v) const {
    return from + std::clamp((std::log10(v) - low) / (high - low), 0.0, 1.0) * (to - from);
  }
  std::vector<double> Ticks() const {
    std::vector<double> ticks;
    const bool fine = high - low < 2.2;
    for (double decade = std::floor(low); decade <= high; decade += 1.0)
      for (const double factor : {1.0, 2.0, 5.0}) {
        const double at = decade + std::log10(factor);
        if ((fine || factor == 1.0) && at >= low && at <= high) ticks.push_back(std::pow(10.0, at));
      }
    return ticks;
  }
};

// Labels that are set already; the next one goes where it meets none.
class Labels {
 public:
  std::string Set(double x, double y, const std::string& text, bool bold) {
    const double width = 6.4 * static_cast<double>(text.size());
    const bool left = x + 9 + width > kWidth - kRight;
    const double at = left ? x - 9 - width : x + 9;
    double top = y - 4;
    for (const double shift : {0.0, 13.0, -13.0, 26.0, -26.0, 39.0, -39.0, 52.0, -52.0}) {
      top = y - 4 + shift;
      if (top > kTop && top < kHeight - kBottom - kLabelHeight && !Meets(at, top, width)) break;
    }
    boxes_.push_back({at, top, width});
    std::string svg;
    if (std::abs(top + 4 - y) > 10)
      svg = fmt::format(R"(<line class="lead" x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}"/>)", x, y,
                        left ? at + width : at, top + 4);
    return svg + fmt::format(R"(<text class="{}" x="{:.1f}" y="{:.1f}">{}</text>)",
                             bold ? "name bold" : "name", at, top + 8, EscapeHtml(text));
  }

 private:
  bool Meets(double x, double y, double width) const {
    return std::any_of(boxes_.begin(), boxes_.end(), [&](const auto& box) {
      return x < box[0] + box[2] && box[0] < x + width && std::abs(y - box[1]) < kLabelHeight;
    });
  }
  std::vector<std::array<double, 3>> boxes_;
};

std::string Mark(const ScatterPoint& p, double x, double y) {
  const char* colour = kColours[static_cast<std::size_t>(p.family) % kColours.size()];
  const std::string title = "<title>" + EscapeHtml(p.title) + "</title>";
  if (p.star) {
    std::string corners;
    for (int i = 0; i < 10; ++i) {
      const double r = i % 2 ? 4.5 : 10.5, angle = M_PI * (0.2 * i - 0.5);
      corners += fmt::format("{:.1f},{:.1f} ", x + r * std::cos(angle), y + r * std::sin(angle));
    }
    return fmt::format(R"(<polygon points="{}" fill="{}" stroke="#1f2328" stroke-width="1.2">{}</polygon>)",
                       corners, colour, title);
  }
  return fmt::format(
      R"(<circle cx="{:.1f}" cy="{:.1f}" r="4.6" fill="{}" stroke="{}" stroke-width="{}">{}</circle>)", x, y,
      p.hollow ? "#ffffff" : colour, p.hollow ? colour : "#ffffff", p.hollow ? 2 : 1, title);
}

std::string Bars(const ScatterPoint& p, const Axis& x, const Axis& y) {
  const char* colour = kColours[static_cast<std::size_t>(p.family) % kColours.size()];
  const double px = x.Pixel(p.x), py = y.Pixel(p.y);
  std::string svg;
  const auto bar = [&](double x1, double y1, double x2, double y2) {
    svg += fmt::format(R"(<line stroke="{}" opacity="0.6" x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}"/>)",
                       colour, x1, y1, x2, y2);
  };
  if (p.x_bar > 0.0) bar(x.Pixel(std::max(p.x - p.x_bar, 0.3 * p.x)), py, x.Pixel(p.x + p.x_bar), py);
  if (p.y_bar > 0.0) bar(px, y.Pixel(std::max(p.y - p.y_bar, 0.3 * p.y)), px, y.Pixel(p.y + p.y_bar));
  return svg;
}

std::string Axes(const ScatterChart& chart, const Axis& x, const Axis& y) {
  const double bottom = kHeight - kBottom;
  std::string svg;
  for (const double tick : x.Ticks())
    svg += fmt::format(R"(<line class="grid" x1="{0:.1f}" y1="{1}" x2="{0:.1f}" y2="{2}"/>)"
                       R"(<text class="tick mid" x="{0:.1f}" y="{3}">{4}</text>)",
                       x.Pixel(tick), kTop, bottom, bottom + 17, FormatValue(tick));
  for (const double tick : y.Ticks())
    svg +=
        fmt::format(R"(<line class="grid" x1="{0}" y1="{1:.1f}" x2="{2}" y2="{1:.1f}"/>)"
                    R"(<text class="tick end" x="{3}" y="{4:.1f}">{5}</text>)",
                    kLeft, y.Pixel(tick), kWidth - kRight, kLeft - 7, y.Pixel(tick) + 4, FormatValue(tick));
  svg += fmt::format(R"(<path class="axis" d="M{0} {1} V{2} H{3}"/>)", kLeft, kTop, bottom, kWidth - kRight);
  svg += fmt::format(R"(<text class="label mid" x="{}" y="{}">{}</text>)", 0.5 * (kLeft + kWidth - kRight),
                     bottom + 40, EscapeHtml(chart.x_label));
  return svg +
         fmt::format(R"svg(<text class="label mid" transform="translate(15 {}) rotate(-90)">{}</text>)svg",
                     0.5 * (kTop + bottom), EscapeHtml(chart.y_label));
}

std::string Front(const ScatterChart& chart, const Axis& x, const Axis& y) {
  std::string path;
  for (const std::size_t i : chart.front) {
    const double px = x.Pixel(chart.points[i].x), py = y.Pixel(chart.points[i].y);
    path += path.empty() ? fmt::format("M{:.1f} {:.1f}", px, py) : fmt::format(" H{:.1f} V{:.1f}", px, py);
  }
  return path.empty() ? "" : fmt::format(R"(<path class="front" d="{}"/>)", path);
}

std::string Level(const ScatterChart& chart, const Axis& y) {
  if (!(chart.level > 0.0)) return "";
  return fmt::format(R"(<line class="level" x1="{0}" y1="{1:.1f}" x2="{2}" y2="{1:.1f}"/>)"
                     R"(<text class="name end" x="{2}" y="{3:.1f}">{4}</text>)",
                     kLeft, y.Pixel(chart.level), kWidth - kRight, y.Pixel(chart.level) - 5,
                     EscapeHtml(chart.level_name));
}

std::string Legend(const ScatterChart& chart) {
  std::string svg;
  double y = kHeight + 2;
  for (std::size_t f = 0; f < chart.families.size(); ++f, y += kLegendLine)
    svg += fmt::format(
        R"(<circle cx="{}" cy="{}" r="4.6" fill="{}"/><text class="legend" x="{}" y="{}">{}</text>)",
        kLeft + 8, y, kColours[f % kColours.size()], kLeft + 22, y + 4, EscapeHtml(chart.families[f]));
  return svg;
}

std::string Draw(const ScatterChart& chart) {
  Axis x, y;
  for (const ScatterPoint& p : chart.points)
    if (Drawable(p)) {
      x.Add(p.x);
      y.Add(p.y);
    }
  std::string svg = fmt::format(
      R"(<text class="title" x="{0}" y="24">{1}</text><text class="label" x="{0}" y="45">{2}</text>)",
      kLeft - 46, EscapeHtml(chart.title), EscapeHtml(chart.note));
  if (chart.level > 0.0) y.Add(chart.level);
  if (x.low > x.high) return svg + R"(<text class="label" x="70" y="60">No point to draw.</text>)";
  x.Finish(kLeft, kWidth - kRight);
  y.Finish(kHeight - kBottom, kTop);
  svg += Axes(chart, x, y) + Level(chart, y) + Front(chart, x, y);
  for (const ScatterPoint& p : chart.points)
    if (Drawable(p)) svg += Bars(p, x, y);
  for (const bool star : {false, true})
    for (const ScatterPoint& p : chart.points)
      if (Drawable(p) && p.star == star) svg += Mark(p, x.Pixel(p.x), y.Pixel(p.y));
  Labels labels;
  for (const bool star : {true, false})
    for (const ScatterPoint& p : chart.points)
      if (Drawable(p) && p.star == star && !p.label.empty())
        svg += labels.Set(x.Pixel(p.x), y.Pixel(p.y), p.label, p.star || p.hollow);
  return svg + Legend(chart);
}

constexpr const char* kStyle = R"css(
.sheet { font: 12px "DejaVu Sans", "Segoe UI", Roboto, sans-serif; }
.sheet .axis { stroke: #5b626b; fill: none; } .sheet .grid { stroke: #e9e7e2; }
.sheet .lead { stroke: #a8adb3; stroke-width: 0.7; } .sheet .level { stroke: #5b626b; stroke-dasharray: 2 4; }
.sheet .front { stroke: #1f2328; stroke-width: 1.6; fill: none; stroke-dasharray: 5 3; opacity: 0.75; }
.sheet text { fill: #5b626b; } .sheet .label, .sheet .legend { fill: #1f2328; font-size: 12.5px; }
.sheet .name { fill: #1f2328; font-size: 11px; stroke: #ffffff; stroke-width: 3.5px; paint-order: stroke; } .sheet .bold { font-weight: bold; }
.sheet .title { fill: #1f2328; font-size: 15px; font-weight: bold; }
.sheet .mid { text-anchor: middle; } .sheet .end { text-anchor: end; }
)css";

}  // namespace

std::string DrawScatterSheet(const std::vector<ScatterChart>& charts, int columns,
                             const std::string& footer) {
  std::size_t families = 0;
  for (const ScatterChart& chart : charts) families = std::max(families, chart.families.size());
  const double row = kHeight + kLegendLine * static_cast<double>(families) + kGap;
  std::string body;
  for (std::size_t i = 0; i < charts.size(); ++i)
    body += fmt::format(R"svg(<g transform="translate({} {})">)svg",
                        kGap + static_cast<double>(i % columns) * (kWidth + kGap),
                        kGap + static_cast<double>(i / columns) * row) +
            Draw(charts[i]) + "</g>\n";
  const double rows = std::ceil(static_cast<double>(charts.size()) / columns);
  const double width = kGap + columns * (kWidth + kGap), height = 2 * kGap + rows * row + 20;
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"sheet\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
      "height=\"{1}\">\n"
      "<style>{2}</style>\n<rect width=\"{0}\" height=\"{1}\" fill=\"#ffffff\"/>\n{3}"
      "<text class=\"tick\" x=\"{4}\" y=\"{5}\">{6}</text></svg>\n",
      width, height, kStyle, body, kGap, height - 12, EscapeHtml(footer));
}

}  // namespace dermap
