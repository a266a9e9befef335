// SPDX-License-Identifier: Apache-2.0
// Truths from judges.
#include "studies/stability_bench.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <thread>

#include "common/core/parallel.h"
#include "studies/judged_strip.h"
#include "studies/study_scenes.h"
#include "tests/reference/adding_doubling.h"
#include "tests/reference/monte_carlo.h"

namespace dermap {
namespace {

constexpr double kExactTolerance = 1e-5;
constexpr int kJudgeNodes = 12;
constexpr int kSkinsSide = 8;
constexpr double kApart_mm = 2000.0;  // at 50 mm a hundredth of the red light still comes from the neighbours
constexpr double kVaried = 0.2;
constexpr double kEdgePixel_mm = 0.06, kBesideEdge_mm = 1.2;
constexpr int kWindowSide = 24;
constexpr double kWindowPixel_mm = 0.15;
constexpr int kWindowPhotons = 8;  // times those of an edge, whose strip is summed along its length

ReflectanceStack EmptyStack(const std::vector<Band>& bands, int width, int height, double pixel_mm,
                            Illumination illumination) {
  ReflectanceStack stack;
  stack.bands = bands;
  stack.reflectance.assign(bands.size(), PlaneF(width, height));
  stack.sigma = stack.reflectance;
  stack.pixel_size_mm = pixel_mm;
  stack.illumination = illumination;
  return stack;
}

reference::LayerStack LayersOf(const ParameterVector& p, const Absorbers& absorbers,
                               const TissueConfig& tissue) {
  return {tissue.n_outside,
          {{.thickness_mm = tissue.epidermis_thickness_mm,
            .mu_a = absorbers.MuAEpidermis(p),
            .mu_s = ReducedScatteringEpidermis(absorbers.wavelength_nm, tissue),
            .n = tissue.n_epidermis,
            .absorber_below = tissue.junction_absorbance},
           {.mu_a = absorbers.MuADermis(p),
            .mu_s = ReducedScatteringDermis(absorbers.wavelength_nm, tissue),
            .n = tissue.n_dermis}},
          tissue.n_dermis};
}

PlaneF Single(const Plane<double>& plane) {
  PlaneF single(plane.width(), plane.height());
  for (std::size_t i = 0; i < plane.size(); ++i) single.data()[i] = static_cast<float>(plane.data()[i]);
  return single;
}

int Threads() {
  return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

}  // namespace

std::vector<Band> SpreadBands(int count) {
  std::vector<Band> bands;
  for (int b = 0; b < count; ++b)
    bands.push_back({count > 1 ? std::round(450.0 + 200.0 * b / (count - 1)) : 560.0, 0.0});
  return bands;
}

StabilityBench::StabilityBench(int size, std::uint64_t photons)
    : size_(size), photons_(photons), chromophores_(ConfigDirectory() / "spectra") {}

ForwardModel StabilityBench::ModelFor(const ReflectanceStack& stack, const TissueConfig& tissue) {
  return {chromophores_,
          *MakeProfileSource("exact"),
          tissue,
          stack.bands,
          {*stack.pixel_size_mm, stack.illumination, stack.tape, stack.geometry},
          {}};
}

const KnownStack& StabilityBench::Freckled(const std::vector<Band>& bands) {
  std::vector<double> wavelengths_nm;
  for (const Band& band : bands) wavelengths_nm.push_back(band.wavelength_nm);
  KnownStack& known = freckled_[wavelengths_nm];
  if (!known.stack.bands.empty()) return known;
  known.truth = StudySkin("medium", size_);
  known.stack = EmptyStack(bands, size_, size_, kStudyPatch_mm / size_, Illumination::kWindow);
  ForwardOptions exact;
  exact.tolerance = kExactTolerance;
  known.stack.reflectance = ModelFor(known.stack, {}).With(exact).Render(known.truth);
  return known;
}

KnownStack StabilityBench::Skins(const ParameterVector& middle, const TissueConfig& tissue,
                                 std::uint64_t seed) const {
  KnownStack known;
  known.truth = ParameterMaps(kSkinsSide, kSkinsSide, middle);
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> phase(0.0, 6.283185307179586), waves(0.5, 1.5);
  for (PlaneF& plane : known.truth.planes) {
    const double at_x = phase(generator), at_y = phase(generator);
    const double of_x = waves(generator) * 6.283185307179586 / kSkinsSide;
    const double of_y = waves(generator) * 6.283185307179586 / kSkinsSide;
    for (int y = 0; y < kSkinsSide; ++y)
      for (int x = 0; x < kSkinsSide; ++x)
        plane(x, y) *=
            static_cast<float>(1.0 + kVaried * std::sin(of_x * x + at_x) * std::cos(of_y * y + at_y));
  }
  for (float& value : known.truth[Parameter::kBeta_m].values()) value = std::min(value, 1.0f);
  known.stack = EmptyStack(StudyBands(), kSkinsSide, kSkinsSide, kApart_mm, Illumination::kUniform);
  for (std::size_t b = 0; b < known.stack.bands.size(); ++b) {
    const Absorbers absorbers = chromophores_.At(known.stack.bands[b].wavelength_nm, tissue);
    PlaneF& plane = known.stack.reflectance[b];
    ParallelFor(static_cast<int>(plane.size()), [&](int i) {
      ParameterVector p;
      for (int k = 0; k < kParameterCount; ++k) p[k] = known.truth.planes[k].data()[i];
      plane.data()[i] = static_cast<float>(
          reference::NormalIncidenceTotals(LayersOf(p, absorbers, tissue), kJudgeNodes).reflectance);
    });
  }
  return known;
}

const KnownStack& StabilityBench::Edge(double width_mm) {
  KnownStack& known = edges_[width_mm];
  if (!known.stack.bands.empty()) return known;
  const std::vector<ParameterVector> skin = MelaninEdge(width_mm, kEdgePixel_mm, kBesideEdge_mm);
  const int width = static_cast<int>(skin.size());
  known.truth = ParameterMaps(width, 1, AverageSkin());
  for (int x = 0; x < width; ++x)
    for (int k = 0; k < kParameterCount; ++k) known.truth.planes[k](x, 0) = static_cast<float>(skin[x][k]);
  known.stack = EmptyStack(StudyBands(), width, 1, kEdgePixel_mm, Illumination::kUniform);
  for (std::size_t b = 0; b < known.stack.bands.size(); ++b) {
    const JudgedStrip judged = JudgeStrip({known.stack.bands[b].wavelength_nm, kEdgePixel_mm, skin},
                                          chromophores_, photons_, 100 + b, Threads());
    for (int x = 0; x < width; ++x) {
      known.stack.reflectance[b](x, 0) = static_cast<float>(judged.reflectance[x]);
      known.stack.sigma[b](x, 0) = static_cast<float>(judged.standard_error[x]);
    }
  }
  return known;
}

const KnownStack& StabilityBench::Window() {
  if (window_) return *window_;
  KnownStack known;
  known.truth = ParameterMaps(kWindowSide, kWindowSide, AverageSkin());
  known.stack = EmptyStack(StudyBands(), kWindowSide, kWindowSide, kWindowPixel_mm, Illumination::kWindow);
  known.stack.tape = Tape::kBlack;
  for (std::size_t b = 0; b < known.stack.bands.size(); ++b) {
    reference::MonteCarloScene scene;
    scene.stack = LayersOf(AverageSkin(), chromophores_.At(known.stack.bands[b].wavelength_nm, {}), {});
    scene.beam = reference::Beam::kWindow;
    scene.width = scene.height = kWindowSide;
    scene.pixel_size_mm = kWindowPixel_mm;
    scene.black_tape = true;
    const auto judged = reference::RunMonteCarlo(
        scene, {.photons = kWindowPhotons * photons_, .seed = 200 + b, .threads = Threads()});
    known.stack.reflectance[b] = Single(judged.reflectance_image);
    known.stack.sigma[b] = Single(judged.reflectance_image_error);
  }
  window_ = std::make_unique<KnownStack>(std::move(known));
  return *window_;
}

void AddNoise(ReflectanceStack& stack, double relative, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  for (std::size_t b = 0; b < stack.bands.size(); ++b)
    for (std::size_t i = 0; i < stack.reflectance[b].size(); ++i) {
      float& value = stack.reflectance[b].data()[i];
      float& sigma = stack.sigma[b].data()[i];
      const double noise = relative * std::abs(value);
      sigma = static_cast<float>(std::hypot(sigma, noise));
      value = static_cast<float>(value + noise * normal(generator));
    }
}

}  // namespace dermap
