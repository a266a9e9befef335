// SPDX-License-Identifier: Apache-2.0
// The series cut after every term.
#include "studies/orders_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/files/atomic_file.h"
#include "common/transport/forward_model.h"
#include "studies/chart_sheet.h"

namespace dermap {
namespace {

constexpr int kMostTerms = 8, kReferenceTerms = 40;
constexpr double kPatch_mm = 7.5;
constexpr double kFloor = 1e-6;  // of the charts

struct Skin {
  const char* name;
  ParameterVector parameters;  // C_m, beta_m, C_he, C_bc, C_hd
};
// Hardly any pigment and blood; and as much as table 1 has.
constexpr Skin kSkins[] = {{"least absorbing", {0.005, 0.62, 0.002, 0.0, 0.005}},
                           {"most absorbing", {0.5, 0.62, 0.05, 0.05, 0.1}}};

double RelativeRms(const PlaneF& found, const PlaneF& truth) {
  double square = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i)
    square += std::pow(double(found.data()[i]) / truth.data()[i] - 1.0, 2);
  return std::sqrt(square / static_cast<double>(found.size()));
}

// The closed form's series under wide light, cut after each term.
std::vector<double> UniformErrors(const BandTables& tables, const Absorbers& absorbers,
                                  const ParameterVector& p, double junction_absorbance) {
  const auto above = static_cast<float>(absorbers.MuAEpidermis(p)),
             below = static_cast<float>(absorbers.MuADermis(p));
  const double A2 = std::exp(-2.0 * junction_absorbance);
  const double r1 = tables.r1_forward.Total(above), r2 = tables.r2_diffuse.Total(below);
  const double first = (tables.t1_ballistic.Total(above) * tables.r2_normal.Total(below) +
                        tables.t1_forward.Total(above) * r2) *
                       A2 * tables.t1_backward.Total(above);
  const double quotient = A2 * tables.r1_backward.Total(above) * r2;
  const double whole = r1 + first / (1.0 - quotient);
  std::vector<double> errors;
  double sum = r1, term = first;
  for (int terms = 0; terms <= kMostTerms; ++terms) {
    errors.push_back(std::abs(1.0 - sum / whole));
    sum += term;
    term *= quotient;
  }
  return errors;
}

std::vector<PlaneF> Render(const ForwardModel& base, int terms, bool close, const ParameterMaps& maps,
                           std::vector<BandChoice>* choices = nullptr) {
  ForwardOptions options = base.options();
  options.terms = terms;
  options.close_series = close;
  return base.With(options).Render(maps, {}, choices);
}

void AddCurves(const Skin& skin, const ForwardModel& model, int size, OrdersStudy& study) {
  const ParameterMaps maps(size, size, skin.parameters);
  const std::vector<PlaneF> truth = Render(model, kReferenceTerms, true, maps);
  std::vector<BandChoice> choices;
  Render(model, kAutomaticTerms, true, maps, &choices);
  const std::size_t first = study.curves.size();
  for (const BandOptics& band : model.optics()) {
    const BandOptics::Node& center = band.nodes[band.center];
    OrdersStudy::Curve& curve = study.curves.emplace_back();
    curve.skin = skin.name;
    curve.wavelength_nm = band.band.wavelength_nm;
    curve.automatic_terms = choices[study.curves.size() - 1 - first].terms;
    curve.uniform =
        UniformErrors(center.tables, center.absorbers, skin.parameters, model.tissue().junction_absorbance);
  }
  for (int terms = 0; terms <= kMostTerms; ++terms) {
    const std::vector<PlaneF> open = Render(model, terms, false, maps),
                              closed = Render(model, terms, true, maps);
    for (std::size_t b = 0; b < open.size(); ++b) {
      study.curves[first + b].open.push_back(RelativeRms(open[b], truth[b]));
      study.curves[first + b].closed.push_back(RelativeRms(closed[b], truth[b]));
    }
  }
  for (std::size_t c = first; c < study.curves.size(); ++c) {
    OrdersStudy::Curve& curve = study.curves[c];
    const auto enough =
        std::find_if(curve.uniform.begin(), curve.uniform.end(), [](double e) { return e <= 0.01; });
    curve.terms_99 = static_cast<int>(enough - curve.uniform.begin());
  }
}

Chart ErrorChart(const OrdersStudy& study, const std::string& skin,
                 std::vector<double> OrdersStudy::Curve::*errors) {
  Chart chart;
  chart.label = chart.y_label = "error relative to 40 terms";
  chart.x_label = "terms after light that never left the epidermis";
  chart.log_y = true;
  chart.width = 600;
  int colour = 0;
  for (const OrdersStudy::Curve& curve : study.curves) {
    if (curve.skin != skin) continue;
    ChartSeries series;
    series.name = fmt::format("{:.0f} nm", curve.wavelength_nm);
    series.colour = ++colour;
    for (std::size_t t = 0; t < (curve.*errors).size(); ++t) {
      series.x.push_back(static_cast<double>(t));
      series.y.push_back(std::max((curve.*errors)[t], kFloor));
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

}  // namespace

OrdersStudy RunOrdersStudy(const OrdersStudyOptions& options, const ProgressFunction& progress) {
  const std::vector<double> wavelengths = options.quick
                                              ? std::vector<double>{450, 560, 700}
                                              : std::vector<double>{450, 480, 520, 560, 600, 650, 700};
  std::vector<Band> bands;
  for (const double wavelength_nm : wavelengths) bands.push_back({wavelength_nm, 0.0});
  const int size = options.quick ? 32 : 128;
  ImagingConditions conditions;
  conditions.pixel_size_mm = kPatch_mm / size;
  ForwardOptions forward;
  forward.margin_mm = 3.0;
  const Chromophores chromophores(ConfigDirectory() / "spectra");
  const auto source = MakeProfileSource("exact");
  const ForwardModel model(chromophores, *source, {}, bands, conditions, forward, [&](double done) {
    if (progress) progress(0.5 * done);
  });
  OrdersStudy study;
  double automatic = 0.0, most_terms = 0.0;
  for (const Skin& skin : kSkins) {
    AddCurves(skin, model, size, study);
    if (progress)
      progress(0.5 + 0.5 * static_cast<double>(study.curves.size()) /
                         static_cast<double>(std::size(kSkins) * bands.size()));
  }
  for (const OrdersStudy::Curve& curve : study.curves) {
    const int terms = std::min(curve.automatic_terms, kMostTerms);
    automatic = std::max(automatic, curve.closed[terms]);
    if (curve.wavelength_nm <= 600.0) most_terms = std::max(most_terms, double(curve.terms_99));
  }
  study.verdicts = {
      {"closed series of as many terms as the engine takes, error", automatic, 1e-3},
      {"terms that hold 99 % of the light up to 600 nm, least absorbing skin ([D08]: 5)", most_terms, 5.0}};
  return study;
}

void WriteOrdersStudy(const std::filesystem::path& folder, const OrdersStudy& study) {
  nlohmann::json json{
      {"study", "orders"}, {"curves", nlohmann::json::array()}, {"verdicts", VerdictsAsJson(study.verdicts)}};
  std::string csv =
      "# error relative to 40 terms: uniform skin under wide light (closed form), a lit window of 7.5 mm "
      "with the series "
      "cut, and with its rest added\nskin,wavelength_nm,terms,uniform,window_cut,window_closed\n";
  std::vector<TitledChart> charts;
  for (const auto& [title, errors] : {std::pair{"series that end, wide light", &OrdersStudy::Curve::uniform},
                                      std::pair{"the rest added, lit window", &OrdersStudy::Curve::closed}})
    for (const Skin& skin : kSkins)
      charts.push_back({fmt::format("{} skin: {}", skin.name, title), ErrorChart(study, skin.name, errors)});
  for (const OrdersStudy::Curve& curve : study.curves) {
    json["curves"].push_back({{"skin", curve.skin},
                              {"wavelength_nm", curve.wavelength_nm},
                              {"uniform", curve.uniform},
                              {"window_cut", curve.open},
                              {"window_closed", curve.closed},
                              {"automatic_terms", curve.automatic_terms},
                              {"terms_99", curve.terms_99}});
    for (std::size_t t = 0; t < curve.open.size(); ++t)
      csv += fmt::format("{},{:.0f},{},{:.4g},{:.4g},{:.4g}\n", curve.skin, curve.wavelength_nm, t,
                         curve.uniform[t], curve.open[t], curve.closed[t]);
  }
  FileBatch files;
  WriteFileAtomically(folder / "orders.csv", csv);
  WriteFileAtomically(folder / "orders.json", json.dump(2) + "\n");
  WriteFileAtomically(folder / "orders.svg", DrawChartSheet(charts, 2));
  files.Commit();
}

}  // namespace dermap
