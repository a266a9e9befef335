// SPDX-License-Identifier: Apache-2.0
// [D08 eq. 7] with its misprints mended: every term is T1+ . A . (R2 . A . R1- . A)^n . R2 . A . T1-. The
// draft puts a T1- into the middle of a term [eq. 3] and ends one on R1- [eq. 7]; light that ends its way
// below would never be seen.
#include "common/transport/scattering_series.h"

#include "common/core/kernel.h"

namespace dermap {
namespace {

DERMAP_KERNEL
void MultiplyBy(const float* factor, std::size_t n, float* __restrict values) noexcept {
  for (std::size_t i = 0; i < n; ++i) values[i] *= factor[i];
}

DERMAP_KERNEL
void AddTo(const float* addend, std::size_t n, float* __restrict values) noexcept {
  for (std::size_t i = 0; i < n; ++i) values[i] += addend[i];
}

}  // namespace

ScatteringSeries::ScatteringSeries(const Domain& domain, std::unique_ptr<Convolver> convolver)
    : domain_(domain), convolver_(std::move(convolver)) {}

void ScatteringSeries::SetScene(const SeriesInput& input) {
  epidermis_.Set(input.mu_a_epidermis, domain_);
  dermis_.Set(input.mu_a_dermis, domain_);
  ReplicateOutwards(input.transmittance, domain_, junction_);
  const Region whole = domain_.Whole();
  r1_forward_.Set(input.tables.r1_forward, epidermis_, domain_.patch);
  t1_forward_.Set(input.tables.t1_forward, epidermis_, whole);
  if (input.terms < 1) return;
  t1_backward_.Set(input.tables.t1_backward, epidermis_, domain_.patch);
  r2_diffuse_.Set(input.tables.r2_diffuse, dermis_, whole);
  if (input.totals.has_ballistic()) r2_normal_.Set(input.tables.r2_normal, dermis_, whole);
  if (input.terms < 2) return;
  // Where light comes back to the face under black tape, it stays there.
  const ProfileTable& under_tape =
      input.black_tape ? input.tables.r1_backward_black : input.tables.r1_backward;
  r1_backward_.SetTwo(input.tables.r1_backward, under_tape, epidermis_, whole, domain_.patch);
}

void ScatteringSeries::ApplyJunction(PlaneF& flux) const {
  MultiplyBy(junction_.data(), flux.size(), flux.data());
}

// up_ = R2 * (A down_), for the diffuse part and, where there is one, for the part that has not been
// scattered yet.
void ScatteringSeries::EnterDermis(const SeriesInput& input) {
  ApplyJunction(down_);
  const ConvolutionTarget diffuse{&r2_diffuse_, &up_};
  convolver_->Convolve(down_, {&diffuse, 1});
  if (input.totals.has_ballistic()) AddBallistic(input);
}

void ScatteringSeries::AddBallistic(const SeriesInput& input) {
  for (int y = 0; y < domain_.height; ++y) {
    for (int x = 0; x < domain_.width; ++x) {
      const TablePosition position{epidermis_.index(x, y), epidermis_.fraction(x, y)};
      down_(x, y) = input.totals.Ballistic(position) * input.light(x, y);
    }
  }
  ApplyJunction(down_);
  const ConvolutionTarget normal{&r2_normal_, &up_of_ballistic_};
  convolver_->Convolve(down_, {&normal, 1});
  AddTo(up_of_ballistic_.data(), up_.size(), up_.data());
}

// All further terms as if skin and light were uniform around each pixel: a geometric series of the last term.
void ScatteringSeries::AddRemainder(const SeriesInput& input) {
  const Region& patch = domain_.patch;
  for (int y = 0; y < domain_.height; ++y) {
    const bool in_rows = y >= patch.y && y < patch.y + patch.height;
    for (int x = 0; x < domain_.width; ++x) {
      const bool in_patch = in_rows && x >= patch.x && x < patch.x + patch.width;
      const float quotient = input.totals.Quotient({epidermis_.index(x, y), epidermis_.fraction(x, y)},
                                                   {dermis_.index(x, y), dermis_.fraction(x, y)},
                                                   junction_(x, y), input.black_tape && !in_patch);
      up_sum_(x, y) += up_(x, y) * quotient / (1.0f - quotient);
    }
  }
}

void ScatteringSeries::Render(const SeriesInput& input, PlaneF& reflectance) {
  SetScene(input);
  const ConvolutionTarget first[] = {{&r1_forward_, &reflectance}, {&t1_forward_, &down_}};
  convolver_->Convolve(input.light, {first, input.terms > 0 ? 2u : 1u});
  if (input.terms < 1) return;
  EnterDermis(input);
  up_sum_ = up_;
  for (int term = 1; term < input.terms; ++term) {
    ApplyJunction(up_);
    const ConvolutionTarget back_down{&r1_backward_, &down_};
    convolver_->Convolve(up_, {&back_down, 1});
    ApplyJunction(down_);
    const ConvolutionTarget back_up{&r2_diffuse_, &up_};
    convolver_->Convolve(down_, {&back_up, 1});
    AddTo(up_.data(), up_.size(), up_sum_.data());
  }
  if (input.close) AddRemainder(input);
  ApplyJunction(up_sum_);
  const ConvolutionTarget out{&t1_backward_, &leaving_};
  convolver_->Convolve(up_sum_, {&out, 1});
  AddTo(leaving_.data(), leaving_.size(), reflectance.data());
}

}  // namespace dermap
