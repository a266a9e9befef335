// SPDX-License-Identifier: Apache-2.0
// Times of the forward model's parts on a 256 x 256 patch of 7.5 mm, one thread. For honesty, 18 of OpenCV's
// Gaussian blurs stand beside the cascade: the same variances, on the same domain.
#include <benchmark/benchmark.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "common/core/parallel.h"
#include "common/transport/convolver.h"
#include "common/transport/forward_model.h"

namespace dermap {
namespace {

constexpr int kSize = 256;
constexpr double kPixel_mm = 7.5 / kSize;
constexpr double kMargin_mm = 1.9;

const Chromophores& AllChromophores() {
  static const Chromophores chromophores(ConfigDirectory() / "spectra");
  return chromophores;
}

const ProfileSource& Source() {
  static const std::unique_ptr<ProfileSource> source = MakeProfileSource("exact");
  return *source;
}

const BandTables& Tables() {
  static const BandTables tables = BuildBandTables(Source(), 560.0, TissueConfig{});
  return tables;
}

// Values that change from pixel to pixel; a fixed seed.
PlaneF Noise(int size, float low, float high) {
  PlaneF plane(size, size);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> value(low, high);
  for (float& v : plane.values()) v = value(random);
  return plane;
}

// One heterogeneous convolution, weights looked up before.
void BM_Convolution(benchmark::State& state, Engine engine) {
  const ThreadLimit one(1);
  const Domain domain = MakeDomain(kSize, kSize, kMargin_mm / kPixel_mm);
  TablePositions positions;
  positions.Set(Noise(kSize, 0.2f, 3.0f), domain);
  ResponseWeights weights;
  weights.Set(Tables().r2_diffuse, positions, domain.Whole());
  PlaneF input, out;
  SurroundWithZeros(Noise(kSize, 0.5f, 1.5f), domain, input);
  const auto convolver = MakeConvolver(engine, domain, kPixel_mm, Border::kZero);
  const ConvolutionTarget target{&weights, &out};
  for (auto _ : state) convolver->Convolve(input, {&target, 1});
  state.counters["domain"] = domain.width;
}
BENCHMARK_CAPTURE(BM_Convolution, cascade, Engine::kCascade)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Convolution, pyramid, Engine::kPyramid)->Unit(benchmark::kMillisecond);

void BM_WeightsOfOneResponse(benchmark::State& state) {
  const Domain domain = MakeDomain(kSize, kSize, kMargin_mm / kPixel_mm);
  TablePositions positions;
  positions.Set(Noise(kSize, 0.2f, 3.0f), domain);
  ResponseWeights weights;
  for (auto _ : state) weights.Set(Tables().r2_diffuse, positions, domain.Whole());
}
BENCHMARK(BM_WeightsOfOneResponse)->Unit(benchmark::kMillisecond);

// 18 separable blurs, each made from the last, by OpenCV; radii where its Gaussian's tail is about as small
// as ours.
void BM_EighteenOpenCvBlurs(benchmark::State& state) {
  cv::setNumThreads(1);
  const Domain domain = MakeDomain(kSize, kSize, kMargin_mm / kPixel_mm);
  PlaneF input;
  SurroundWithZeros(Noise(kSize, 0.5f, 1.5f), domain, input);
  const cv::Mat image(domain.height, domain.width, CV_32F, input.data());
  cv::Mat blurred;
  for (auto _ : state) {
    double last_px2 = 0.0;
    image.copyTo(blurred);
    for (int i = 0; i < kGaussianCount; ++i) {
      const double variance_px2 = GaussianVariance_px2(i, kPixel_mm),
                   sigma_px = std::sqrt(variance_px2 - last_px2);
      const int radius = static_cast<int>(std::ceil(4.4 * sigma_px));
      cv::GaussianBlur(blurred, blurred, {2 * radius + 1, 2 * radius + 1}, sigma_px, sigma_px,
                       cv::BORDER_CONSTANT);
      last_px2 = variance_px2;
    }
  }
}
BENCHMARK(BM_EighteenOpenCvBlurs)->Unit(benchmark::kMillisecond);

// A whole render of eight bands of 10 nm, one thread and all.
void BM_Render(benchmark::State& state, Engine engine, int threads) {
  const ThreadLimit limit(threads);
  std::vector<Band> bands;
  for (const double wavelength_nm : {450, 480, 510, 540, 560, 580, 610, 650})
    bands.push_back({wavelength_nm, 10.0});
  ImagingConditions conditions;
  conditions.pixel_size_mm = 7.5 / static_cast<double>(state.range(0));
  ForwardOptions options;
  options.engine = engine;
  options.margin_mm = kMargin_mm;
  const ForwardModel model(AllChromophores(), Source(), TissueConfig{}, bands, conditions, options);
  const int size = static_cast<int>(state.range(0));
  ParameterMaps maps(size, size, AverageSkin());
  maps[Parameter::kC_m] = Noise(size, 0.02f, 0.1f);
  for (auto _ : state) benchmark::DoNotOptimize(model.Render(maps));
}
BENCHMARK_CAPTURE(BM_Render, lowrank_one_thread, Engine::kLowRank, 1)
    ->Arg(256)
    ->Arg(64)
    ->Arg(32)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Render, lowrank, Engine::kLowRank, 0)
    ->Arg(256)
    ->UseRealTime()
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Render, pyramid_one_thread, Engine::kPyramid, 1)
    ->Arg(256)
    ->Arg(64)
    ->Arg(32)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Render, pyramid, Engine::kPyramid, 0)
    ->Arg(256)
    ->UseRealTime()
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Render, cascade_one_thread, Engine::kCascade, 1)
    ->Arg(256)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dermap

BENCHMARK_MAIN();
