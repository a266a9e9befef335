// SPDX-License-Identifier: Apache-2.0
// Blur shares from products with the Jacobian.
#include "fit/blur_share.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "fit/octaves.h"

namespace dermap {
namespace {

constexpr int kFieldSize = 32;       // pixels along a side of the test field
constexpr double kTolerance = 1e-3;  // of the renders
constexpr float kRoughness = 0.2f;  // of the field's skin: where nothing varies the engine takes closed forms
constexpr float kCoarsestPixel_mm = 1.5f;  // detail this coarse is seen as in uniform skin

PlaneF RandomDetail(std::uint64_t seed) {
  PlaneF field(kFieldSize, kFieldSize);
  std::mt19937_64 random(seed);
  for (float& value : field.values()) value = random() >> 63 ? 1.0f : -1.0f;
  return DetailOf(field);
}

// <detail, response> / (<detail, detail> * gain) .
float Regress(const PlaneF& detail, const PlaneF& response, double gain) {
  double product = 0.0, square = 0.0;
  for (std::size_t i = 0; i < detail.size(); ++i) {
    product += static_cast<double>(detail.data()[i]) * response.data()[i];
    square += static_cast<double>(detail.data()[i]) * detail.data()[i];
  }
  return static_cast<float>(std::clamp(product / (square * gain), 0.02, 1.0));
}

struct Change {
  ParameterMaps maps;
  float BlurShare::*share;
};

// Small changes of the dermis's, the epidermis's and the junction's absorption by the field.
std::vector<Change> Changes(const PlaneF& detail) {
  std::vector<Change> changes(3);
  changes[0].share = &BlurShare::epidermis;
  changes[0].maps[Parameter::kC_he] = detail;
  changes[1].share = &BlurShare::dermis;
  changes[1].maps[Parameter::kC_hd] = detail;
  changes[2].share = &BlurShare::junction;
  changes[2].maps.junction_absorbance = {detail};
  return changes;
}

// A field of skin that is rough enough for light to be carried through it.
ParameterMaps RoughSkin(const ParameterVector& skin, double junction_absorbance) {
  ParameterMaps maps(kFieldSize, kFieldSize, skin);
  const PlaneF roughness = RandomDetail(2);
  for (const Parameter p : {Parameter::kC_m, Parameter::kC_hd})
    for (std::size_t i = 0; i < roughness.size(); ++i)
      maps[p].data()[i] *= 1.0f + kRoughness * roughness.data()[i];
  maps.junction_absorbance = {PlaneF(kFieldSize, kFieldSize, static_cast<float>(junction_absorbance))};
  return maps;
}

// What the change does to the reflectance of uniform skin.
double UniformGain(const ForwardModel& model, int band, const ParameterVector& skin,
                   float BlurShare::*share) {
  const double junction = model.tissue().junction_absorbance;
  const LogSensitivity local = model.LocalSensitivity(band, skin, junction);
  const BandOptics& optics = model.optics()[band];
  const Absorbers& absorbers = optics.nodes[optics.center].absorbers;
  const double reflectance = model.LocalReflectance(band, skin, junction);
  if (share == &BlurShare::junction) return reflectance * local.junction_absorbance;
  if (share == &BlurShare::dermis)
    return reflectance * local.mu_a_dermis *
           absorbers.MuADermisGradient(skin)[static_cast<int>(Parameter::kC_hd)];
  return reflectance * local.mu_a_epidermis *
         absorbers.MuAEpidermisGradient(skin)[static_cast<int>(Parameter::kC_he)];
}

}  // namespace

void BlurCurve::Add(double mu_a_epidermis, const BlurShare& share) {
  log_mu_a_.push_back(static_cast<float>(std::log(std::max(mu_a_epidermis, 1e-6))));
  shares_.push_back(share);
}

BlurShare BlurCurve::At(double mu_a_epidermis) const {
  if (shares_.empty()) return {};
  const float x = std::log(std::max(static_cast<float>(mu_a_epidermis), 1e-6f));
  std::size_t i = 0;
  while (i + 2 < shares_.size() && x > log_mu_a_[i + 1]) ++i;
  if (i + 1 >= shares_.size()) return shares_[i];
  const float length = std::max(log_mu_a_[i + 1] - log_mu_a_[i], 1e-6f);
  const float t = std::clamp((x - log_mu_a_[i]) / length, 0.0f, 1.0f);
  const auto mix = [&](float BlurShare::*share) {
    return (1.0f - t) * shares_[i].*share + t * shares_[i + 1].*share;
  };
  return {mix(&BlurShare::epidermis), mix(&BlurShare::dermis), mix(&BlurShare::junction)};
}

BlurTable MeasureBlur(const ForwardModel& model, std::span<const ParameterVector> skins, int octaves) {
  const std::vector<Change> changes = Changes(RandomDetail(1));
  const PlaneF detail = RandomDetail(1);
  ForwardOptions options = model.options();
  options.engine = Engine::kLowRank;
  options.tolerance = kTolerance;
  ImagingConditions conditions = model.conditions();
  conditions.illumination = Illumination::kUniform;
  const ForwardModel exact = model.With(options);

  BlurTable table;
  for (int octave = 0; octave < octaves; ++octave, conditions.pixel_size_mm *= 2.0) {
    table.emplace_back(model.band_count());
    if (conditions.pixel_size_mm > kCoarsestPixel_mm) continue;
    const ForwardModel scaled = exact.With(conditions);
    for (const ParameterVector& skin : skins) {
      const ParameterMaps rough = RoughSkin(skin, model.tissue().junction_absorbance);
      const ForwardModel::Kept render(scaled, rough);
      std::vector<BlurShare> shares(model.band_count());
      for (const Change& change : changes) {
        const std::vector<PlaneF> response = render.Tangent(change.maps);
        for (int b = 0; b < model.band_count(); ++b)
          shares[b].*change.share = Regress(detail, response[b], UniformGain(model, b, skin, change.share));
      }
      for (int b = 0; b < model.band_count(); ++b) {
        const BandOptics& optics = model.optics()[b];
        table.back()[b].Add(optics.nodes[optics.center].absorbers.MuAEpidermis(skin), shares[b]);
      }
    }
  }
  return table;
}

}  // namespace dermap
