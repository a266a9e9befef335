// SPDX-License-Identifier: Apache-2.0
// The page of a fit of spectra: how well, which model, what is left, and each spectrum with its parameters.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fit/report_chart.h"
#include "fit/report_parts.h"
#include "fit/spectra/write_spectra.h"

namespace dermap {
namespace {

constexpr std::size_t kDrawn = 12;    // spectra with a chart of their own
constexpr std::size_t kListed = 500;  // spectra in the table

std::string Tile(const std::string& key, const std::string& value, const std::string& detail) {
  return "<div class=\"tile\"><span class=\"k\">" + EscapeHtml(key) + "</span><span class=\"v\">" +
         EscapeHtml(value) + "</span><span class=\"d\">" + EscapeHtml(detail) + "</span></div>\n";
}

ChartSeries Series(const std::string& name, int colour, const std::vector<double>& x, std::vector<double> y) {
  ChartSeries series;
  series.name = name;
  series.colour = colour;
  series.x = x;
  series.y = std::move(y);
  return series;
}

std::string Headline(const SpectraFit& fit, const std::string& name) {
  std::vector<double> rms;
  int unfinished = 0;
  for (const SpectrumFit& one : fit.fits) {
    rms.push_back(one.best().rms);
    unfinished += one.best().converged ? 0 : 1;
  }
  const std::vector<int> counts = fit.ChosenCounts();
  const std::size_t favourite = std::max_element(counts.begin(), counts.end()) - counts.begin();
  std::string html =
      "<p class=\"kicker\">dermap fit of spectra</p><h1>" + EscapeHtml(name) + "</h1>\n<div class=\"tiles\">";
  html += Tile("spectra", std::to_string(fit.fits.size()),
               fmt::format("{} wavelengths, {:g} to {:g} nm", fit.spectra.wavelengths_nm.size(),
                           fit.spectra.wavelengths_nm.front(), fit.spectra.wavelengths_nm.back()));
  html += Tile("median rms residual", fmt::format("{:.4f}", MedianOf(rms)),
               fmt::format("worst {:.4f}", *std::max_element(rms.begin(), rms.end())));
  html += Tile("most often chosen", std::string(SkinModelNames()[favourite]),
               fmt::format("{} of {} spectra", counts[favourite], fit.fits.size()));
  html += Tile("time", fmt::format("{:.1f} s", fit.seconds),
               unfinished == 0 ? "all converged" : fmt::format("{} not converged", unfinished));
  return html + "</div>\n";
}

std::string ModelsSection(const SpectraFit& fit) {
  std::vector<std::vector<std::string>> rows{
      {"model", "what it has", "free parameters", "chosen", "median rms"}};
  const std::vector<int> counts = fit.ChosenCounts();
  const auto rms = fit.RmsByModel();
  const std::vector<SkinModel> models = SkinModels(fit.options.tissue);
  for (std::size_t i = 0; i < models.size(); ++i) {
    if (rms[i].empty()) continue;
    rows.push_back({EscapeHtml(models[i].name), EscapeHtml(models[i].description),
                    std::to_string(models[i].free.size()), std::to_string(counts[i]),
                    fmt::format("{:.4f}", MedianOf(rms[i]))});
  }
  return Section(
      "models", "Which model",
      "Every spectrum was fitted with each of these; the one of least Bayesian information criterion is "
      "shown for it. It rises with the misfit and with the number of free parameters.",
      DrawTable(rows));
}

std::string ResidualSection(const SpectraFit& fit) {
  Chart chart;
  chart.label = "Mean residual over wavelength";
  chart.x_label = "wavelength, nm";
  chart.y_label = "measured - predicted";
  chart.reference_y = 0.0;
  const std::vector<double>& nm = fit.spectra.wavelengths_nm;
  const ChartSeries mean = Series("mean of all spectra", 1, nm, fit.MeanResidual());
  ChartSeries spread = Series("rms of all spectra", 2, nm, {});
  spread.dashed = true;
  for (std::size_t band = 0; band < mean.x.size(); ++band) {
    double square = 0.0;
    for (std::size_t i = 0; i < fit.fits.size(); ++i) {
      const double r = fit.spectra.rows[i].reflectance[band] - fit.fits[i].best().predicted[band];
      square += r * r / static_cast<double>(fit.fits.size());
    }
    spread.y.push_back(std::sqrt(square));
  }
  chart.series = {mean, spread};
  return Section(
      "residual", "What is left",
      "What all spectra have in common here is not noise: it is missing in the model or comes from the "
      "instrument.",
      DrawChart(chart));
}

std::string NameOf(const SpectraFit& fit, std::size_t i) {
  std::string name;
  for (std::size_t k = 0; k < fit.spectra.rows[i].labels.size() && k < 3; ++k) {
    name += (k > 0 ? ", " : "") + fit.spectra.label_names[k] + " " + fit.spectra.rows[i].labels[k];
  }
  return name;
}

std::string SpectrumFigure(const SpectraFit& fit, std::size_t i) {
  const ModelFit& best = fit.fits[i].best();
  const auto& nm = fit.spectra.wavelengths_nm;
  Chart chart;
  chart.label = "Measured and predicted spectrum of " + NameOf(fit, i);
  chart.x_label = "wavelength, nm";
  chart.y_label = "reflectance";
  chart.y_from = 0.0;
  ChartSeries measured = Series("measured", 1, nm, fit.spectra.rows[i].reflectance);
  measured.line = false;
  ChartSeries predicted = Series("predicted", 2, nm, best.predicted);
  predicted.markers = false;
  chart.series = {measured, predicted};
  Chart residual;
  residual.label = "Residual of " + NameOf(fit, i);
  residual.x_label = "wavelength, nm";
  residual.y_label = "measured - predicted";
  residual.reference_y = 0.0;
  residual.height = 180;
  ChartSeries left = Series("", 1, nm, {});
  for (std::size_t band = 0; band < nm.size(); ++band) {
    left.y.push_back(fit.spectra.rows[i].reflectance[band] - best.predicted[band]);
  }
  residual.series = {left};
  return "<figure><figcaption>" + EscapeHtml(NameOf(fit, i)) +
         fmt::format(" <span class=\"unit\">{}, rms {:.4f}</span></figcaption>", best.model.name, best.rms) +
         DrawChart(chart) + DrawChart(residual) + "</figure>\n";
}

// All where they are few, else from the best to the worst in even steps.
std::string SpectraSection(const SpectraFit& fit) {
  std::vector<std::size_t> order(fit.fits.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::string lead = "Dots are measured, lines are the model.";
  if (order.size() > kDrawn) {
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return fit.fits[a].best().rms < fit.fits[b].best().rms; });
    std::vector<std::size_t> some;
    for (std::size_t i = 0; i < kDrawn; ++i) some.push_back(order[i * (order.size() - 1) / (kDrawn - 1)]);
    order = std::move(some);
    lead += " Of all spectra the best, the worst and ten in even steps between.";
  }
  std::string figures;
  for (const std::size_t i : order) figures += SpectrumFigure(fit, i);
  return Section("spectra", "Measured and predicted", lead, Grid(figures, 2));
}

std::string ValueCell(const ModelFit& fit, int parameter) {
  const auto p = static_cast<SkinParameter>(parameter);
  const bool is_free = std::find(fit.model.free.begin(), fit.model.free.end(), p) != fit.model.free.end();
  if (!is_free) return "<span class=\"unit\">" + fmt::format("{:.3g}", fit.skin[parameter]) + "</span>";
  const auto is_in = [&](const std::vector<SkinParameter>& list) {
    return std::find(list.begin(), list.end(), p) != list.end();
  };
  if (is_in(fit.at_bound)) return fmt::format("{:.3g} (bound)", fit.skin[parameter]);
  return fmt::format("{:.3g} &plusmn; {:.2g}{}", fit.skin[parameter], fit.sigma[parameter],
                     is_in(fit.not_identifiable) ? " (not told)" : "");
}

std::string ParametersSection(const SpectraFit& fit) {
  std::vector<std::vector<std::string>> rows{{EscapeHtml(fit.spectra.label_names.front()), "model", "rms"}};
  for (const SkinParameterInfo& info : kSkinParameters) rows[0].push_back(EscapeHtml(info.name));
  const std::size_t listed = std::min(kListed, fit.fits.size());
  for (std::size_t i = 0; i < listed; ++i) {
    const ModelFit& best = fit.fits[i].best();
    rows.push_back({EscapeHtml(fit.spectra.rows[i].labels.front()), EscapeHtml(best.model.name),
                    fmt::format("{:.4f}", best.rms)});
    for (int p = 0; p < kSkinParameterCount; ++p) rows.back().push_back(ValueCell(best, p));
  }
  std::string lead =
      "Plus and minus is one standard deviation, noise and what the model lacks taken together. Gray: not "
      "free in the "
      "chosen model. A value at a bound has no error bar; (not told): the error bar is wider than half of "
      "the range.";
  if (listed < fit.fits.size()) lead += fmt::format(" The first {}; all are in spectra.csv.", listed);
  return Section("parameters", "Parameters", lead, "<div class=\"wide\">" + DrawTable(rows) + "</div>");
}

std::string GlossarySection() {
  std::vector<std::vector<std::string>> rows{{"parameter", "meaning", "unit", "range"}};
  for (const SkinParameterInfo& info : kSkinParameters) {
    rows.push_back({EscapeHtml(info.name), EscapeHtml(info.description), EscapeHtml(info.unit),
                    fmt::format("{:g} to {:g}", info.lower, info.upper)});
  }
  return Section("glossary", "What the parameters are", "", DrawTable(rows));
}

}  // namespace

std::string SpectraReport(const SpectraFit& fit, const std::string& name) {
  std::string html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n<title>" +
      EscapeHtml(name) + " - dermap fit of spectra</title>\n<style>";
  html += ReportStyle();
  html += "</style></head>\n<body>\n<header class=\"top\">\n" + Headline(fit, name) + "</header>\n<main>\n";
  html += ModelsSection(fit) + ResidualSection(fit) + SpectraSection(fit) + ParametersSection(fit) +
          GlossarySection();
  return html +
         "<footer>Written by dermap. Everything on this page is part of this one "
         "file.</footer>\n</main></body></html>\n";
}

}  // namespace dermap
