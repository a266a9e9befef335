// SPDX-License-Identifier: Apache-2.0
// The forward model's times, each with its error beside it, on the recorded scenes: 256 x 256 pixels of 7.5
// mm, eight bands of 10 nm. Ratios are of times in one run; --summary FILE.json writes them under fixed keys
// (docs/formats.md).
#include <benchmark/benchmark.h>
#include <malloc.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "common/core/kernel.h"
#include "common/core/lanes.h"
#include "common/core/parallel.h"
#include "common/files/maps.h"
#include "common/transport/convolver.h"
#include "common/transport/forward_model.h"
#include "common/transport/paths/stencil.h"
#include "common/transport/plane_math.h"

namespace dermap {
namespace {

constexpr int kSize = 256;
constexpr double kPatch_mm = 7.5;
constexpr int kPaperTerms = 5;  // [D08 7]

const Chromophores& AllChromophores() {
  static const Chromophores chromophores(ConfigDirectory() / "spectra");
  return chromophores;
}

const ProfileSource& Source() {
  static const std::unique_ptr<ProfileSource> source = MakeProfileSource("exact");
  return *source;
}

// Maps of a recorded scene, 256 x 256.
const ParameterMaps& Scene(const std::string& name) {
  static std::map<std::string, ParameterMaps> scenes;
  ParameterMaps& maps = scenes[name];
  if (maps.planes[0].empty())
    maps = ReadMaps(std::filesystem::path(DERMAP_SAMPLES) / name / "truth" / "maps.exr").maps;
  return maps;
}
const ParameterMaps& Freckles() {
  return Scene("light_freckles");
}

ParameterMaps Resized(const ParameterMaps& maps, int size) {
  ParameterMaps resized(size, size, ParameterVector{});
  for (int k = 0; k < kParameterCount; ++k) {
    const PlaneF& plane = maps.planes[k];
    const cv::Mat in(plane.height(), plane.width(), CV_32F, const_cast<float*>(plane.data()));
    cv::Mat out(size, size, CV_32F, resized.planes[k].data());
    cv::resize(in, out, out.size(), 0, 0, cv::INTER_LINEAR);
  }
  return resized;
}

std::vector<Band> Bands(int count) {
  std::vector<Band> bands;
  for (const double wavelength_nm : {450, 480, 510, 540, 560, 580, 610, 650})
    if (static_cast<int>(bands.size()) < count) bands.push_back({wavelength_nm, 10.0});
  return bands;
}

// Models are kept: what is timed is a render with tables and plans at hand.
const ForwardModel& Model(Engine engine, int size, int bands, int terms, double tolerance,
                          bool one_response) {
  static std::map<std::string, std::unique_ptr<ForwardModel>> models;
  char key[120];
  std::snprintf(key, sizeof key, "%d %d %d %d %g %d", static_cast<int>(engine), size, bands, terms, tolerance,
                one_response);
  std::unique_ptr<ForwardModel>& model = models[key];
  if (model) return *model;
  ImagingConditions conditions;
  conditions.pixel_size_mm = kPatch_mm / size;
  ForwardOptions options;
  options.engine = engine;
  options.terms = one_response ? 0 : terms;
  options.tolerance = tolerance;
  std::vector<Band> list = Bands(bands);
  if (one_response) list = {{560.0, 0.0}};
  model =
      std::make_unique<ForwardModel>(AllChromophores(), Source(), TissueConfig{}, list, conditions, options);
  return *model;
}
// What is asked is an error of 1e-3; the engine keeps its own estimate below its tolerance, which is on the
// safe side, and the error that is written beside each time is measured.
constexpr double kTolerance = 2e-3, kFine = 1e-5;

void TimeRender(benchmark::State& state, const ForwardModel& model, const ParameterMaps& maps, int threads) {
  const ThreadLimit limit(threads);
  benchmark::DoNotOptimize(model.Render(maps));
  for (auto _ : state) benchmark::DoNotOptimize(model.Render(maps));
}

// One heterogeneous convolution: R1+ of the scene's light, all that it needs included.
void ConvolutionCascade(benchmark::State& state) {
  TimeRender(state, Model(Engine::kCascade, kSize, 1, 0, kTolerance, true), Freckles(), 1);
}
void ConvolutionLowRank(benchmark::State& state) {
  TimeRender(state, Model(Engine::kLowRank, kSize, 1, 0, kTolerance, true), Freckles(), 1);
}
void RenderCascade(benchmark::State& state) {
  TimeRender(state, Model(Engine::kCascade, kSize, 8, kPaperTerms, kTolerance, false), Freckles(), 2);
}
void RenderPyramid(benchmark::State& state) {
  TimeRender(state, Model(Engine::kPyramid, kSize, 8, kPaperTerms, kTolerance, false), Freckles(), 2);
}
void RenderLowRank(benchmark::State& state) {
  TimeRender(state, Model(Engine::kLowRank, kSize, 8, kAutomaticTerms, kTolerance, false), Freckles(), 2);
}
void RenderLowRankOneThread(benchmark::State& state) {
  TimeRender(state, Model(Engine::kLowRank, kSize, 8, kAutomaticTerms, kTolerance, false), Freckles(), 1);
}
void RenderTwoBands(benchmark::State& state) {
  TimeRender(state, Model(Engine::kLowRank, kSize, 2, kAutomaticTerms, kTolerance, false), Freckles(), 1);
}
void RenderTwoBands2048(benchmark::State& state) {
  static const ParameterMaps large = Resized(Freckles(), 2048);
  TimeRender(state, Model(Engine::kLowRank, 2048, 2, kAutomaticTerms, kTolerance, false), large, 1);
}
void Transpose(benchmark::State& state) {
  const ThreadLimit limit(2);
  const ForwardModel& model = Model(Engine::kLowRank, kSize, 8, kAutomaticTerms, kTolerance, false);
  const auto weigh = [](int, const PlaneF& reflectance) { return reflectance; };
  for (auto _ : state) benchmark::DoNotOptimize(model.Transpose(Freckles(), weigh));
}

// The blurs of one convolution by the cascade, and the same 18 by OpenCV, on the same domain: the same
// variances, radii where its Gaussian's tail is about as small.
Domain BlurDomain() {
  return MakeDomain(kSize, kSize, 1.9 / (kPatch_mm / kSize));
}

void EighteenBlurs(benchmark::State& state) {
  const Domain domain = BlurDomain();
  TablePositions positions;
  PlaneF mu_a(kSize, kSize);
  for (std::size_t i = 0; i < mu_a.size(); ++i)
    mu_a.data()[i] = 0.2f + 2.0f * Freckles()[Parameter::kC_m].data()[i];
  positions.Set(mu_a, domain);
  static const BandTables tables = BuildBandTables(Source(), 560.0, TissueConfig{});
  ResponseWeights weights;
  weights.Set(tables.r2_diffuse, positions, domain.Whole());
  PlaneF input, out;
  SurroundWithZeros(Freckles()[Parameter::kC_m], domain, input);
  const auto convolver = MakeConvolver(Engine::kCascade, domain, kPatch_mm / kSize, Border::kZero);
  const ConvolutionTarget target{&weights, &out};
  for (auto _ : state) convolver->Convolve(input, {&target, 1});
}

void EighteenOpenCvBlurs(benchmark::State& state) {
  cv::setNumThreads(1);
  PlaneF input;
  SurroundWithZeros(Freckles()[Parameter::kC_m], BlurDomain(), input);
  const cv::Mat image(input.height(), input.width(), CV_32F, input.data());
  cv::Mat blurred;
  for (auto _ : state) {
    double last_px2 = 0.0;
    image.copyTo(blurred);
    for (int i = 0; i < kGaussianCount; ++i) {
      const double variance_px2 = GaussianVariance_px2(i, kPatch_mm / kSize);
      const double sigma_px = std::sqrt(variance_px2 - last_px2);
      const int width = 2 * static_cast<int>(std::ceil(4.4 * sigma_px)) + 1;
      cv::GaussianBlur(blurred, blurred, {width, width}, sigma_px, sigma_px, cv::BORDER_CONSTANT);
      last_px2 = variance_px2;
    }
  }
}

// The roofline: multiply-adds that wait for nothing, and a copy of planes too large for any cache.
DERMAP_KERNEL
float MultiplyAdds(int rounds) noexcept {
  Lanes a{}, b{}, c{}, d{}, e{}, f{}, g{}, h{};
  const Lanes x = Lanes{} + 0.999f, y = Lanes{} + 0.001f;
  for (int i = 0; i < rounds; ++i) {
    a = a * x + y, b = b * x + y, c = c * x + y, d = d * x + y;
    e = e * x + y, f = f * x + y, g = g * x + y, h = h * x + y;
  }
  a += b + c + d + e + f + g + h;
  return a[0] + a[7];
}
constexpr int kRounds = 100000;
constexpr double kProbeFlops = 2.0 * 8 * kLanes * kRounds;

void PeakFlops(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(MultiplyAdds(kRounds));
}

constexpr std::size_t kStreamFloats = 16u << 20;
void PeakBandwidth(benchmark::State& state) {
  std::vector<float> from(kStreamFloats, 1.0f), to(kStreamFloats);
  for (auto _ : state) {
    std::memcpy(to.data(), from.data(), kStreamFloats * sizeof(float));
    benchmark::ClobberMemory();
  }
}

// The hot kernels: the stencil by arithmetic, the product of planes by bandwidth.
constexpr int kStencilRadius = 9;
Stencil HotStencil() {
  return {[](double kx, double ky) { return 1.0 - std::exp(-2.0 * (kx * kx + ky * ky)); }, kStencilRadius};
}
void HotStencilTime(benchmark::State& state) {
  const Stencil stencil = HotStencil();
  StencilRunner runner(Border::kZero);
  PlaneF sum(kSize, kSize);
  for (auto _ : state) runner.AddTo(Freckles()[Parameter::kC_m], stencil, nullptr, sum);
}
// What the stencil must do: a multiply-add a tap, once rows above and below have been added up.
double StencilFlops() {
  const Stencil stencil = HotStencil();
  double taps = 0.0;
  for (const auto& row : stencil.rows()) taps += 2.0 * static_cast<double>(row.size()) - 1.0;
  return (2.0 * taps + kStencilRadius) * kSize * kSize;
}
void HotProductTime(benchmark::State& state) {
  const PlaneF a(4096, 4096, 1.0f), b(4096, 4096, 2.0f);
  PlaneF out(4096, 4096);
  for (auto _ : state) {
    Product(a, b, out);
    benchmark::ClobberMemory();
  }
}

double RelativeRms(const std::vector<PlaneF>& found, const std::vector<PlaneF>& truth) {
  double square = 0.0, count = 0.0;
  for (std::size_t b = 0; b < found.size(); ++b) {
    for (std::size_t i = 0; i < found[b].size(); ++i) {
      square += std::pow(found[b].data()[i] / truth[b].data()[i] - 1.0, 2);
      count += 1.0;
    }
  }
  return std::sqrt(square / count);
}

// The largest error of the default render over the recorded scenes, against one a hundred times finer.
double RenderError(bool one_response) {
  double worst = 0.0;
  for (const char* scene : {"light_freckles", "medium_vein"}) {
    const auto truth = Model(Engine::kLowRank, kSize, 8, 20, kFine, one_response).Render(Scene(scene));
    const auto found =
        Model(Engine::kLowRank, kSize, 8, kAutomaticTerms, kTolerance, one_response).Render(Scene(scene));
    worst = std::max(worst, RelativeRms(found, truth));
  }
  return worst;
}

// |<J v, w> - <v, J' w>| over the product of the norms.
double TransposeError() {
  const ForwardModel& model = Model(Engine::kLowRank, kSize, 8, kAutomaticTerms, kTolerance, false);
  ParameterMaps change(kSize, kSize, ParameterVector{});
  for (int k = 0; k < kParameterCount; ++k) change.planes[k] = Freckles().planes[k];
  const std::vector<PlaneF> product = model.Tangent(Freckles(), change);
  const ParameterMaps back =
      model.Transpose(Freckles(), [](int, const PlaneF& reflectance) { return reflectance; });
  const std::vector<PlaneF> weights = model.Render(Freckles());
  double left = 0.0, right = 0.0, a = 0.0, b = 0.0;
  for (std::size_t band = 0; band < product.size(); ++band) {
    for (std::size_t i = 0; i < product[band].size(); ++i) {
      const double x = product[band].data()[i], y = weights[band].data()[i];
      left += x * y, a += x * x, b += y * y;
    }
  }
  for (int k = 0; k < kParameterCount; ++k)
    for (std::size_t i = 0; i < back.planes[k].size(); ++i)
      right += double(back.planes[k].data()[i]) * change.planes[k].data()[i];
  return std::abs(left - right) / std::sqrt(a * b);
}

// Bytes that renders of eight bands by two threads take and keep beyond maps, tables and result, a pixel and
// band.
double BytesPerPixelBand() {
  const ThreadLimit limit(2);
  ImagingConditions conditions;
  conditions.pixel_size_mm = kPatch_mm / kSize;
  const ForwardModel model(AllChromophores(), Source(), TissueConfig{}, Bands(8), conditions, {});
  const auto before = mallinfo2();
  const auto result = model.Render(Freckles());
  const auto after = mallinfo2();
  const double taken = double(after.uordblks + after.hblkhd) - double(before.uordblks + before.hblkhd);
  return taken / (8.0 * kSize * kSize) - sizeof(float);
}

// Medians of real times, by name.
class Times : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Aggregate) continue;
      auto& time = times_[run.run_name.function_name];
      const double seconds = run.GetAdjustedRealTime() / benchmark::GetTimeUnitMultiplier(run.time_unit);
      if (run.aggregate_name == "median") time.first = seconds;
      if (run.aggregate_name == "stddev") time.second = seconds;
    }
    ConsoleReporter::ReportRuns(runs);
  }
  double Median(const std::string& name) const { return times_.at(name).first; }
  double Spread(const std::string& name) const { return times_.at(name).second / times_.at(name).first; }
  bool Has(const std::string& name) const { return times_.count(name) > 0; }

 private:
  std::map<std::string, std::pair<double, double>> times_;
};

void WriteSummary(const Times& times, const std::string& path) {
  nlohmann::json json;
  // `error` is the accuracy of what was timed, where it has one, otherwise the spread of the value.
  const auto ratio = [&](const char* key, const char* above, const char* below, double factor, double error) {
    const double spread = std::hypot(times.Spread(above), times.Spread(below));
    json[key] = {{"value", factor * times.Median(above) / times.Median(below)},
                 {"error", error >= 0.0 ? error : spread},
                 {"spread", spread}};
  };
  ratio("convolution_speedup", "ConvolutionCascade", "ConvolutionLowRank", 1.0, RenderError(true));
  ratio("render_speedup", "RenderCascade", "RenderLowRank", 1.0, RenderError(false));
  ratio("transpose_over_render", "Transpose", "RenderLowRank", 1.0, TransposeError());
  ratio("time_per_pixel_2048_over_256", "RenderTwoBands2048", "RenderTwoBands", 1.0 / 64.0, -1.0);
  ratio("thread_speedup", "RenderLowRankOneThread", "RenderLowRank", 1.0, -1.0);
  ratio("cascade_over_opencv", "EighteenBlurs", "EighteenOpenCvBlurs", 1.0, -1.0);
  ratio("peak_flops_share", "PeakFlops", "HotStencilTime", StencilFlops() / kProbeFlops, -1.0);
  // Three planes of 64 MiB for a product, two for a copy.
  ratio("peak_bandwidth_share", "PeakBandwidth", "HotProductTime", 1.5, -1.0);
  json["bytes_per_pixel_band"] = {{"value", BytesPerPixelBand()}, {"error", 0.0}};
  json["seconds"] = nlohmann::json::object();
  for (const char* name :
       {"ConvolutionCascade", "ConvolutionLowRank", "RenderCascade", "RenderPyramid", "RenderLowRank",
        "RenderLowRankOneThread", "Transpose", "EighteenBlurs", "EighteenOpenCvBlurs"})
    json["seconds"][name] = times.Median(name);
  json["gflops_per_s"] = {{"peak", kProbeFlops / times.Median("PeakFlops") * 1e-9},
                          {"stencil", StencilFlops() / times.Median("HotStencilTime") * 1e-9}};
  json["gbytes_per_s"] = {{"copy", 8.0 * kStreamFloats / times.Median("PeakBandwidth") * 1e-9},
                          {"product", 12.0 * kStreamFloats / times.Median("HotProductTime") * 1e-9}};
  std::ofstream(path) << json.dump(2) << "\n";
  std::printf("%s\n", json.dump(2).c_str());
}

}  // namespace
}  // namespace dermap

int main(int argc, char** argv) {
  using namespace dermap;
  std::string summary;
  std::vector<char*> rest;
  for (int i = 0; i < argc; ++i) {
    if (std::strncmp(argv[i], "--summary=", 10) == 0) {
      summary = argv[i] + 10;
    } else {
      rest.push_back(argv[i]);
    }
  }
  int count = static_cast<int>(rest.size());
  benchmark::Initialize(&count, rest.data());
  if (benchmark::ReportUnrecognizedArguments(count, rest.data())) return 2;
  const auto add = [](const char* name, void (*function)(benchmark::State&)) {
    benchmark::RegisterBenchmark(name, function)->Unit(benchmark::kMillisecond)->UseRealTime();
  };
  add("ConvolutionCascade", ConvolutionCascade);
  add("ConvolutionLowRank", ConvolutionLowRank);
  add("RenderCascade", RenderCascade);
  add("RenderPyramid", RenderPyramid);
  add("RenderLowRank", RenderLowRank);
  add("RenderLowRankOneThread", RenderLowRankOneThread);
  add("RenderTwoBands", RenderTwoBands);
  add("RenderTwoBands2048", RenderTwoBands2048);
  add("Transpose", Transpose);
  add("EighteenBlurs", EighteenBlurs);
  add("EighteenOpenCvBlurs", EighteenOpenCvBlurs);
  add("PeakFlops", PeakFlops);
  add("PeakBandwidth", PeakBandwidth);
  add("HotStencilTime", HotStencilTime);
  add("HotProductTime", HotProductTime);
  Times times;
  benchmark::RunSpecifiedBenchmarks(&times);
  if (!summary.empty()) WriteSummary(times, summary);
  return 0;
}
