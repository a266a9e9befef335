// SPDX-License-Identifier: Apache-2.0
// Puts the report's page together and writes the previews.
#include "fit/report.h"

#include <algorithm>
#include <cassert>

#include "common/files/atomic_file.h"
#include "common/files/map_picture.h"
#include "fit/report_parts.h"
#include "fit/report_sections.h"

namespace dermap {
namespace {

std::string Navigation() {
  std::string html = "<nav aria-label=\"Sections\">";
  for (const auto& [id, title] :
       std::initializer_list<std::pair<const char*, const char*>>{{"colour", "In colour"},
                                                                  {"captured", "Captured bands"},
                                                                  {"stack", "Calibrated stack"},
                                                                  {"maps", "Parameter maps"},
                                                                  {"pixel", "One pixel"},
                                                                  {"comparison", "Measured and predicted"},
                                                                  {"residual", "Residual"},
                                                                  {"convergence", "Convergence"},
                                                                  {"flags", "Flags"},
                                                                  {"decisions", "Decisions"},
                                                                  {"reading", "How to read this page"}}) {
    html += std::string("<a href=\"#") + id + "\">" + title + "</a>";
  }
  return html + "</nav>\n";
}

void CheckShapes(const FitResult& fit) {
  const std::size_t bands = fit.bands.size();
  assert(bands > 0 && fit.measured.size() == bands && fit.predicted.size() == bands);
  assert(fit.residual.size() == bands && fit.maps.width() > 0 && fit.maps.height() > 0);
  assert(std::all_of(fit.measured.begin(), fit.measured.end(),
                     [&](const PlaneF& plane) { return plane.SameShape(fit.maps.planes[0]); }));
  static_cast<void>(bands);
}

}  // namespace

std::optional<std::filesystem::path> CalibrationSidecar(const std::filesystem::path& stack) {
  std::filesystem::path sidecar = stack;
  sidecar.replace_extension(".calibration.json");
  std::error_code ignored;
  if (std::filesystem::is_regular_file(sidecar, ignored)) return sidecar;
  return std::nullopt;
}

void WriteReport(const std::filesystem::path& path, const ReportInput& input) {
  CheckShapes(input.fit);
  const ReportContext context = MakeReportContext(input);
  std::string html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
      EscapeHtml(input.name) + " - dermap fit</title>\n<style>";
  html += ReportStyle();
  html += "</style></head>\n<body>\n<header class=\"top\">\n" + HeadlineSection(context) + Navigation() +
          "</header>\n<main>\n";
  html += ColourSection(context);
  html += CapturedSection(context);
  html += StackSection(context);
  html += MapsSection(context);
  html += PixelSection(context);
  html += ComparisonSection(context);
  html += ResidualSection(context);
  html += ConvergenceSection(context);
  html += FlagsSection(context);
  html += DecisionsSection(context);
  html += HowToReadSection();
  html +=
      "<footer>Written by dermap. Everything on this page is part of this one file.</footer>\n"
      "</main></body></html>\n";
  WriteFileAtomically(path, std::string_view(html));
}

void WriteMapPreviews(const std::filesystem::path& directory, const FitResult& fit,
                      const std::filesystem::path& spectra_dir) {
  MapPicture options;
  if (fit.conditions.pixel_size_mm > 0.0) options.pixel_size_mm = fit.conditions.pixel_size_mm;
  for (const ReportedMap& map : ReportedMaps(fit, nullptr)) {
    std::string file = map.name;
    std::replace(file.begin(), file.end(), ' ', '_');
    options.title = map.name + ": " + map.description;
    options.unit = map.unit;
    options.map = ColourMap::kViridis;
    WriteMapPng(directory / (file + ".png"), *map.value, options);
    if (map.sigma == nullptr || !map.free) continue;
    options.title = "Standard deviation of " + map.name;
    options.map = ColourMap::kMagma;
    WriteMapPng(directory / (file + ".sigma.png"), *map.sigma, options);
  }
  if (!fit.chi2_map.empty()) {
    options.title = "chi2 per degree of freedom";
    options.unit = "1 where the residual is as large as the noise";
    options.map = ColourMap::kInferno;
    WriteMapPng(directory / "chi2.png", fit.chi2_map, options);
  }
  std::vector<double> wavelengths_nm;
  for (const Band& band : fit.bands) wavelengths_nm.push_back(band.wavelength_nm);
  WritePng(directory / "colour.png", ColourObserver(spectra_dir).Picture(wavelengths_nm, fit.measured));
}

}  // namespace dermap
