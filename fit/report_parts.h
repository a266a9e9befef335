// SPDX-License-Identifier: Apache-2.0
// Building blocks of the report's page: escaped text, pictures inside the page, colour bars, tables.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/files/picture.h"

namespace dermap {

// Text and attribute values: & < > " ' become entities; control characters other than white space become
// U+FFFD.
std::string EscapeHtml(std::string_view text);

// "4.3 %" out of 0.043.
std::string Percent(double share, int digits = 2);

// An <img> whose pixels are part of the page.
std::string ImageTag(const Plane<Rgb8>& picture, std::string_view alternative_text);

struct Marker {  // a letter on a picture
  std::string letter;
  double x = 0.0, y = 0.0;  // in pixels of the picture
};

// A plane as a figure: heading, picture, colour bar with ticks (horizontal, beneath) and a line of numbers.
struct MapFigure {
  std::string heading;  // plain text, as all strings here
  std::string unit;     // beside the heading
  ColourMap map = ColourMap::kViridis;
  std::optional<Scale> scale;  // default: percentiles 1 to 99
  std::string note;            // beneath the bar
  bool bar = true;
};
std::string DrawMapFigure(const PlaneF& plane, const MapFigure& options);

// A colour picture as a figure, with letters and a length bar.
std::string DrawColourFigure(const Plane<Rgb8>& picture, const std::string& heading, const std::string& note,
                             const std::vector<Marker>& markers = {},
                             std::optional<double> pixel_size_mm = std::nullopt);

// Median and the middle 90 % of a plane: "median 0.061, 5 to 95 %: 0.052 to 0.071".
std::string SpreadNote(const PlaneF& plane);

// Rows of HTML cells; the first row is the header. Cells must be escaped already.
std::string DrawTable(const std::vector<std::vector<std::string>>& rows);

// <section id="..."> with its heading around `body`.
std::string Section(const std::string& id, const std::string& heading, const std::string& lead,
                    const std::string& body);
std::string Grid(const std::string& figures, int columns);

// The script of the page's only moving part, one pixel's spectrum.
std::string_view PixelScript();

// The style sheet of the page.
std::string_view ReportStyle();

}  // namespace dermap
