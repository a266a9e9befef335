// SPDX-License-Identifier: Apache-2.0
// [D08 eq. 7] by path lengths.
#include "common/transport/paths/path_light.h"

#include <algorithm>
#include <cmath>

#include "common/core/kernel.h"

namespace dermap {
namespace {

DERMAP_KERNEL
void MultiplyBy(const float* factor, std::size_t n, float* __restrict values) noexcept {
  for (std::size_t i = 0; i < n; ++i) values[i] *= factor[i];
}

DERMAP_KERNEL
void Product(const float* a, const float* b, std::size_t n, float* __restrict out) noexcept {
  for (std::size_t i = 0; i < n; ++i) out[i] = a[i] * b[i];
}

DERMAP_KERNEL
void AddProduct(const float* a, const float* b, std::size_t n, float* __restrict sum) noexcept {
  for (std::size_t i = 0; i < n; ++i) sum[i] += a[i] * b[i];
}

// values = values * by + a * b
DERMAP_KERNEL
void MultiplyAndAdd(const float* by, const float* a, const float* b, std::size_t n,
                    float* __restrict values) noexcept {
  for (std::size_t i = 0; i < n; ++i) values[i] = values[i] * by[i] + a[i] * b[i];
}

DERMAP_KERNEL
void AddTo(const float* addend, std::size_t n, float* __restrict sum) noexcept {
  for (std::size_t i = 0; i < n; ++i) sum[i] += addend[i];
}

DERMAP_KERNEL
void Scale(float factor, std::size_t n, float* values) noexcept {
  for (std::size_t i = 0; i < n; ++i) values[i] *= factor;
}

void Clear(PlaneF& plane, int width, int height) {
  EnsureShape(plane, width, height);
  std::fill(plane.values().begin(), plane.values().end(), 0.0f);
}

void SetProduct(const PlaneF& a, const PlaneF& b, PlaneF& out) {
  EnsureShape(out, a.width(), a.height());
  Product(a.data(), b.data(), a.size(), out.data());
}

void Accumulate(const PlaneF& a, const PlaneF& b, PlaneF& sum) {
  AddProduct(a.data(), b.data(), sum.size(), sum.data());
}

}  // namespace

PathLight::PathLight(int patch_width, int patch_height, const ImagingConditions& conditions,
                     const ForwardOptions& options)
    : frames_(patch_width, patch_height, conditions, options),
      options_(options),
      skin_down_(frames_.SkinDown()),
      to_rest_(frames_.ToRest()),
      from_rest_(to_rest_.Transposed().Scaled(2.0f)),
      whole_(frames_.transforms()),
      rest_(frames_.rest),
      stencils_(frames_.window ? Border::kZero : Border::kMirror),
      skin_share_(frames_.SkinShare()),
      patch_share_rest_(frames_.PatchShareAtRest()) {
  for (std::size_t level = 0; level + 1 < frames_.levels.size(); ++level) {
    light_down_.push_back(frames_.LightDown(static_cast<int>(level)));
    light_up_.push_back(light_down_.back().Transposed().Scaled(frames_.halvings > 0 ? 2.0f : 1.0f));
  }
  step_.resize(frames_.levels.size());
  surface_.resize(std::max(frames_.halvings - 1, 0));
}

void PathLight::SkinToWhole(const PlaneF& fine, PlaneF& whole) {
  const PlaneF* from = &fine;
  for (std::size_t i = 0; i + 1 < skin_down_.size(); ++i) {
    skin_down_[i].Apply(*from, step_[i + 1]);
    from = &step_[i + 1];
  }
  skin_down_.back().Apply(*from, whole);
}

void PathLight::SetLayer(const PlaneF& mu_a, const std::vector<double>& lengths_mm,
                         const SymmetricKernel& stray, bool keep_fine, Layer& layer) {
  const double share = options_.coupling == Coupling::kReciprocal ? 0.5 : 1.0;  // of a path, at one end
  layer.fine.resize(std::max(layer.fine.size(), keep_fine ? lengths_mm.size() : std::size_t{1}));
  layer.whole.resize(std::max(layer.whole.size(), lengths_mm.size()));
  layer.rest.resize(layer.whole.size());
  ReplicateOutwards(mu_a, frames_.patch, mu_a_);
  for (std::size_t j = 0; j < lengths_mm.size(); ++j) {
    PlaneF& fine = layer.fine[keep_fine ? j : 0];
    Attenuate(mu_a_, share * lengths_mm[j], fine);
    if (!stray.empty()) blur_.Apply(fine, stray, fine);
    SkinToWhole(fine, layer.whole[j]);
    if (frames_.window) MultiplyBy(skin_share_.data(), skin_share_.size(), layer.whole[j].data());
    to_rest_.Apply(layer.whole[j], layer.rest[j]);
  }
}

void PathLight::SetScene(const SeriesInput& input, PathPlans& plans) {
  plan_ = plans.Get(input.tables, RangeOf(input.mu_a_epidermis), RangeOf(input.mu_a_dermis), input.black_tape,
                    frames_, options_);
  const bool reciprocal = options_.coupling == Coupling::kReciprocal;
  const auto stray = [&](double mu_s) {
    return reciprocal ? StrayKernel(1.0 / mu_s, frames_.pixel_size_mm) : SymmetricKernel{};
  };
  SetLayer(input.mu_a_epidermis, plan_->epidermis_mm, stray(input.mu_s_epidermis), true, epidermis_);
  SetLayer(input.mu_a_dermis, plan_->dermis_mm, stray(input.mu_s_dermis), false, dermis_);
  ReplicateOutwards(input.transmittance, frames_.patch, junction_);
  SkinToWhole(junction_, junction_whole_);
  to_rest_.Apply(junction_whole_, junction_rest_);
}

// Light along every path length, made coarser, to its spectrum; what the surface's fine structure returns of
// it; and Phi * T1+ below.
void PathLight::Enter(const SeriesInput& input, PlaneF& surface) {
  const bool reciprocal = options_.coupling == Coupling::kReciprocal;
  const std::size_t paths = plan_->epidermis_mm.size();
  entering_.resize(std::max(entering_.size(), paths));
  for (auto& level : surface_) level.resize(std::max(level.size(), paths));
  Clear(surface, frames_.patch.width, frames_.patch.height);
  Clear(down_, frames_.transforms().width, frames_.transforms().height);
  for (std::size_t j = 0; j < paths; ++j) {
    if (reciprocal) {
      SetProduct(epidermis_.fine[j], input.light, step_[0]);
    } else {
      step_[0] = input.light;
    }
    for (std::size_t level = 0; level < light_down_.size(); ++level) {
      if (level > 0) {
        PlaneF& sum = surface_[level - 1][j];
        Clear(sum, frames_.levels[level].width, frames_.levels[level].height);
        if (j < plan_->surface[level].size())
          stencils_.AddTo(step_[level], plan_->surface[level][j], nullptr, sum);
      } else if (frames_.halvings > 0 && j < plan_->surface[0].size()) {
        stencils_.AddTo(step_[0], plan_->surface[0][j], &epidermis_.fine[j], surface);
      }
      light_down_[level].Apply(step_[level], step_[level + 1]);
    }
    entering_[j] = step_.back();
    whole_.transform.Forward(entering_[j]);
    SetProduct(entering_[j], plan_->t1_forward.planes[j], whole_.spectrum);
    whole_.transform.Inverse(whole_.spectrum);
    Accumulate(epidermis_.whole[j], whole_.spectrum, down_);
  }
}

// Light that crosses the epidermis unscattered keeps its place.
void PathLight::AddBallistic(const SeriesInput& input) {
  ReplicateOutwards(input.mu_a_epidermis, frames_.patch, mu_a_);
  Attenuate(mu_a_, plan_->ballistic_mm, step_[0]);
  Scale(static_cast<float>(plan_->ballistic_share), step_[0].size(), step_[0].data());
  MultiplyBy(junction_.data(), junction_.size(), step_[0].data());
  MultiplyBy(input.light.data(), junction_.size(), step_[0].data());
  for (std::size_t level = 0; level < light_down_.size(); ++level)
    light_down_[level].Apply(step_[level], step_[level + 1]);
  ballistic_ = step_.back();
}

// up = R2 * down, and R2 of ballistic light where there is some.
void PathLight::ReturnFromDermis(const PathPlan::Kernels& diffuse, const PlaneF& down,
                                 const PlaneF* ballistic, const std::vector<PlaneF>& ends, Grid& grid,
                                 PlaneF& up) {
  const bool reciprocal = options_.coupling == Coupling::kReciprocal;
  Clear(up, down.width(), down.height());
  const auto set = [&](const PlaneF& light, std::size_t j, const PlaneF& kernel, PlaneF& spectrum) {
    if (reciprocal) {
      SetProduct(light, ends[j], spectrum);
    } else {
      spectrum = light;
    }
    grid.transform.Forward(spectrum);
    MultiplyBy(kernel.data(), spectrum.size(), spectrum.data());
  };
  for (std::size_t j = 0; j < diffuse.planes.size(); ++j) {
    set(down, j, diffuse.planes[j], grid.spectrum);
    if (ballistic) {
      set(*ballistic, j, plan_->r2_normal.planes[j], grid.scratch);
      AddTo(grid.scratch.data(), grid.scratch.size(), grid.spectrum.data());
    }
    grid.transform.Inverse(grid.spectrum);
    Accumulate(ends[j], grid.spectrum, up);
  }
}

// down_rest_ = R1- * (A up_rest_); under black tape what meets the surface stays there.
void PathLight::ReturnFromEpidermis(bool black_tape) {
  const bool reciprocal = options_.coupling == Coupling::kReciprocal;
  MultiplyBy(junction_rest_.data(), up_rest_.size(), up_rest_.data());
  Clear(down_rest_, up_rest_.width(), up_rest_.height());
  for (std::size_t j = 0; j < plan_->epidermis_mm.size(); ++j) {
    if (reciprocal) {
      SetProduct(up_rest_, epidermis_.rest[j], rest_.scratch);
    } else {
      rest_.scratch = up_rest_;
    }
    rest_.transform.Forward(rest_.scratch);
    SetProduct(rest_.scratch, plan_->r1_backward_rest.planes[j], rest_.spectrum);
    rest_.transform.Inverse(rest_.spectrum);
    if (black_tape) {
      SetProduct(rest_.scratch, plan_->r1_backward_black_rest.planes[j], black_);
      rest_.transform.Inverse(black_);
      for (std::size_t i = 0; i < black_.size(); ++i)
        rest_.spectrum.data()[i] =
            black_.data()[i] + patch_share_rest_.data()[i] * (rest_.spectrum.data()[i] - black_.data()[i]);
    }
    Accumulate(epidermis_.rest[j], rest_.spectrum, down_rest_);
  }
}

// All further terms as if skin and light were uniform around each pixel: a geometric series of the last term.
void PathLight::AddRemainder(bool black_tape) {
  const bool half = options_.coupling == Coupling::kReciprocal;  // attenuations are of half a path
  for (std::size_t i = 0; i < up_rest_.size(); ++i) {
    float r1 = 0.0f, r2 = 0.0f;
    for (std::size_t j = 0; j < plan_->epidermis_mm.size(); ++j) {
      const float a = epidermis_.rest[j].data()[i];
      auto total = static_cast<float>(plan_->r1_backward_rest.totals[j]);
      if (black_tape) {
        const auto black = static_cast<float>(plan_->r1_backward_black_rest.totals[j]);
        total = black + patch_share_rest_.data()[i] * (total - black);
      }
      r1 += total * (half ? a * a : a);
    }
    for (std::size_t j = 0; j < plan_->dermis_mm.size(); ++j) {
      const float a = dermis_.rest[j].data()[i];
      r2 += static_cast<float>(plan_->r2_diffuse_rest.totals[j]) * (half ? a * a : a);
    }
    const float a = junction_rest_.data()[i], quotient = a * a * r1 * r2;
    up_sum_rest_.data()[i] += up_rest_.data()[i] * quotient / (1.0f - quotient);
  }
}

// reflectance += R1+ of the coarse part of the light, and T1- of the light from below.
void PathLight::Leave(const SeriesInput& input, PlaneF& reflectance) {
  const bool reciprocal = options_.coupling == Coupling::kReciprocal;
  if (input.terms > 0) MultiplyBy(junction_whole_.data(), upward_.size(), upward_.data());
  for (std::size_t j = 0; j < plan_->epidermis_mm.size(); ++j) {
    PlaneF& spectrum = step_.back();
    if (input.terms > 0) {
      if (reciprocal) {
        SetProduct(upward_, epidermis_.whole[j], spectrum);
      } else {
        spectrum = upward_;
      }
      whole_.transform.Forward(spectrum);
      MultiplyAndAdd(plan_->t1_backward.planes[j].data(), entering_[j].data(),
                     plan_->r1_forward.planes[j].data(), spectrum.size(), spectrum.data());
    } else {
      SetProduct(entering_[j], plan_->r1_forward.planes[j], spectrum);
    }
    whole_.transform.Inverse(spectrum);
    for (std::size_t level = light_up_.size(); level-- > 0;) {
      light_up_[level].Apply(step_[level + 1], step_[level]);
      if (level > 0) AddTo(surface_[level - 1][j].data(), step_[level].size(), step_[level].data());
    }
    Accumulate(epidermis_.fine[j], step_[0], reflectance);
  }
}

void PathLight::Render(const SeriesInput& input, PathPlans& plans, PlaneF& reflectance) {
  SetScene(input, plans);
  Enter(input, scratch_fine_);
  if (input.terms > 0) {
    const bool ballistic = input.totals.has_ballistic();
    if (ballistic) AddBallistic(input);
    MultiplyBy(junction_whole_.data(), down_.size(), down_.data());
    ReturnFromDermis(plan_->r2_diffuse, down_, ballistic ? &ballistic_ : nullptr, dermis_.whole, whole_,
                     upward_);
    to_rest_.Apply(upward_, up_rest_);
    Clear(up_sum_rest_, up_rest_.width(), up_rest_.height());
    for (int term = 1; term < input.terms; ++term) {
      ReturnFromEpidermis(input.black_tape);
      MultiplyBy(junction_rest_.data(), down_rest_.size(), down_rest_.data());
      ReturnFromDermis(plan_->r2_diffuse_rest, down_rest_, nullptr, dermis_.rest, rest_, up_rest_);
      AddTo(up_rest_.data(), up_rest_.size(), up_sum_rest_.data());
    }
    if (input.close) AddRemainder(input.black_tape);
    from_rest_.Apply(up_sum_rest_, whole_.spectrum);
    AddTo(whole_.spectrum.data(), whole_.spectrum.size(), upward_.data());
  }
  Leave(input, scratch_fine_);
  const Region& patch = frames_.patch.patch;
  EnsureShape(reflectance, patch.width, patch.height);
  for (int y = 0; y < patch.height; ++y)
    std::copy_n(scratch_fine_.Row(y + patch.y) + patch.x, patch.width, reflectance.Row(y));
}

}  // namespace dermap
