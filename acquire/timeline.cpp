// SPDX-License-Identifier: Apache-2.0
// Sums, and a chart in SVG.
#include "acquire/timeline.h"

#include <algorithm>
#include <array>
#include <cstdio>

namespace dermap {
namespace {

constexpr double kWidth_px = 1100.0, kLeft_px = 90.0, kRow_px = 34.0, kTop_px = 34.0, kBar_px = 22.0;

struct Row {
  const char* name;
  const char* colour;
};
constexpr std::array kRows{Row{"operator", "#b0b7c0"}, Row{"wheel", "#6f9fd8"},  Row{"flash", "#e5b34b"},
                           Row{"set", "#c98fb0"},      Row{"expose", "#d9584f"}, Row{"fetch", "#8e6bbf"},
                           Row{"check", "#4fae7a"},    Row{"write", "#2f7f86"}};

// Of a span, where the operator is not waited for.
double WithoutWaits(const TimeSpan& span, const SessionTimeline& t) {
  double seconds = span.seconds();
  for (const TimeSpan& wait : t.waits)
    seconds -= TimeSpan{std::max(span.start_s, wait.start_s), std::min(span.end_s, wait.end_s)}.seconds();
  return seconds;
}

// What the slowest device needs between this exposure and the next; after the last one, the camera.
double BetweenExposures(const SessionTimeline& t, std::size_t i) {
  const FrameTiming& f = t.frames[i];
  if (i + 1 == t.frames.size()) return f.fetch.seconds();
  const FrameTiming& next = t.frames[i + 1];
  const double press_s =
      std::max(0.0, next.flash.start_s - next.expose.start_s);  // begins before the flash is ready
  const double flash_s = WithoutWaits({f.expose.end_s, f.flash.end_s}, t) - press_s;
  return std::max({f.fetch.seconds() + WithoutWaits(next.ready, t), WithoutWaits(next.wheel, t), flash_s});
}

double StartOf(const FrameTiming& f) {
  double start_s = f.expose.start_s;
  for (const TimeSpan& span : {f.wheel, f.ready}) {
    if (span.seconds() > 0.0) start_s = std::min(start_s, span.start_s);
  }
  return start_s;
}
double EndOf(const FrameTiming& f) {
  return std::max({f.expose.end_s, f.fetch.end_s, f.check.end_s, f.write.end_s});
}

class Chart {
 public:
  explicit Chart(double end_s) : px_per_s_((kWidth_px - kLeft_px - 10.0) / std::max(end_s, 1e-3)) {
    const double height = kTop_px + kRow_px * kRows.size() + 26.0;
    Add("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" font-family=\"sans-serif\" "
        "font-size=\"13\">\n<rect width=\"100%%\" height=\"100%%\" fill=\"#fff\"/>\n",
        kWidth_px, height);
    for (std::size_t r = 0; r < kRows.size(); ++r)
      Add("<text x=\"10\" y=\"%.1f\">%s</text>\n", kTop_px + kRow_px * double(r) + 16.0, kRows[r].name);
    const double step_s = end_s > 120.0 ? 20.0 : end_s > 40.0 ? 10.0 : end_s > 10.0 ? 2.0 : 0.5;
    for (double s = 0.0; s <= end_s; s += step_s) {
      const double x = kLeft_px + s * px_per_s_;
      Add("<path d=\"M%.1f %.1fV%.1f\" stroke=\"#e3e6ea\"/>", x, kTop_px - 6.0, height - 22.0);
      Add("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\" fill=\"#667\">%g s</text>\n", x, height - 6.0,
          s);
    }
  }
  void Bar(std::size_t row, const TimeSpan& span, const char* title, int number) {
    if (span.seconds() <= 0.0) return;
    Add("<rect x=\"%.2f\" y=\"%.1f\" width=\"%.2f\" height=\"%.0f\" fill=\"%s\"><title>%s %d: %.3f "
        "s</title></rect>\n",
        kLeft_px + span.start_s * px_per_s_, kTop_px + kRow_px * double(row),
        std::max(0.6, span.seconds() * px_per_s_), kBar_px, kRows[row].colour, title, number, span.seconds());
  }
  void Title(const ChainTimes& c) {
    Add("<text x=\"10\" y=\"20\" font-weight=\"bold\">%.1f s without the operator; the slowest device alone: "
        "%.1f s "
        "(camera %.1f, wheel %.1f, flash %.1f): %+.1f %%</text>\n",
        c.taken_s, c.slowest_s(), c.camera_s, c.wheel_s, c.flash_s, 100.0 * c.overhead());
  }
  std::string Finish() { return text_ + "</svg>\n"; }

 private:
  template <class... Values>
  void Add(const char* format, Values... values) {
    char line[400];
    std::snprintf(line, sizeof line, format, values...);
    text_ += line;
  }
  double px_per_s_;
  std::string text_;
};

}  // namespace

double ChainTimes::slowest_s() const {
  return std::max({camera_s, wheel_s, flash_s});
}

double ChainTimes::overhead() const {
  return slowest_s() > 0.0 ? taken_s / slowest_s() - 1.0 : 0.0;
}

ChainTimes AddUp(const SessionTimeline& timeline) {
  ChainTimes sum;
  if (timeline.frames.empty()) return sum;
  double start_s = StartOf(timeline.frames[0]), end_s = 0.0;
  for (std::size_t i = 0; i < timeline.frames.size(); ++i) {
    const FrameTiming& f = timeline.frames[i];
    sum.camera_s += WithoutWaits(f.ready, timeline) + f.expose.seconds() + f.fetch.seconds();
    sum.wheel_s += WithoutWaits(f.wheel, timeline);
    sum.turns_s += f.expose.seconds() + BetweenExposures(timeline, i);
    if (i + 1 < timeline.frames.size()) sum.flash_s += WithoutWaits(f.flash, timeline);
    start_s = std::min(start_s, StartOf(f));
    end_s = std::max(end_s, EndOf(f));
  }
  sum.taken_s = WithoutWaits({start_s, end_s}, timeline);
  return sum;
}

std::string TimelineSvg(const SessionTimeline& timeline) {
  double end_s = 0.0;
  for (const FrameTiming& f : timeline.frames) end_s = std::max(end_s, EndOf(f));
  Chart chart(end_s);
  chart.Title(AddUp(timeline));
  for (const TimeSpan& wait : timeline.waits) chart.Bar(0, wait, "operator", 0);
  for (const FrameTiming& f : timeline.frames) {
    const TimeSpan recycling{f.flash.start_s, std::min(f.flash.end_s, end_s)};
    const TimeSpan spans[]{f.wheel, recycling, f.ready, f.expose, f.fetch, f.check, f.write};
    for (std::size_t r = 0; r < std::size(spans); ++r)
      chart.Bar(r + 1, spans[r], kRows[r + 1].name, f.number);
  }
  return chart.Finish();
}

}  // namespace dermap
