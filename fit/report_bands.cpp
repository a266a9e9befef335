// SPDX-License-Identifier: Apache-2.0
// Sections on the bands: colour, captured frames, calibrated stack, prediction and residual.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/core/error.h"
#include "fit/report_chart.h"
#include "fit/report_parts.h"
#include "fit/report_sections.h"

namespace dermap {
namespace {

std::string Nanometres(double wavelength_nm) {
  return FormatValue(wavelength_nm, 4) + " nm";
}

std::optional<double> PixelSize(const FitResult& fit) {
  if (fit.conditions.pixel_size_mm > 0.0) return fit.conditions.pixel_size_mm;
  return std::nullopt;
}

std::string PhotoFigure(const CalibrationPicture& picture) {
  std::string html = "<figure><figcaption><b>" + EscapeHtml(picture.title) + "</b></figcaption>";
  html += picture.data_uri.empty() ? "<p class=\"note\">" + EscapeHtml(picture.problem) + "</p>"
                                   : "<img class=\"photo\" alt=\"" + EscapeHtml(picture.title) + "\" src=\"" +
                                         picture.data_uri + "\">";
  return html + "</figure>\n";
}

std::vector<double> PerBand(const ReportContext& context, const std::vector<PlaneF>& planes,
                            const NamedPoint* point) {
  std::vector<double> values;
  for (std::size_t band = 0; band < context.wavelengths_nm.size(); ++band) {
    if (band >= planes.size() || planes[band].empty()) {
      values.push_back(NAN);
    } else {
      values.push_back(point != nullptr ? MeanAround(planes[band], point->x, point->y)
                                        : MeanOf(WhereFinite(planes[band], context.fit().measured[band])));
    }
  }
  return values;
}

void AddSpectrum(Chart& chart, const ReportContext& context, const std::string& name, int colour,
                 const NamedPoint* point) {
  const FitResult& fit = context.fit();
  ChartSeries measured{
      name, colour, context.wavelengths_nm, PerBand(context, fit.measured, point), {}, false, false, true};
  if (point != nullptr) {
    measured.error = PerBand(context, fit.noise, point);
    for (double& sigma : measured.error) sigma /= 3.0;  // mean of 3 x 3 pixels
  }
  ChartSeries predicted{
      "", colour, context.wavelengths_nm, PerBand(context, fit.predicted, point), {}, true, false, false};
  chart.series.push_back(std::move(predicted));
  chart.series.push_back(std::move(measured));
}

std::string MeasuredInColour(const ReportContext& context, const std::string& heading,
                             const std::string& note) {
  const FitResult& fit = context.fit();
  std::vector<Marker> markers;
  for (const NamedPoint& point : context.points) {
    markers.push_back(
        {std::string(1, point.letter), static_cast<double>(point.x), static_cast<double>(point.y)});
  }
  const auto picture =
      context.observer.Picture(context.wavelengths_nm, fit.measured, DisplayExposure(fit.measured));
  return DrawColourFigure(picture, heading, note, markers, PixelSize(fit));
}

std::string SpectrumChart(const ReportContext& context) {
  Chart chart;
  chart.label = "Measured and predicted spectra";
  chart.x_label = "wavelength, nm";
  chart.y_label = "reflectance";
  chart.y_from = 0.0;
  chart.width = 760;
  chart.height = 380;
  AddSpectrum(chart, context, "mean of the patch", 0, nullptr);
  int colour = 1;
  for (const NamedPoint& point : context.points) {
    AddSpectrum(chart, context, std::string(1, point.letter) + ": " + point.name, colour++, &point);
  }
  std::string html =
      "<div class=\"split\"><div>" + DrawChart(chart) +
      "<p class=\"note\">Dots: measured, with one standard deviation of the noise of a mean over 3 x 3 "
      "pixels. Lines: predicted at the same bands.</p></div>\n";
  html += MeasuredInColour(context, "Where the points lie", "");
  return html + "</div>\n";
}

std::string Row(const std::string& label, double value) {
  return "<span class=\"row\">" + label + " " + FormatValue(value) + "</span>";
}

}  // namespace

std::string BandLabel(const ReportContext& context, std::size_t band) {
  const double wavelength_nm = context.wavelengths_nm[band];
  const Rgb8 c = context.observer.WavelengthColour(wavelength_nm);
  char colour[8];
  std::snprintf(colour, sizeof colour, "#%02x%02x%02x", c[0], c[1], c[2]);
  return std::string("<span class=\"swatch\" style=\"background:") + colour + "\"></span>" +
         Nanometres(wavelength_nm);
}

std::string ColourSection(const ReportContext& context) {
  const FitResult& fit = context.fit();
  const double exposure = DisplayExposure(fit.measured);
  std::string names;
  for (const NamedPoint& point : context.points) {
    names += (names.empty() ? "" : "; ") + std::string(1, point.letter) + ": " + point.name;
  }
  std::string figures = MeasuredInColour(context, "Measured", names);
  figures += DrawColourFigure(context.observer.Picture(context.wavelengths_nm, fit.predicted, exposure),
                              "Predicted from the maps", "", {}, PixelSize(fit));
  std::string lead = "The patch as it looks in daylight.";
  if (exposure > 1.01)
    lead += " Shown " + FormatValue(exposure, 2) + " times brighter than beside white paper.";
  return Section("colour", "In colour", lead, Grid(figures, 3));
}

namespace {

// A line for each step, a column for each band.
std::string StepsTable(const CalibrationRecord& record) {
  std::vector<std::vector<std::string>> rows{{"step"}};
  for (const CalibratedBand& band : record.bands) {
    rows[0].push_back(EscapeHtml(band.wavelength_nm) + " nm");
    for (std::size_t i = 0; i < band.steps.size(); ++i) {
      if (rows.size() <= i + 1) rows.push_back({EscapeHtml(band.steps[i].step)});
      rows[i + 1].resize(rows[0].size() - 1);
      rows[i + 1].push_back(EscapeHtml(band.steps[i].change));
    }
  }
  if (rows.size() == 1) return {};
  rows.push_back({"all together"});
  for (const CalibratedBand& band : record.bands)
    rows.back().push_back("\u00b1 " + EscapeHtml(band.systematic_sigma));
  return "<h3>What each step did</h3>\n<p class=\"note\">Change of the reflectance, and one standard "
         "deviation "
         "that the step leaves, common to all pixels.</p>\n" +
         DrawTable(rows);
}

}  // namespace

std::string CapturedSection(const ReportContext& context) {
  const CalibrationRecord& record = context.calibration;
  const std::string heading = "Captured bands";
  if (!context.input.calibration) {
    return Section("captured", heading, "",
                   "<p class=\"note\">This stack came without a calibration record.</p>\n");
  }
  if (!record.problem.empty()) {
    return Section("captured", heading, "", "<p class=\"note\">" + EscapeHtml(record.problem) + "</p>\n");
  }
  std::string figures;
  for (const CalibrationPicture& picture : record.pictures) figures += PhotoFigure(picture);
  std::string body =
      figures.empty() ? "<p class=\"note\">The record names no pictures.</p>\n" : Grid(figures, 4);
  if (!record.bands.empty()) {
    std::vector<std::vector<std::string>> rows{
        {"band", "frame", "gray card drift", "alignment shift, px", "median noise", "saturated", "notes"}};
    for (const CalibratedBand& band : record.bands) {
      rows.push_back({EscapeHtml(band.wavelength_nm) + " nm", EscapeHtml(band.frame),
                      EscapeHtml(band.gray_card_drift), EscapeHtml(band.alignment_shift_px),
                      EscapeHtml(band.median_noise), EscapeHtml(band.saturated_share),
                      EscapeHtml(band.notes)});
    }
    body += "<h3>Calibration</h3>\n" + DrawTable(rows) + StepsTable(record);
  }
  if (!record.notes.empty()) body += "<p class=\"note\">" + EscapeHtml(record.notes) + "</p>\n";
  if (!record.correlation.empty()) body += "<p class=\"note\">" + EscapeHtml(record.correlation) + "</p>\n";
  std::string lead = "What the camera saw, and how it became reflectance.";
  if (!record.session.empty()) lead += " Session: " + record.session + ".";
  return Section("captured", heading, lead, body);
}

std::string StackSection(const ReportContext& context) {
  const FitResult& fit = context.fit();
  const double brightest = RobustScale(std::span<const PlaneF>(fit.measured)).high;
  const Scale common{0.0, std::max(1e-3, 1.1 * brightest)};
  std::string figures;
  for (std::size_t band = 0; band < fit.bands.size(); ++band) {
    MapFigure figure;
    figure.heading = Nanometres(fit.bands[band].wavelength_nm);
    if (fit.bands[band].fwhm_nm > 0.0) figure.unit = FormatValue(fit.bands[band].fwhm_nm) + " nm wide";
    figure.map = ColourMap::kGray;
    figure.scale = common;
    figure.note = "mean " + FormatValue(MeanOf(fit.measured[band]));
    if (band < fit.noise.size() && !fit.noise[band].empty()) {
      figure.note += ", median noise " + FormatValue(QuantileOf(fit.noise[band].values(), 0.5), 2);
    }
    figures += DrawMapFigure(fit.measured[band], figure);
  }
  return Section("stack", "Calibrated stack",
                 "Reflectance in each band at the size of the fit, all on one scale from 0 to " +
                     FormatValue(common.high) + ". Noise is one standard deviation of a pixel.",
                 Grid(figures, 4));
}

std::string ComparisonSection(const ReportContext& context) {
  const FitResult& fit = context.fit();
  const Scale difference = [&] {
    const Scale scale = RobustScale(std::span<const PlaneF>(fit.residual));
    const double reach = std::max(std::abs(scale.low), std::abs(scale.high));
    return Scale{-reach, reach};
  }();
  std::string html =
      "<h3>Spectra</h3>\n" + SpectrumChart(context) + "<h3>Pictures</h3>\n<div class=\"triples\">\n";
  for (std::size_t band = 0; band < fit.bands.size(); ++band) {
    const Scale scale = RobustScale(fit.measured[band].values());
    html += "<div class=\"band\">" + BandLabel(context, band);
    html += Row("measured mean", MeanOf(fit.measured[band])) +
            Row("predicted mean", MeanOf(WhereFinite(fit.predicted[band], fit.measured[band])));
    if (band < fit.rms_residual_per_band.size()) html += Row("rms residual", fit.rms_residual_per_band[band]);
    html += "</div>\n" + DrawMapFigure(fit.measured[band], {"Measured", "", ColourMap::kGray, scale, ""});
    html += DrawMapFigure(fit.predicted[band], {"Predicted", "", ColourMap::kGray, scale, ""});
    html += DrawMapFigure(fit.residual[band],
                          {"Residual", "measured - predicted", ColourMap::kDiverging, difference, ""});
  }
  return Section(
      "comparison", "Measured and predicted",
      "Each band twice on its own scale of reflectance, and the difference on one scale for all bands.",
      html + "</div>\n");
}

std::string ResidualSection(const ReportContext& context) {
  const FitResult& fit = context.fit();
  Chart chart;
  chart.label = "rms residual per band";
  chart.x_label = "wavelength, nm";
  chart.y_label = "reflectance";
  chart.y_from = 0.0;
  chart.width = 560;
  chart.height = 300;
  ChartSeries noise{"noise of a pixel (median)", 0, context.wavelengths_nm, {}, {}, true, true, false};
  for (std::size_t band = 0; band < fit.bands.size(); ++band) {
    noise.y.push_back(band < fit.noise.size() ? QuantileOf(fit.noise[band].values(), 0.5) : NAN);
  }
  ChartSeries rms{"rms residual", 2,   context.wavelengths_nm, fit.rms_residual_per_band, {}, true,
                  false,          true};
  rms.x.resize(rms.y.size());
  chart.series = {std::move(rms), std::move(noise)};
  std::string left = "<div><h3>By band</h3>" + DrawChart(chart) + "</div>\n";
  std::string right;
  if (!fit.chi2_map.empty()) {
    const PlaneF chi2 = WithoutMasked(fit.chi2_map, fit.flags);
    right = DrawMapFigure(fit.chi2_map, {"chi2 per degree of freedom", "of each pixel", ColourMap::kInferno,
                                         RobustScale(chi2.values()), SpreadNote(chi2)});
  }
  return Section(
      "residual", "Residual",
      "Where and in which bands the prediction fails. Residuals near the noise are as good as can be.",
      "<div class=\"split\">" + left + right + "</div>\n");
}

}  // namespace dermap
