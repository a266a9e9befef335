// SPDX-License-Identifier: Apache-2.0
// [D08 eq. 7] by path lengths, on two grids.
#include "common/transport/path_series.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/core/kernel.h"

namespace dermap {
namespace {

// What the coarser grid leaves out of the light that has been through the dermis, at its finest structure, in
// units of the tolerance.
constexpr double kCoarseShare = 10.0;

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

DERMAP_KERNEL
void AddTo(const float* addend, std::size_t n, float* __restrict sum) noexcept {
  for (std::size_t i = 0; i < n; ++i) sum[i] += addend[i];
}

void Clear(PlaneF& plane, int width, int height) {
  EnsureShape(plane, width, height);
  std::fill(plane.values().begin(), plane.values().end(), 0.0f);
}

void SetProduct(const PlaneF& a, const PlaneF& b, PlaneF& out) {
  EnsureShape(out, a.width(), a.height());
  Product(a.data(), b.data(), a.size(), out.data());
}

// reflectance += leaving * whole, on the patch.
void AddOnPatch(const PlaneF& leaving, const PlaneF& whole, const Region& patch, PlaneF& reflectance) {
  for (int y = 0; y < patch.height; ++y)
    AddProduct(leaving.Row(y), whole.Row(y + patch.y) + patch.x, patch.width, reflectance.Row(y));
}

// Share of a response that is left at frequency k, for absorption `mu_a`.
double ShareAt(const PathLayer& layer, int response, double k_per_mm, double mu_a) {
  double at_k = 0.0, total = 0.0;
  for (int j = 0; j < layer.count(); ++j) {
    const double passes = std::exp(-mu_a * layer.length_mm(j));
    at_k += layer.kernel(response, j).At(k_per_mm) * passes;
    total += layer.total(response, j) * passes;
  }
  return total > 0.0 ? std::abs(at_k) / total : 0.0;
}

}  // namespace

PathSeries::PathSeries(std::unique_ptr<PathGrid> grid, Coupling coupling, double tolerance)
    : grid_(std::move(grid)), coupling_(coupling), tolerance_(tolerance) {}

// The coarsest grid that holds what comes through the epidermis, the dermis and the epidermis again.
int PathSeries::CoarseFactor() const {
  for (const int factor : {4, 2}) {
    const double k = grid_->Nyquist_per_mm(factor);
    const double e = epidermis_.range().highest, d = dermis_.range().highest;
    const double share = ShareAt(epidermis_, kT1Forward, k, e) * ShareAt(dermis_, kR2Diffuse, k, d) *
                         ShareAt(epidermis_, kT1Backward, k, e);
    if (share <= kCoarseShare * tolerance_) return factor;
  }
  return 1;
}

void PathSeries::SetScene(const SeriesInput& input) {
  const BandTables& t = input.tables;
  const std::array epidermis{&t.r1_forward.transforms(), &t.t1_forward.transforms(), &t.r1_backward.transforms(),
                             &t.t1_backward.transforms(), &t.r1_backward_black.transforms()};
  const std::array dermis{&t.r2_diffuse.transforms(), &t.r2_normal.transforms()};
  const double pixel = grid_->pixel_size_mm();
  const auto used = std::span(epidermis).first(input.black_tape ? 5 : 4);
  epidermis_.Set(used, input.mu_a_epidermis, 1.0 / input.mu_s_epidermis, pixel, coupling_, tolerance_);
  dermis_.Set(dermis, input.mu_a_dermis, 1.0 / input.mu_s_dermis, pixel, coupling_, tolerance_);
  factor_ = CoarseFactor();
  skin_share_ = grid_->SkinShare(factor_);
  if (input.black_tape) patch_share_ = grid_->PatchShare(factor_);
  const auto coarsen = [&](const PlaneF& patch, PlaneF& coarse) {
    ReplicateOutwards(patch, domain(), fine_);
    AverageBlocks(fine_, factor_, coarse);
    MultiplyBy(skin_share_.data(), coarse.size(), coarse.data());
  };
  coarse_epidermis_.resize(epidermis_.count());
  for (int j = 0; j < epidermis_.count(); ++j) coarsen(epidermis_.leaving(j), coarse_epidermis_[j]);
  coarse_dermis_.resize(dermis_.count());
  for (int j = 0; j < dermis_.count(); ++j) coarsen(dermis_.leaving(j), coarse_dermis_[j]);
  ReplicateOutwards(input.transmittance, domain(), junction_);
  AverageBlocks(junction_, factor_, coarse_junction_);
}

// Phi * R1+ on the patch, and Phi * T1+ on the coarser grid.
void PathSeries::EnterEpidermis(const SeriesInput& input, PlaneF& reflectance) {
  Clear(reflectance, domain().patch.width, domain().patch.height);
  Clear(down_, grid_->Width(factor_), grid_->Height(factor_));
  for (int j = 0; j < epidermis_.count(); ++j) {
    if (epidermis_.attenuates_entering()) {
      ReplicateOutwards(epidermis_.leaving(j), domain(), spectrum_);
      MultiplyBy(input.light.data(), spectrum_.size(), spectrum_.data());
    } else {
      spectrum_ = input.light;
    }
    CosineTransform(spectrum_);
    TruncateSpectrum(spectrum_, factor_, coarse_);
    grid_->Multiply(epidermis_.kernel(kR1Forward, j), spectrum_);
    InverseCosineTransform(spectrum_);
    AddOnPatch(epidermis_.leaving(j), spectrum_, domain().patch, reflectance);
    grid_->Multiply(epidermis_.kernel(kT1Forward, j), coarse_);
    InverseCosineTransform(coarse_);
    AddProduct(coarse_epidermis_[j].data(), coarse_.data(), coarse_.size(), down_.data());
  }
}

// Light that crosses the epidermis unscattered keeps its place.
void PathSeries::AddBallistic(const SeriesInput& input) {
  const Region& patch = domain().patch;
  Clear(fine_, domain().width, domain().height);
  for (int y = 0; y < domain().height; ++y) {
    const int from_y = std::clamp(y - patch.y, 0, patch.height - 1);
    for (int x = 0; x < domain().width; ++x) {
      const float light = input.light(x, y);
      if (light == 0.0f) continue;
      const int from_x = std::clamp(x - patch.x, 0, patch.width - 1);
      fine_(x, y) = light * junction_(x, y) *
                    input.totals.Ballistic(PositionInTable(input.mu_a_epidermis(from_x, from_y)));
    }
  }
  AverageBlocks(fine_, factor_, ballistic_);
}

// up_ = R2 * (A down_), and R2 of ballistic light where there is some.
void PathSeries::ReturnFromDermis(bool ballistic) {
  MultiplyBy(coarse_junction_.data(), down_.size(), down_.data());
  Clear(up_, down_.width(), down_.height());
  const auto spectrum_of = [&](const PlaneF& light, int j, DermisResponse response, PlaneF& spectrum) {
    if (dermis_.attenuates_entering()) {
      SetProduct(light, coarse_dermis_[j], spectrum);
    } else {
      spectrum = light;
    }
    CosineTransform(spectrum);
    grid_->Multiply(dermis_.kernel(response, j), spectrum);
  };
  for (int j = 0; j < dermis_.count(); ++j) {
    spectrum_of(down_, j, kR2Diffuse, coarse_);
    if (ballistic) {
      spectrum_of(ballistic_, j, kR2Normal, coarse_spectrum_);
      AddTo(coarse_spectrum_.data(), coarse_.size(), coarse_.data());
    }
    InverseCosineTransform(coarse_);
    AddProduct(coarse_dermis_[j].data(), coarse_.data(), up_.size(), up_.data());
  }
}

// down_ = R1- * (A up_); under black tape what meets the surface stays there.
void PathSeries::ReturnFromEpidermis(bool black_tape) {
  MultiplyBy(coarse_junction_.data(), up_.size(), up_.data());
  Clear(down_, up_.width(), up_.height());
  for (int j = 0; j < epidermis_.count(); ++j) {
    if (epidermis_.attenuates_entering()) {
      SetProduct(up_, coarse_epidermis_[j], coarse_);
    } else {
      coarse_ = up_;
    }
    CosineTransform(coarse_);
    if (black_tape) black_ = coarse_;
    grid_->Multiply(epidermis_.kernel(kR1Backward, j), coarse_);
    InverseCosineTransform(coarse_);
    if (black_tape) {
      grid_->Multiply(epidermis_.kernel(kR1BackwardBlack, j), black_);
      InverseCosineTransform(black_);
      for (std::size_t i = 0; i < coarse_.size(); ++i)
        coarse_.data()[i] =
            black_.data()[i] + patch_share_.data()[i] * (coarse_.data()[i] - black_.data()[i]);
    }
    AddProduct(coarse_epidermis_[j].data(), coarse_.data(), down_.size(), down_.data());
  }
}

// All further terms as if skin and light were uniform around each pixel: a geometric series of the last term.
void PathSeries::AddRemainder(bool black_tape) {
  const bool twice = coupling_ == Coupling::kReciprocal;  // attenuations are of half a path
  for (std::size_t i = 0; i < up_.size(); ++i) {
    float r1 = 0.0f, r2 = 0.0f;
    for (int j = 0; j < epidermis_.count(); ++j) {
      const float a = coarse_epidermis_[j].data()[i],
                  open = static_cast<float>(epidermis_.total(kR1Backward, j));
      const float total = black_tape ? open * patch_share_.data()[i] +
                                           static_cast<float>(epidermis_.total(kR1BackwardBlack, j)) *
                                               (1.0f - patch_share_.data()[i])
                                     : open;
      r1 += total * (twice ? a * a : a);
    }
    for (int j = 0; j < dermis_.count(); ++j) {
      const float a = coarse_dermis_[j].data()[i];
      r2 += static_cast<float>(dermis_.total(kR2Diffuse, j)) * (twice ? a * a : a);
    }
    const float a = coarse_junction_.data()[i], quotient = a * a * r1 * r2;
    up_sum_.data()[i] += up_.data()[i] * quotient / (1.0f - quotient);
  }
}

// reflectance += T1- * (A up_sum_).
void PathSeries::LeaveEpidermis(PlaneF& reflectance) {
  if (factor_ > 1) {
    CosineTransform(up_sum_);
    ExtendSpectrum(up_sum_, factor_, fine_);
    InverseCosineTransform(fine_);
  } else {
    fine_ = up_sum_;
  }
  MultiplyBy(junction_.data(), fine_.size(), fine_.data());
  for (int j = 0; j < epidermis_.count(); ++j) {
    if (epidermis_.attenuates_entering()) {
      ReplicateOutwards(epidermis_.leaving(j), domain(), spectrum_);
      MultiplyBy(fine_.data(), spectrum_.size(), spectrum_.data());
    } else {
      spectrum_ = fine_;
    }
    CosineTransform(spectrum_);
    grid_->Multiply(epidermis_.kernel(kT1Backward, j), spectrum_);
    InverseCosineTransform(spectrum_);
    AddOnPatch(epidermis_.leaving(j), spectrum_, domain().patch, reflectance);
  }
}

void PathSeries::Render(const SeriesInput& input, PlaneF& reflectance) {
  SetScene(input);
  EnterEpidermis(input, reflectance);
  if (input.terms < 1) return;
  const bool ballistic = input.totals.has_ballistic();
  if (ballistic) AddBallistic(input);
  ReturnFromDermis(ballistic);
  up_sum_ = up_;
  for (int term = 1; term < input.terms; ++term) {
    ReturnFromEpidermis(input.black_tape);
    ReturnFromDermis(false);
    AddTo(up_.data(), up_.size(), up_sum_.data());
  }
  if (input.close) AddRemainder(input.black_tape);
  LeaveEpidermis(reflectance);
}

}  // namespace dermap
