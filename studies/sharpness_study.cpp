// SPDX-License-Identifier: Apache-2.0
// Edges of every width through the judge and through the forward model.
#include "studies/sharpness_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/files/atomic_file.h"
#include "studies/chart_sheet.h"

namespace dermap {
namespace {

constexpr double kPixel_mm = 0.03;
constexpr double kBeside_mm = 0.9;  // of even skin on either side of an edge
constexpr double kAsked = 0.02;     // rms beyond the judge's noise

void Judge(SharpnessStudy& study) {
  double reciprocal = 0.0, noise = 0.0;
  for (const SharpnessPoint& p : study.points) {
    reciprocal = std::max(reciprocal, p.reciprocal.rms - p.reciprocal.noise);
    noise = std::max(noise, p.reciprocal.noise);
  }
  study.verdicts.push_back(
      {"reciprocal coupling, rms beyond the judge's noise, at every sharpness", reciprocal, kAsked});
  study.verdicts.push_back({"the judge's own noise", noise, 0.03});
  for (auto p = study.points.rbegin(); p != study.points.rend() && p->gather.net <= kAsked; ++p)
    study.gather_edge = p->width_per_mean_free_path;
}

ChartSeries Curve(const SharpnessStudy& study, const char* name, int colour,
                  StripMisfit SharpnessPoint::*misfit, double StripMisfit::*value) {
  ChartSeries series;
  series.name = name;
  series.colour = colour;
  for (const SharpnessPoint& p : study.points) {
    series.x.push_back(std::max(p.width_per_mean_free_path, 0.1));
    series.y.push_back(std::max(100.0 * (p.*misfit.*value), 0.1));
  }
  return series;
}

Chart ErrorChart(const SharpnessStudy& study, double StripMisfit::*value, const char* label) {
  Chart chart;
  chart.label = label;
  chart.x_label = "width of the edge over the mean free path (0.1: a step)";
  chart.y_label = label;
  chart.log_x = chart.log_y = true;
  chart.width = 600;
  chart.series = {
      Curve(study, "multipole, gather coupling: as published", 2, &SharpnessPoint::published, value),
      Curve(study, "exact, gather coupling", 3, &SharpnessPoint::gather, value),
      Curve(study, "exact, reciprocal coupling: the default", 1, &SharpnessPoint::reciprocal, value)};
  return chart;
}

nlohmann::json Json(const StripMisfit& m) {
  return {{"rms", m.rms}, {"judge_noise", m.noise}, {"net", m.net}, {"worst", m.worst}};
}

}  // namespace

SharpnessStudy RunSharpnessStudy(const SharpnessStudyOptions& options, const ProgressFunction& progress) {
  SharpnessStudy study;
  study.seed = options.seed;
  study.photons = options.quick ? 1200000 : 2500000;
  const std::vector<double> widths =  // in mean free paths of scattering in the epidermis
      options.quick ? std::vector<double>{0.0, 4.0} : std::vector<double>{0.0, 0.5, 1.0, 2.0, 4.0, 8.0};
  const Chromophores chromophores(ConfigDirectory() / "spectra");
  const auto exact = MakeProfileSource("exact"), multipole = MakeProfileSource("multipole");
  const double mean_free_path_mm = 1.0 / ReducedScatteringEpidermis(study.wavelength_nm, {});
  const int threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  for (const double width : widths) {
    SharpnessPoint point;
    point.width_mm = width * mean_free_path_mm;
    point.width_per_mean_free_path = width;
    const Strip strip{study.wavelength_nm, kPixel_mm, MelaninEdge(point.width_mm, kPixel_mm, kBeside_mm)};
    // Wider strips need more photons for the same noise.
    const double share = static_cast<double>(strip.skin.size()) * kPixel_mm / (2.0 * kBeside_mm);
    const auto photons = static_cast<std::uint64_t>(static_cast<double>(study.photons) * share);
    const JudgedStrip judge = JudgeStrip(strip, chromophores, photons, study.seed, threads);
    const auto misfit = [&](const ProfileSource& source, Coupling coupling) {
      return Compare(RenderStrip(strip, chromophores, source, coupling), judge);
    };
    point.reciprocal = misfit(*exact, Coupling::kReciprocal);
    point.gather = misfit(*exact, Coupling::kGather);
    point.published = misfit(*multipole, Coupling::kGather);
    study.points.push_back(point);
    if (progress) progress(static_cast<double>(study.points.size()) / static_cast<double>(widths.size()));
  }
  Judge(study);
  return study;
}

void WriteSharpnessStudy(const std::filesystem::path& folder, const SharpnessStudy& study) {
  nlohmann::json json{{"study", "sharpness"},
                      {"wavelength_nm", study.wavelength_nm},
                      {"photons", study.photons},
                      {"seed", study.seed},
                      {"gather_edge_mean_free_paths", study.gather_edge},
                      {"points", nlohmann::json::array()},
                      {"verdicts", VerdictsAsJson(study.verdicts)}};
  std::string csv =
      "# relative misfit to Monte Carlo of a strip with an edge of C_m 0.05 | 0.3, 560 nm; net: without the "
      "judge's noise\n"
      "width_mm,width_per_mean_free_path,judge_noise,reciprocal_net,reciprocal_worst,gather_net,gather_worst,"
      "published_net,published_worst\n";
  for (const SharpnessPoint& p : study.points) {
    json["points"].push_back({{"width_mm", p.width_mm},
                              {"width_per_mean_free_path", p.width_per_mean_free_path},
                              {"reciprocal", Json(p.reciprocal)},
                              {"gather", Json(p.gather)},
                              {"published", Json(p.published)}});
    csv += fmt::format("{:.5g},{:.4g},{:.4g},{:.4g},{:.4g},{:.4g},{:.4g},{:.4g},{:.4g}\n", p.width_mm,
                       p.width_per_mean_free_path, p.reciprocal.noise, p.reciprocal.net, p.reciprocal.worst,
                       p.gather.net, p.gather.worst, p.published.net, p.published.worst);
  }
  const std::vector<TitledChart> charts{
      {"Beside an edge of melanin: rms over the strip",
       ErrorChart(study, &StripMisfit::net, "rms error without the judge's noise, %")},
      {"Beside an edge of melanin: the worst pixel",
       ErrorChart(study, &StripMisfit::worst, "largest error beyond 3 standard errors, %")}};
  FileBatch files;
  WriteFileAtomically(folder / "sharpness.csv", csv);
  WriteFileAtomically(folder / "sharpness.json", json.dump(2) + "\n");
  WriteFileAtomically(folder / "sharpness.svg", DrawChartSheet(charts, 2));
  files.Commit();
}

}  // namespace dermap
