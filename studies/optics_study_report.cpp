// SPDX-License-Identifier: Apache-2.0
// The optics study as numbers, chart and page.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "common/files/atomic_file.h"
#include "fit/report_parts.h"
#include "studies/chart_sheet.h"
#include "studies/optics_study.h"

namespace dermap {
namespace {

enum Colour { kInk, kBlue, kOrange, kGreen, kPurple };
constexpr const char* kMuALabel = "absorption of the epidermis, 1/mm";

template <class Points, class Value>
std::vector<double> Column(const Points& points, const Value& value) {
  std::vector<double> column;
  for (const auto& point : points) column.push_back(value(point));
  return column;
}

std::vector<double> MuA(const OpticsStudy& study) {
  return Column(study.curve, [](const auto& p) { return p.isotropic.mu_a_epidermis; });
}

double PerCentOff(double value, double judge) {
  return 100.0 * (value / judge - 1.0);
}

ChartSeries Curve(std::string name, Colour colour, std::vector<double> x, std::vector<double> y) {
  ChartSeries series;
  series.name = std::move(name);
  series.colour = colour;
  series.x = std::move(x);
  series.y = std::move(y);
  series.markers = false;
  return series;
}

ChartSeries Dots(std::string name, Colour colour, std::vector<double> x, std::vector<double> y,
                 std::vector<double> error) {
  ChartSeries series = Curve(std::move(name), colour, std::move(x), std::move(y));
  series.error = std::move(error);
  series.line = false;
  series.markers = true;
  return series;
}

Chart EmptyChart(std::string label, std::string y_label) {
  Chart chart;
  chart.label = std::move(label);
  chart.x_label = kMuALabel;
  chart.y_label = std::move(y_label);
  chart.log_x = true;
  chart.width = 600;
  chart.height = 340;
  return chart;
}

Chart ErrorChart(const OpticsStudy& study) {
  Chart chart = EmptyChart("Error of the reflectance of two-layer skin over the absorption of the epidermis",
                           "error against adding-doubling, %");
  chart.reference_y = 0.0;
  const auto error_of = [&](double OpticsPoint::*value) {
    return Column(study.curve,
                  [&](const auto& p) { return PerCentOff(p.isotropic.*value, p.isotropic.adding_doubling); });
  };
  chart.series = {
      Curve("multipole, as published", kOrange, MuA(study), error_of(&OpticsPoint::multipole)),
      Curve("multipole-symmetric, the shortcut", kPurple, MuA(study),
            error_of(&OpticsPoint::multipole_symmetric)),
      Curve("exact", kBlue, MuA(study), error_of(&OpticsPoint::exact)),
      Dots("Monte Carlo, one standard error", kInk, MuA(study),
           Column(study.curve,
                  [](const auto& p) { return PerCentOff(p.monte_carlo.value, p.isotropic.adding_doubling); }),
           Column(study.curve, [](const auto& p) {
             return 100.0 * p.monte_carlo.standard_error / p.isotropic.adding_doubling;
           }))};
  return chart;
}

Chart CloseUpChart(const OpticsStudy& study) {
  Chart chart =
      EmptyChart("The same for the exact optics alone, magnified", "error against adding-doubling, %");
  chart.reference_y = 0.0;
  const auto error_of = [&](double OpticsPoint::*value) {
    return Column(study.curve,
                  [&](const auto& p) { return PerCentOff(p.isotropic.*value, p.isotropic.adding_doubling); });
  };
  ChartSeries tables = Curve("exact, as the tables of a fit hold it (typical neighbours)", kGreen, MuA(study),
                             error_of(&OpticsPoint::exact_tables));
  chart.series = {
      Curve("exact, row by row (dermap optics)", kBlue, MuA(study), error_of(&OpticsPoint::exact)), tables,
      ErrorChart(study).series.back()};
  return chart;
}

// Largest error at each mu_a of the epidermis, over everything else that the sweep varies.
ChartSeries WorstOf(const OpticsStudy& study, const char* name, Colour colour, double OpticsPoint::*value) {
  std::map<double, double> worst;
  for (const OpticsPoint& p : study.sweep) {
    double& at = worst[p.mu_a_epidermis];
    at = std::max(at, std::abs(PerCentOff(p.*value, p.adding_doubling)));
  }
  std::vector<double> x, y;
  for (const auto& [mu_a, error] : worst) {
    x.push_back(mu_a);
    y.push_back(error);
  }
  return Curve(name, colour, x, y);
}

Chart WorstChart(const OpticsStudy& study) {
  Chart chart = EmptyChart(
      "Largest error over wavelengths 400 to 720 nm, dermis 0.02 to 30 per mm, junction A 1 and 0.3",
      "largest error, %");
  chart.log_y = true;
  chart.series = {
      WorstOf(study, "multipole, as published", kOrange, &OpticsPoint::multipole),
      WorstOf(study, "multipole-symmetric, the shortcut", kPurple, &OpticsPoint::multipole_symmetric),
      WorstOf(study, "exact, as the tables of a fit hold it", kGreen, &OpticsPoint::exact_tables),
      WorstOf(study, "exact, row by row", kBlue, &OpticsPoint::exact)};
  return chart;
}

Chart AnisotropyChart(const OpticsStudy& study) {
  Chart chart = EmptyChart(
      "Change of the reflectance when scattering has a forward peak, at the same reduced scattering",
      fmt::format("change by g = {}, %", study.anisotropy));
  chart.reference_y = 0.0;
  chart.reference_name = "isotropic";
  const auto against = [](const auto& p, double value) {
    return PerCentOff(value, p.isotropic.adding_doubling);
  };
  chart.series = {
      Curve("exact, anisotropy set", kBlue, MuA(study),
            Column(study.curve, [&](const auto& p) { return against(p, p.peaked_exact); })),
      Dots("Monte Carlo, one standard error", kInk, MuA(study),
           Column(study.curve, [&](const auto& p) { return against(p, p.peaked_monte_carlo.value); }),
           Column(study.curve, [](const auto& p) {
             return 100.0 * p.peaked_monte_carlo.standard_error / p.isotropic.adding_doubling;
           }))};
  return chart;
}

Chart SingleChart(const OpticsStudy& study) {
  Chart chart = EmptyChart("Share of the reflectance that was scattered exactly once",
                           "scattered once, % of reflectance");
  chart.y_from = 0.0;
  chart.series = {
      Curve("isotropic, by mu_s'", kBlue, MuA(study),
            Column(study.curve, [](const auto& p) { return 100.0 * p.single / p.isotropic.exact; })),
      Curve(fmt::format("g = {}, real events", study.anisotropy), kGreen, MuA(study),
            Column(study.curve, [](const auto& p) { return 100.0 * p.peaked_single / p.peaked_exact; })),
      Dots("Monte Carlo, isotropic, one standard error", kInk, MuA(study),
           Column(study.curve,
                  [](const auto& p) { return 100.0 * p.monte_carlo_single.value / p.isotropic.exact; }),
           Column(study.curve, [](const auto& p) {
             return 100.0 * p.monte_carlo_single.standard_error / p.isotropic.exact;
           }))};
  return chart;
}

Chart PolarizerChart(const OpticsStudy& study) {
  Chart chart = EmptyChart("Reflectance with and without light that was scattered once", "reflectance");
  chart.log_y = true;
  const auto curve_of = [&](const char* name, Colour colour, const auto& value) {
    return Curve(name, colour, MuA(study), Column(study.curve, value));
  };
  chart.series = {
      curve_of("all light, isotropic", kBlue, [](const auto& p) { return p.isotropic.exact; }),
      curve_of("without what was scattered once: the bound of crossed polarizers", kBlue,
               [](const auto& p) { return p.isotropic.exact - p.single; }),
      curve_of("all light, with a forward peak", kGreen, [](const auto& p) { return p.peaked_exact; }),
      curve_of("without what was scattered once", kGreen,
               [](const auto& p) { return p.peaked_exact - p.peaked_single; })};
  chart.series[1].dashed = chart.series[3].dashed = true;
  return chart;
}

std::vector<TitledChart> Charts(const OpticsStudy& study) {
  const std::string skin =
      fmt::format("{} nm, dermis {}/mm", study.curve_wavelength_nm, study.curve_mu_a_dermis);
  return {{"How wrong the reflectance is: " + skin, ErrorChart(study)},
          {"The exact optics alone, magnified: " + skin, CloseUpChart(study)},
          {"Largest error over 400-720 nm, all dermis, junctions", WorstChart(study)},
          {fmt::format("What a forward peak changes (g = {} at the same mu_s')", study.anisotropy),
           AnisotropyChart(study)},
          {"Light that was scattered exactly once", SingleChart(study)},
          {"What crossed polarizers can take out at most", PolarizerChart(study)}};
}

std::string Csv(const OpticsStudy& study) {
  std::string text =
      "# reflectance of homogeneous two-layer skin, fractions; se: standard error; peaked: Henyey-Greenstein "
      "at the same "
      "mu_s'\n"
      "part,wavelength_nm,mu_a_epidermis_per_mm,mu_a_dermis_per_mm,junction_absorbance,adding_doubling,exact,"
      "exact_tables,"
      "multipole,multipole_symmetric,monte_carlo,monte_carlo_se,single,monte_carlo_single,monte_carlo_single_"
      "se,"
      "peaked_adding_doubling,peaked_exact,peaked_single,peaked_monte_carlo,peaked_monte_carlo_se\n";
  const auto point = [&](const char* part, const OpticsPoint& p) {
    text += fmt::format("{},{},{:.6g},{:.6g},{},{:.8g},{:.8g},{:.8g},{:.8g},{:.8g}", part, p.wavelength_nm,
                        p.mu_a_epidermis, p.mu_a_dermis, p.junction_absorbance, p.adding_doubling, p.exact,
                        p.exact_tables, p.multipole, p.multipole_symmetric);
  };
  for (const OpticsCurvePoint& p : study.curve) {
    point("curve", p.isotropic);
    text +=
        fmt::format(",{:.8g},{:.3g},{:.8g},{:.8g},{:.3g},{:.8g},{:.8g},{:.8g},{:.8g},{:.3g}\n",
                    p.monte_carlo.value, p.monte_carlo.standard_error, p.single, p.monte_carlo_single.value,
                    p.monte_carlo_single.standard_error, p.peaked_adding_doubling, p.peaked_exact,
                    p.peaked_single, p.peaked_monte_carlo.value, p.peaked_monte_carlo.standard_error);
  }
  for (const OpticsPoint& p : study.sweep) {
    point("sweep", p);
    text += ",,,,,,,,,,\n";
  }
  return text;
}

nlohmann::json Json(const OpticsStudy& study) {
  return {{"study", "optics"},
          {"photons", study.photons},
          {"photons_with_peak", study.peaked_photons},
          {"seed", study.seed},
          {"anisotropy", study.anisotropy},
          {"curve",
           {{"wavelength_nm", study.curve_wavelength_nm},
            {"mu_a_dermis_per_mm", study.curve_mu_a_dermis},
            {"junction_absorbance", study.curve_junction_absorbance},
            {"points", study.curve.size()}}},
          {"sweep_points", study.sweep.size()},
          {"verdicts", VerdictsAsJson(study.verdicts)}};
}

std::string Page(const OpticsStudy& study) {
  std::vector<std::vector<std::string>> verdicts{{"claim", "worst", "limit", ""}};
  for (const Verdict& v : study.verdicts) {
    verdicts.push_back(
        {EscapeHtml(v.claim), FormatValue(v.worst), FormatValue(v.limit), v.holds() ? "holds" : "FAILS"});
  }
  std::string figures;
  for (const TitledChart& titled : Charts(study)) {
    figures += "<div><h3>" + EscapeHtml(titled.title) + "</h3>" + DrawChart(titled.chart) + "</div>\n";
  }
  const std::string lead = fmt::format(
      "Homogeneous two-layer skin, normal incidence, against two judges that share no optics code with the "
      "product: "
      "adding-doubling (without noise) and Monte Carlo ({} photons a point, {} with a forward peak, seed "
      "{}).",
      study.photons, study.peaked_photons, study.seed);
  return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><title>How right the "
         "optics are</title>"
         "<style>" +
         std::string(ReportStyle()) + "</style></head><body><main><h1>How right the optics are</h1>" +
         Section("charts", "Over the absorption of the epidermis", lead, Grid(figures, 2)) +
         Section("verdicts", "Verdicts", "What the study asserts, and the largest value it met.",
                 DrawTable(verdicts)) +
         "</main></body></html>\n";
}

}  // namespace

void WriteOpticsStudy(const std::filesystem::path& folder, const OpticsStudy& study) {
  FileBatch files;
  WriteFileAtomically(folder / "optics.csv", Csv(study));
  WriteFileAtomically(folder / "optics.svg", DrawChartSheet(Charts(study), 2));
  WriteFileAtomically(folder / "optics.html", Page(study));
  WriteFileAtomically(folder / "optics.json", Json(study).dump(2) + "\n");
  files.Commit();
}

}  // namespace dermap
