// SPDX-License-Identifier: Apache-2.0
// Rows of derivatives.
#include "fit/octave_rows.h"

namespace dermap {
namespace {

// sum += weight * spectrum; the wavelength is left.
void AddSpectrum(double weight, const Absorbers& spectrum, Absorbers& sum) {
  sum.eumelanin += weight * spectrum.eumelanin;
  sum.pheomelanin += weight * spectrum.pheomelanin;
  sum.blood_epidermis += weight * spectrum.blood_epidermis;
  sum.blood_dermis += weight * spectrum.blood_dermis;
  sum.carotene += weight * spectrum.carotene;
  sum.baseline += weight * spectrum.baseline;
}

}  // namespace

FilterAbsorbers AbsorbersOf(const BandOptics& optics, const SkinPoint& skin) {
  const BandOptics::Node& middle = optics.nodes[optics.center];
  FilterAbsorbers absorbers{middle.absorbers, middle.absorbers, middle.absorbers};
  if (optics.nodes.size() == 1) return absorbers;
  const ParameterVector p = TableOne(skin);
  const auto derivatives = [&](const BandOptics::Node& node) {
    return node.tables.TotalReflectanceDerivatives(node.absorbers.MuAEpidermis(p),
                                                   node.absorbers.MuADermis(p), skin[kParameterCount]);
  };
  const auto center = derivatives(middle);
  double reflectance = 0.0, junction = 0.0;
  for (const BandOptics::Node& node : optics.nodes) {
    const auto total = derivatives(node);
    reflectance += node.weight * total.reflectance;
    junction += node.weight * total.d_junction_absorbance;
  }
  const double scale = center.reflectance / reflectance;
  absorbers.junction = scale * junction / center.d_junction_absorbance;
  absorbers.epidermis = absorbers.dermis = Absorbers{middle.absorbers.wavelength_nm};
  for (const BandOptics::Node& node : optics.nodes) {
    const auto total = derivatives(node);
    AddSpectrum(scale * node.weight * total.d_mu_a_epidermis / center.d_mu_a_epidermis, node.absorbers,
                absorbers.epidermis);
    AddSpectrum(scale * node.weight * total.d_mu_a_dermis / center.d_mu_a_dermis, node.absorbers,
                absorbers.dermis);
  }
  return absorbers;
}

const std::vector<BlurCurve>* BlurOf(const DetailView& model, std::size_t octave) {
  return octave < model.blur.size() ? &model.blur[octave] : nullptr;
}

RowMaker::RowMaker(const PatchProblem& problem, const OctaveLevel& level, const std::vector<BlurCurve>* blur,
                   const SkinPoint& fixed)
    : space_(problem.space()), level_(level), blur_(blur), fixed_(fixed) {
  FreeVector mean{};
  for (int j = 0; j < space_.count(); ++j) {
    for (const float value : level.position[j].values()) mean[j] += value;
    mean[j] /= static_cast<double>(level.position[j].size());
  }
  for (const BandOptics& optics : problem.model().optics())
    absorbers_.push_back(AbsorbersOf(optics, PointOf(mean)));
}

SkinPoint RowMaker::PointOf(const FreeVector& position) const {
  SkinPoint point = fixed_;
  space_.ToParameters(position, point);
  return point;
}

void RowMaker::Fill(std::size_t pixel, std::span<OctaveRow> rows) const {
  FreeVector position{};
  for (int j = 0; j < space_.count(); ++j) position[j] = level_.position[j].data()[pixel];
  const ParameterVector p = TableOne(PointOf(position));
  for (std::size_t b = 0; b < rows.size(); ++b) {
    const FilterAbsorbers& absorbers = absorbers_[b];
    const BlurShare seen = blur_ ? (*blur_)[b].At(absorbers.center.MuAEpidermis(p)) : BlurShare{};
    const ParameterVector of_epidermis = absorbers.epidermis.MuAEpidermisGradient(p);
    const ParameterVector of_dermis = absorbers.dermis.MuADermisGradient(p);
    const float epidermis = level_.epidermis[b].data()[pixel], dermis = level_.dermis[b].data()[pixel];
    rows[b].epidermis_share = seen.epidermis;
    for (int j = 0; j < space_.count(); ++j) {
      const int k = static_cast<int>(space_.parameter(j));
      const auto scale = static_cast<float>(space_.scale(j));
      float above = 0.0f, below = 0.0f, between = 0.0f;
      if (k < kParameterCount) {
        above = epidermis * static_cast<float>(of_epidermis[k]) * scale;
        below = dermis * static_cast<float>(of_dermis[k]) * scale;
      } else {
        between = level_.junction[b].data()[pixel] * static_cast<float>(absorbers.junction) * scale;
      }
      rows[b].unblurred[j] = above + below + between;
      rows[b].blurred[j] = seen.epidermis * above + seen.dermis * below + seen.junction * between;
    }
  }
}

}  // namespace dermap
