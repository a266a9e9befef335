// SPDX-License-Identifier: Apache-2.0
// Axes, ticks, series and legend as SVG text.
#include "fit/report_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "common/files/picture.h"
#include "fit/report_parts.h"

namespace dermap {
namespace {

constexpr double kLeft = 66.0, kRight = 18.0, kTop = 14.0, kBottom = 48.0;  // px around the plot
constexpr double kLegendLine = 18.0;

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void Add(double v) {
    low = std::min(low, v);
    high = std::max(high, v);
  }
  bool empty() const { return !(low <= high); }
  void Widen(double share) {
    const double width = high > low ? high - low : (low == 0.0 ? 1.0 : std::abs(low));
    low -= share * width;
    high += share * width;
  }
  void WidenTo(double width) {
    const double lack = std::max(0.0, width - (high - low));
    low -= 0.5 * lack;
    high += 0.5 * lack;
  }
};

std::string Text(std::string_view cls, double x, double y, const std::string& text) {
  return fmt::format(R"(<text class="{}" x="{:.1f}" y="{:.1f}">{}</text>)", cls, x, y, EscapeHtml(text));
}

std::string Line(std::string_view cls, double x1, double y1, double x2, double y2) {
  return fmt::format(R"(<line class="{}" x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}"/>)", cls, x1, y1, x2,
                     y2);
}

std::string Dot(int colour, double x, double y) {
  return fmt::format(R"(<circle class="dot s{}" cx="{:.1f}" cy="{:.1f}" r="3.6"/>)", colour, x, y);
}

std::string Curve(const ChartSeries& series, const std::string& path) {
  return fmt::format(R"(<path class="curve s{}{}" d="{}"/>)", series.colour, series.dashed ? " dashed" : "",
                     path);
}

class Plot {
 public:
  explicit Plot(const Chart& chart) : chart_(chart) {
    for (const ChartSeries& series : chart.series) {
      legend_lines_ += !series.name.empty();
      for (std::size_t i = 0; i < series.y.size(); ++i) {
        if (!Drawable(series.x[i], series.y[i])) continue;
        const double error = series.error.empty() || !std::isfinite(series.error[i]) ? 0.0 : series.error[i];
        x_.Add(X(series.x[i]));
        y_.Add(Y(series.y[i]));
        if (!chart.log_y) y_.Add(series.y[i] + error);
        if (!chart.log_y && !chart.y_from) y_.Add(series.y[i] - error);
      }
    }
    if (empty()) return;
    if (chart.reference_y && Drawable(1.0, *chart.reference_y)) y_.Add(Y(*chart.reference_y));
    x_.Widen(0.03);
    if (chart.log_y) y_.WidenTo(0.5);
    y_.Widen(0.06);
    if (chart.y_from && !chart.log_y) y_.low = *chart.y_from;
  }

  bool empty() const { return x_.empty(); }
  int Height() const { return chart_.height + static_cast<int>(kLegendLine) * legend_lines_; }

  std::string Draw() const {
    std::string svg = fmt::format(
        R"(<svg class="chart" role="img" aria-label="{}" viewBox="0 0 {} {}" style="max-width:{}px">)",
        EscapeHtml(chart_.label), chart_.width, chart_.height + kLegendLine * legend_lines_,
        chart_.width + chart_.width / 5);
    svg += XAxis() + YAxis() + Reference();
    for (const ChartSeries& series : chart_.series) svg += Series(series);
    return svg + Legend() + "</svg>\n";
  }

 private:
  bool Drawable(double x, double y) const {
    return std::isfinite(x) && std::isfinite(y) && (!chart_.log_x || x > 0.0) && (!chart_.log_y || y > 0.0);
  }
  double X(double value) const { return chart_.log_x ? std::log10(value) : value; }
  double Y(double value) const { return chart_.log_y ? std::log10(value) : value; }
  double right() const { return chart_.width - kRight; }
  double bottom() const { return chart_.height - kBottom; }
  double PixelX(double x) const { return kLeft + (X(x) - x_.low) / (x_.high - x_.low) * (right() - kLeft); }
  double PixelY(double y) const {
    return bottom() - (Y(y) - y_.low) / (y_.high - y_.low) * (bottom() - kTop);
  }

  std::string XAxis() const {
    std::string svg = Line("axis", kLeft, bottom(), right(), bottom());
    const auto ticks = chart_.log_x ? LogTicks(x_) : NiceTicks(x_.low, x_.high, 8);
    const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0;
    for (const double tick : ticks) {
      svg += Line("axis", PixelX(tick), bottom(), PixelX(tick), bottom() + 5.0);
      svg += Text("tick mid", PixelX(tick), bottom() + 19.0,
                  chart_.log_x ? FormatValue(tick) : FormatTick(tick, step));
    }
    return svg + Text("label mid", 0.5 * (kLeft + right()), bottom() + 39.0, chart_.x_label);
  }

  // Decades, with 2 and 5 in between where there are few; `range` is of logarithms.
  static std::vector<double> LogTicks(const Range& range) {
    std::vector<double> ticks;
    const bool fine = range.high - range.low < 2.0;
    for (double decade = std::floor(range.low); decade <= range.high; decade += 1.0) {
      for (const double factor : {1.0, 2.0, 5.0}) {
        const double value = factor * std::pow(10.0, decade), at = std::log10(value);
        if ((fine || factor == 1.0) && at >= range.low && at <= range.high) ticks.push_back(value);
      }
    }
    return ticks;
  }

  std::string YAxis() const {
    const auto ticks = chart_.log_y ? LogTicks(y_) : NiceTicks(y_.low, y_.high, 5);
    const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0;
    std::string svg;
    for (const double tick : ticks) {
      svg += Line("grid", kLeft, PixelY(tick), right(), PixelY(tick));
      const std::string text = chart_.log_y ? FormatValue(tick) : FormatTick(tick, step);
      svg += Text("tick end", kLeft - 8.0, PixelY(tick) + 4.0, text);
    }
    const double middle = 0.5 * (kTop + bottom());
    svg +=
        fmt::format(R"svg(<text class="label mid" transform="translate(14 {:.1f}) rotate(-90)">{}</text>)svg",
                    middle, EscapeHtml(chart_.y_label));
    return svg;
  }

  std::string Reference() const {
    if (!chart_.reference_y) return {};
    const double y = PixelY(*chart_.reference_y);
    return Line("reference", kLeft, y, right(), y) +
           Text("tick end", right() - 4.0, y - 5.0, chart_.reference_name);
  }

  std::string Series(const ChartSeries& series) const {
    std::string path, marks;
    const std::string whisker = fmt::format("whisker s{}", series.colour);
    for (std::size_t i = 0; i < series.y.size(); ++i) {
      if (!Drawable(series.x[i], series.y[i])) continue;
      const double x = PixelX(series.x[i]), y = PixelY(series.y[i]);
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : " L", x, y);
      if (!series.error.empty() && series.error[i] > 0.0 && !chart_.log_y) {
        marks +=
            Line(whisker, x, PixelY(series.y[i] - series.error[i]), x, PixelY(series.y[i] + series.error[i]));
      }
      if (series.markers) marks += Dot(series.colour, x, y);
    }
    return series.line && !path.empty() ? Curve(series, path) + marks : marks;
  }

  std::string Legend() const {
    std::string svg;
    double y = chart_.height + 4.0;
    for (const ChartSeries& series : chart_.series) {
      if (series.name.empty()) continue;
      if (series.line) svg += Curve(series, fmt::format("M{:.1f} {:.1f} h26", kLeft, y));
      if (series.markers) svg += Dot(series.colour, kLeft + 13.0, y);
      svg += Text("legend", kLeft + 36.0, y + 4.0, series.name);
      y += kLegendLine;
    }
    return svg;
  }

  const Chart& chart_;
  Range x_, y_;
  int legend_lines_ = 0;
};

}  // namespace

int DrawnHeight(const Chart& chart) {
  return Plot(chart).Height();
}

std::string DrawChart(const Chart& chart) {
  const Plot plot(chart);
  if (plot.empty()) return "<p class=\"note\">Nothing to draw: no values were recorded.</p>\n";
  return plot.Draw();
}

}  // namespace dermap
