// SPDX-License-Identifier: Apache-2.0
// [D08 eq. 7] by path lengths, on two grids.
#include "common/transport/path_series.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

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

PathSeries::PathSeries(int patch_width, int patch_height, const ImagingConditions& conditions,
                       const ForwardOptions& options)
    : pixel_size_mm_(conditions.pixel_size_mm),
      window_(conditions.illumination == Illumination::kWindow),
      coupling_(options.coupling),
      tolerance_(options.path_tolerance),
      layout_(MakePathLayout(patch_width, patch_height, pixel_size_mm_, options.margin_mm, window_)),
      near_grid_(layout_.near.width, layout_.near.height, pixel_size_mm_),
      whole_grid_(layout_.whole.width, layout_.whole.height, pixel_size_mm_) {}

// The coarsest grid that holds what comes through the epidermis, the dermis and the epidermis again, or,
// after the first time, through both layers once more.
int PathSeries::CoarseFactor(bool first) const {
  const double e = epidermis_.range().highest, d = dermis_.range().highest;
  for (const int factor : {4, 2}) {
    const double k = std::numbers::pi / (factor * pixel_size_mm_);
    double share = ShareAt(epidermis_, kT1Forward, k, e) * ShareAt(dermis_, kR2Diffuse, k, d) *
                   ShareAt(epidermis_, kT1Backward, k, e);
    if (!first) share *= ShareAt(epidermis_, kR1Backward, k, e) * ShareAt(dermis_, kR2Diffuse, k, d);
    if (share <= kCoarseShare * tolerance_) return factor;
  }
  return 1;
}

// A plane of the near pixels, made coarser and continued over all of the skin.
void PathSeries::ToWhole(const PlaneF& near, int factor, PlaneF& whole) const {
  PlaneF coarse;
  AverageBlocks(near, factor, coarse);
  ReplicateOutwards(coarse, Coarsened(layout_.whole, factor), whole);
}

void PathSeries::SetBelow(int factor, const SeriesInput& input, Below& below) {
  const Domain &near = layout_.near, &whole = layout_.whole;
  if (below.factor != factor) {
    below.factor = factor;
    below.skin_share = ShareOf(layout_.skin, whole.width, whole.height, factor);
    const Region patch{whole.patch.x + near.patch.x, whole.patch.y + near.patch.y, near.patch.width,
                       near.patch.height};
    below.patch_share = ShareOf(patch, whole.width, whole.height, factor);
  }
  const auto set = [&](const PathLayer& layer, std::vector<PlaneF>& planes) {
    planes.resize(layer.count());
    for (int j = 0; j < layer.count(); ++j) {
      ReplicateOutwards(layer.leaving(j), near, fine_);
      ToWhole(fine_, factor, planes[j]);
      MultiplyBy(below.skin_share.data(), planes[j].size(), planes[j].data());
    }
  };
  set(epidermis_, below.epidermis);
  set(dermis_, below.dermis);
  ReplicateOutwards(input.transmittance, near, junction_);
  ToWhole(junction_, factor, below.junction);
}

void PathSeries::SetScene(const SeriesInput& input) {
  const BandTables& t = input.tables;
  const std::array epidermis{&t.r1_forward.transforms(), &t.t1_forward.transforms(),
                             &t.r1_backward.transforms(), &t.t1_backward.transforms(),
                             &t.r1_backward_black.transforms()};
  const std::array dermis{&t.r2_diffuse.transforms(), &t.r2_normal.transforms()};
  const auto used = std::span(epidermis).first(input.black_tape ? 5 : 4);
  epidermis_.Set(used, input.mu_a_epidermis, 1.0 / input.mu_s_epidermis, pixel_size_mm_, coupling_,
                 tolerance_);
  dermis_.Set(dermis, input.mu_a_dermis, 1.0 / input.mu_s_dermis, pixel_size_mm_, coupling_, tolerance_);
  SetBelow(CoarseFactor(true), input, first_);
  SetBelow(CoarseFactor(false), input, rest_);
}

// Phi * R1+ on the patch, and Phi * T1+ below.
void PathSeries::EnterEpidermis(const SeriesInput& input, PlaneF& reflectance) {
  const int factor = first_.factor;
  const Domain whole = Coarsened(layout_.whole, factor);
  Clear(reflectance, domain().patch.width, domain().patch.height);
  Clear(first_.down, whole.width, whole.height);
  for (int j = 0; j < epidermis_.count(); ++j) {
    if (epidermis_.attenuates_entering()) {
      ReplicateOutwards(epidermis_.leaving(j), domain(), spectrum_);
      MultiplyBy(input.light.data(), spectrum_.size(), spectrum_.data());
    } else {
      spectrum_ = input.light;
    }
    CosineTransform(spectrum_);
    TruncateSpectrum(spectrum_, factor, coarse_);
    near_grid_.Multiply(epidermis_.kernel(kR1Forward, j), spectrum_);
    InverseCosineTransform(spectrum_);
    AddOnPatch(epidermis_.leaving(j), spectrum_, domain().patch, reflectance);
    near_grid_.Multiply(epidermis_.kernel(kT1Forward, j), coarse_);
    InverseCosineTransform(coarse_);
    // Beyond what is near there is no light to come through, or light and skin that go on.
    if (window_) {
      SurroundWithZeros(coarse_, whole, first_.scratch);
    } else {
      ReplicateOutwards(coarse_, whole, first_.scratch);
    }
    AddProduct(first_.epidermis[j].data(), first_.scratch.data(), first_.scratch.size(), first_.down.data());
  }
}

// Light that crosses the epidermis unscattered keeps its place.
void PathSeries::AddBallistic(const SeriesInput& input) {
  const Region& patch = domain().patch;
  PlaneF passes(patch.width, patch.height);
  for (std::size_t i = 0; i < passes.size(); ++i)
    passes.data()[i] = input.totals.Ballistic(PositionInTable(input.mu_a_epidermis.data()[i]));
  ReplicateOutwards(passes, domain(), fine_);
  MultiplyBy(junction_.data(), fine_.size(), fine_.data());
  MultiplyBy(input.light.data(), fine_.size(), fine_.data());
  if (!window_) {
    ToWhole(fine_, first_.factor, ballistic_);
    return;
  }
  AverageBlocks(fine_, first_.factor, coarse_);
  SurroundWithZeros(coarse_, Coarsened(layout_.whole, first_.factor), ballistic_);
}

// up = R2 * (A down), and R2 of ballistic light where there is some.
void PathSeries::ReturnFromDermis(Below& below, const PlaneF* ballistic) const {
  MultiplyBy(below.junction.data(), below.down.size(), below.down.data());
  Clear(below.up, below.down.width(), below.down.height());
  const auto set_spectrum = [&](const PlaneF& light, int j, DermisResponse response, PlaneF& spectrum) {
    if (dermis_.attenuates_entering()) {
      SetProduct(light, below.dermis[j], spectrum);
    } else {
      spectrum = light;
    }
    CosineTransform(spectrum);
    whole_grid_.Multiply(dermis_.kernel(response, j), spectrum);
  };
  for (int j = 0; j < dermis_.count(); ++j) {
    set_spectrum(below.down, j, kR2Diffuse, below.scratch);
    if (ballistic) {
      set_spectrum(*ballistic, j, kR2Normal, below.spectrum);
      AddTo(below.spectrum.data(), below.scratch.size(), below.scratch.data());
    }
    InverseCosineTransform(below.scratch);
    AddProduct(below.dermis[j].data(), below.scratch.data(), below.up.size(), below.up.data());
  }
}

// down = R1- * (A up); under black tape what meets the surface stays there.
void PathSeries::ReturnFromEpidermis(Below& below, bool black_tape) const {
  MultiplyBy(below.junction.data(), below.up.size(), below.up.data());
  Clear(below.down, below.up.width(), below.up.height());
  for (int j = 0; j < epidermis_.count(); ++j) {
    if (epidermis_.attenuates_entering()) {
      SetProduct(below.up, below.epidermis[j], below.scratch);
    } else {
      below.scratch = below.up;
    }
    CosineTransform(below.scratch);
    if (black_tape) below.spectrum = below.scratch;
    whole_grid_.Multiply(epidermis_.kernel(kR1Backward, j), below.scratch);
    InverseCosineTransform(below.scratch);
    if (black_tape) {
      PlaneF& black = below.spectrum;
      whole_grid_.Multiply(epidermis_.kernel(kR1BackwardBlack, j), black);
      InverseCosineTransform(black);
      for (std::size_t i = 0; i < black.size(); ++i)
        below.scratch.data()[i] =
            black.data()[i] + below.patch_share.data()[i] * (below.scratch.data()[i] - black.data()[i]);
    }
    AddProduct(below.epidermis[j].data(), below.scratch.data(), below.down.size(), below.down.data());
  }
}

// All further terms as if skin and light were uniform around each pixel: a geometric series of the last term.
void PathSeries::AddRemainder(Below& below, bool black_tape) const {
  const bool half = coupling_ == Coupling::kReciprocal;  // attenuations are of half a path
  for (std::size_t i = 0; i < below.up.size(); ++i) {
    float r1 = 0.0f, r2 = 0.0f;
    for (int j = 0; j < epidermis_.count(); ++j) {
      const float a = below.epidermis[j].data()[i];
      auto total = static_cast<float>(epidermis_.total(kR1Backward, j));
      if (black_tape) {
        const auto black = static_cast<float>(epidermis_.total(kR1BackwardBlack, j));
        total = black + below.patch_share.data()[i] * (total - black);
      }
      r1 += total * (half ? a * a : a);
    }
    for (int j = 0; j < dermis_.count(); ++j) {
      const float a = below.dermis[j].data()[i];
      r2 += static_cast<float>(dermis_.total(kR2Diffuse, j)) * (half ? a * a : a);
    }
    const float a = below.junction.data()[i], quotient = a * a * r1 * r2;
    below.up_sum.data()[i] += below.up.data()[i] * quotient / (1.0f - quotient);
  }
}

// upward_ += up, on the near pixels.
void PathSeries::AddUpward(const PlaneF& up, int factor) {
  Crop(up, Coarsened(layout_.whole, factor), coarse_);
  if (factor > 1) {
    CosineTransform(coarse_);
    ExtendSpectrum(coarse_, factor, fine_);
    InverseCosineTransform(fine_);
  } else {
    fine_ = coarse_;
  }
  AddTo(fine_.data(), fine_.size(), upward_.data());
}

// reflectance += T1- * (A upward_).
void PathSeries::LeaveEpidermis(PlaneF& reflectance) {
  MultiplyBy(junction_.data(), upward_.size(), upward_.data());
  for (int j = 0; j < epidermis_.count(); ++j) {
    if (epidermis_.attenuates_entering()) {
      ReplicateOutwards(epidermis_.leaving(j), domain(), spectrum_);
      MultiplyBy(upward_.data(), spectrum_.size(), spectrum_.data());
    } else {
      spectrum_ = upward_;
    }
    CosineTransform(spectrum_);
    near_grid_.Multiply(epidermis_.kernel(kT1Backward, j), spectrum_);
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
  ReturnFromDermis(first_, ballistic ? &ballistic_ : nullptr);
  Clear(upward_, domain().width, domain().height);
  AddUpward(first_.up, first_.factor);
  AverageBlocks(first_.up, rest_.factor / first_.factor, rest_.up);
  Clear(rest_.up_sum, rest_.up.width(), rest_.up.height());
  for (int term = 1; term < input.terms; ++term) {
    ReturnFromEpidermis(rest_, input.black_tape);
    ReturnFromDermis(rest_, nullptr);
    AddTo(rest_.up.data(), rest_.up.size(), rest_.up_sum.data());
  }
  if (input.close) AddRemainder(rest_, input.black_tape);
  AddUpward(rest_.up_sum, rest_.factor);
  LeaveEpidermis(reflectance);
}

}  // namespace dermap
