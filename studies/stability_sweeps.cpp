// SPDX-License-Identifier: Apache-2.0
// The sweeps: of the skin, of the data, of what the fit is told.
#include "studies/stability_sweeps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "studies/study_scenes.h"

namespace dermap {
namespace {

constexpr double kNoise = 0.005;      // of the reflectance, where noise is not what is swept
constexpr double kJudgeNoise = 0.01;  // beside a Monte Carlo
constexpr const char* kSkinsJudge = "adding-doubling";
constexpr int kLoneBand = 3;           // 540 nm: the band that a single fault befalls
constexpr double kSpoiltPixel = 0.25;  // share of the window's pixels beside which a ring is judged

const std::vector<FitMethod> kAllMethods{FitMethod::kFast, FitMethod::kCeres, FitMethod::kDescent};

int At(Parameter p) {
  return static_cast<int>(p);
}

StabilityCase CaseOf(KnownStack known, double noise, std::uint64_t seed) {
  AddNoise(known.stack, noise, seed);
  return {std::move(known.stack), std::move(known.truth), {}, {}, {}};
}

using Make = std::function<StabilityCase(double, std::uint64_t)>;

// Skins one by one, average but for one content, which varies by a fifth: the values below are such that all
// of a point's skins lie within table 1 or all beyond it.
Make OfContent(StabilityBench& bench, Parameter content) {
  return [&bench, content](double value, std::uint64_t seed) {
    ParameterVector middle = AverageSkin();
    middle[At(content)] = value;
    return CaseOf(bench.Skins(middle, {}, seed), kNoise, seed);
  };
}

Make OfThickness(StabilityBench& bench) {
  return [&bench](double mean_free_paths, std::uint64_t seed) {
    TissueConfig tissue;
    tissue.epidermis_thickness_mm = mean_free_paths / ReducedScatteringEpidermis(550.0, tissue);
    StabilityCase made = CaseOf(bench.Skins(AverageSkin(), tissue, seed), kNoise, seed);
    made.tissue = made.options.tissue = tissue;
    return made;
  };
}

// Freckled skin in eight bands, disturbed by a function of the stack before its noise is added.
using Disturb = std::function<void(double value, std::uint64_t seed, StabilityCase&)>;
Make OfFreckles(StabilityBench& bench, Disturb disturb) {
  return [&bench, disturb = std::move(disturb)](double value, std::uint64_t seed) {
    KnownStack known = bench.Freckled(StudyBands());
    StabilityCase made{std::move(known.stack), std::move(known.truth), {}, {}, {}};
    AddNoise(made.stack, kNoise, seed);
    disturb(value, seed, made);
    return made;
  };
}

// `plane` moved by a part of a pixel, repeated at its border.
PlaneF Moved(const PlaneF& plane, double dx, double dy) {
  PlaneF moved(plane.width(), plane.height());
  const auto at = [&](int x, int y) {
    return double(plane(std::clamp(x, 0, plane.width() - 1), std::clamp(y, 0, plane.height() - 1)));
  };
  for (int y = 0; y < plane.height(); ++y)
    for (int x = 0; x < plane.width(); ++x) {
      const double u = x - dx, v = y - dy;
      const int x0 = static_cast<int>(std::floor(u)), y0 = static_cast<int>(std::floor(v));
      const double fx = u - x0, fy = v - y0;
      moved(x, y) = static_cast<float>((1.0 - fy) * ((1.0 - fx) * at(x0, y0) + fx * at(x0 + 1, y0)) +
                                       fy * ((1.0 - fx) * at(x0, y0 + 1) + fx * at(x0 + 1, y0 + 1)));
    }
  return moved;
}

// Every band moved by `pixels` in a direction of its own; the noise, which a sensor adds, is not smoothed.
Make OfMisregistration(StabilityBench& bench) {
  return [&bench](double pixels, std::uint64_t seed) {
    KnownStack known = bench.Freckled(StudyBands());
    std::mt19937_64 generator(seed);
    std::uniform_real_distribution<double> angle(0.0, 6.283185307179586);
    for (PlaneF& plane : known.stack.reflectance) {
      const double direction = angle(generator);
      if (pixels > 0.0) plane = Moved(plane, pixels * std::cos(direction), pixels * std::sin(direction));
    }
    return CaseOf(std::move(known), kNoise, seed);
  };
}

void Scale(ReflectanceStack& stack, int band, double gain) {
  for (float& value : stack.reflectance[band].values()) value = static_cast<float>(value * gain);
  for (float& value : stack.sigma[band].values()) value = static_cast<float>(value * gain);
}

// The brightest `percent` of the last band's pixels at the value of the darkest of them: a sensor that was
// full there. Masked as calibration does it, or left in.
Make OfSaturation(StabilityBench& bench, bool masked) {
  return OfFreckles(bench, [masked](double percent, std::uint64_t, StabilityCase& made) {
    PlaneF& plane = made.stack.reflectance.back();
    std::vector<float> sorted(plane.values().begin(), plane.values().end());
    std::sort(sorted.begin(), sorted.end());
    const auto full = static_cast<std::size_t>(percent / 100.0 * static_cast<double>(sorted.size()));
    if (full == 0) return;
    const float level = sorted[sorted.size() - full];
    for (float& value : plane.values())
      if (value >= level) value = masked ? std::numeric_limits<float>::quiet_NaN() : level;
  });
}

// Rings of a window under tape, by their distance from the tape.
Make OfWindow(StabilityBench& bench) {
  return [&bench](double mm, std::uint64_t seed) {
    StabilityCase made = CaseOf(bench.Window(), kJudgeNoise, seed);
    const int side = made.stack.width();
    const double pixel_mm = *made.stack.pixel_size_mm;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const int inside = std::min({x, y, side - 1 - x, side - 1 - y});
        made.judged.push_back(std::abs((inside + 0.5) * pixel_mm - mm) < kSpoiltPixel * pixel_mm);
      }
    return made;
  };
}

// Values with fewer bits after the leading one than a float's 23.
Make OfPrecision(StabilityBench& bench) {
  return OfFreckles(bench, [](double bits, std::uint64_t, StabilityCase& made) {
    for (PlaneF& plane : made.stack.reflectance)
      for (float& value : plane.values()) {
        int exponent = 0;
        const double fraction = std::frexp(value, &exponent);
        value = static_cast<float>(std::ldexp(std::round(std::ldexp(fraction, static_cast<int>(bits) + 1)),
                                              exponent - static_cast<int>(bits) - 1));
      }
  });
}

std::vector<Sweep> SkinSweeps(StabilityBench& bench) {
  const std::string judge = kSkinsJudge;
  return {{"melanin",
           "C_m, volume fraction (table 1 ends at 0.5)",
           judge,
           {0.005, 0.02, 0.06, 0.12, 0.2, 0.3, 0.4, 0.65, 1.0},
           0.06,
           true,
           kAllMethods,
           OfContent(bench, Parameter::kC_m)},
          {"blood_dermis",
           "C_hd, volume fraction (table 1 ends at 0.1)",
           judge,
           {0.003, 0.01, 0.03, 0.06, 0.08, 0.13, 0.2},
           0.03,
           true,
           kAllMethods,
           OfContent(bench, Parameter::kC_hd)},
          {"blood_epidermis",
           "C_he, volume fraction (table 1 ends at 0.05)",
           judge,
           {0.002, 0.005, 0.01, 0.02, 0.04, 0.065, 0.1},
           0.005,
           true,
           kAllMethods,
           OfContent(bench, Parameter::kC_he)},
          {"thickness",
           "epidermis over the mean free path at 550 nm",
           judge,
           {0.1, 0.2, 0.4, 0.8, 1.2, 2.0, 4.0, 8.0},
           1.2,
           true,
           kAllMethods,
           OfThickness(bench)},
          {"sharpness",
           "width of an edge of melanin over the mean free path",
           "Monte Carlo",
           {0.1, 0.5, 1.0, 2.0, 4.0, 8.0},
           8.0,
           true,
           kAllMethods,
           [&bench](double widths, std::uint64_t seed) {
             const double mm = widths <= 0.1 ? 0.0 : widths / ReducedScatteringEpidermis(550.0, {});
             return CaseOf(bench.Edge(mm), 0.002, seed);
           }},
          {"window",
           "distance from the tape, mm",
           "Monte Carlo",
           {0.075, 0.225, 0.375, 0.675, 1.125, 1.725},
           1.725,
           true,
           kAllMethods,
           OfWindow(bench)}};
}

std::vector<Sweep> DataSweeps(StabilityBench& bench) {
  const std::string judge = "forward model at tolerance 1e-5";
  return {
      {"noise",
       "noise, % of the reflectance",
       judge,
       {0.01, 0.03, 0.1, 0.3, 0.5, 1.0, 3.0, 10.0},
       0.5,
       true,
       kAllMethods,
       [&bench](double percent, std::uint64_t seed) {
         return CaseOf(bench.Freckled(StudyBands()), percent / 100.0, seed);
       }},
      {"bands",
       "number of bands, 450 to 650 nm",
       judge,
       {12, 10, 8, 7, 6, 5, 4, 3, 2},
       8,
       false,
       kAllMethods,
       [&bench](double count, std::uint64_t seed) {
         return CaseOf(bench.Freckled(SpreadBands(static_cast<int>(count))), kNoise, seed);
       }},
      {"misregistration",
       "bands displaced by, pixels",
       judge,
       {0, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0},
       0,
       false,
       kAllMethods,
       OfMisregistration(bench)},
      {"gain",
       "540 nm too bright by, %",
       judge,
       {0, 0.2, 0.5, 1, 2, 5, 10, 30},
       0,
       false,
       kAllMethods,
       OfFreckles(bench, [](double percent, std::uint64_t,
                            StabilityCase& made) { Scale(made.stack, kLoneBand, 1.0 + percent / 100.0); })},
      {"drift",
       "flash drift between bands, % rms",
       judge,
       {0, 0.05, 0.1, 0.2, 0.5, 1, 2, 5},
       0,
       false,
       kAllMethods,
       OfFreckles(bench,
                  [](double percent, std::uint64_t seed, StabilityCase& made) {
                    std::mt19937_64 generator(seed + 1000);
                    std::normal_distribution<double> normal;
                    for (int b = 0; b < static_cast<int>(made.stack.bands.size()); ++b)
                      Scale(made.stack, b, 1.0 + percent / 100.0 * normal(generator));
                  })},
      {"saturation_masked",
       "650 nm saturated and masked, % of the pixels",
       judge,
       {0, 1, 5, 20, 50, 100},
       0,
       false,
       kAllMethods,
       OfSaturation(bench, true)},
      {"saturation",
       "650 nm saturated unnoticed, % of the pixels",
       judge,
       {0, 1, 5, 20, 50, 100},
       0,
       false,
       kAllMethods,
       OfSaturation(bench, false)},
      {"precision",
       "bits of the stack's values (half: 10)",
       judge,
       {23, 14, 12, 10, 8, 7, 6, 5},
       23,
       false,
       kAllMethods,
       OfPrecision(bench)}};
}

std::vector<Sweep> ModelSweeps(StabilityBench& bench) {
  const std::string judge = "forward model at tolerance 1e-5";
  return {
      {"pixel_size",
       "pixel size told over the true one",
       judge,
       {0.25, 0.5, 0.8, 0.9, 1.0, 1.1, 1.25, 2.0, 4.0},
       1.0,
       true,
       kAllMethods,
       OfFreckles(bench,
                  [](double factor, std::uint64_t, StabilityCase& made) {
                    made.options.pixel_size_mm = factor * *made.stack.pixel_size_mm;
                  })},
      {"wrong_thickness",
       "thickness told over the true one",
       judge,
       {0.4, 0.6, 0.8, 0.9, 1.0, 1.1, 1.25, 1.6, 2.5},
       1.0,
       true,
       kAllMethods,
       OfFreckles(bench, [](double factor, std::uint64_t,
                            StabilityCase& made) { made.options.tissue.epidermis_thickness_mm *= factor; })},
      {"start",
       "start, from average skin (0) to the darkest of table 1 (1)",
       judge,
       {0, 0.25, 0.5, 0.75, 1.0},
       0,
       false,
       {FitMethod::kDescent},
       OfFreckles(bench, [](double share, std::uint64_t, StabilityCase& made) {
         for (int k = 0; k < kParameterCount; ++k)
           made.options.fixed_values[k] += share * (kParameters[k].upper - made.options.fixed_values[k]);
       })}};
}

// The harmless value, the worst, and one between.
void KeepThree(Sweep& sweep) {
  const auto worst = sweep.harmless == sweep.values.back() ? sweep.values.front() : sweep.values.back();
  const double middle = sweep.values[sweep.values.size() / 2];
  std::vector<double> kept;
  for (const double value : sweep.values)
    if (value == sweep.harmless || value == middle || value == worst) kept.push_back(value);
  sweep.values = kept;
}

}  // namespace

std::vector<Sweep> StabilitySweeps(StabilityBench& bench, bool quick) {
  std::vector<Sweep> sweeps;
  for (auto part : {SkinSweeps(bench), DataSweeps(bench), ModelSweeps(bench)})
    for (Sweep& sweep : part) sweeps.push_back(std::move(sweep));
  for (Sweep& sweep : sweeps) sweep.small = sweep.judge == kSkinsJudge;
  if (quick)
    for (Sweep& sweep : sweeps) KeepThree(sweep);
  return sweeps;
}

}  // namespace dermap
