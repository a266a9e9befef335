// SPDX-License-Identifier: Apache-2.0
// [D08 eq. 7] with its misprints mended: every term is T1+ . A . (R2 . A . R1- . A)^n . R2 . A . T1-. The
// draft puts a T1- into the middle of a term [eq. 3] and ends one on R1- [eq. 7]; light that ends its way
// below would never be seen.
#include "common/transport/scattering_series.h"

#include <algorithm>

namespace dermap {
namespace {

LineEnd EndOf(BeneathTape beneath) {
  switch (beneath) {
    case BeneathTape::kEdge:
      return LineEnd::kReplicate;
    case BeneathTape::kMirrored:
      return LineEnd::kMirror;
    case BeneathTape::kMean:
      return LineEnd::kMean;
  }
  return LineEnd::kReplicate;
}

}  // namespace

ScatteringSeries::ScatteringSeries(const Domain& domain, std::unique_ptr<Convolver> convolver,
                                   BeneathTape beneath)
    : domain_(domain), convolver_(std::move(convolver)) {
  const LineEnd end = EndOf(beneath);
  to_whole_ = {LineMap::Shift(domain.patch.width, domain.width, -domain.patch.x, end),
               LineMap::Shift(domain.patch.height, domain.height, -domain.patch.y, end)};
  from_whole_ = to_whole_.Transposed();
}

ScatteringSeries::Id ScatteringSeries::ToWhole(const PlaneF& patch, Id& input) {
  input = graph_.Input(patch.width(), patch.height());
  std::copy(patch.values().begin(), patch.values().end(), graph_.Value(input).values().begin());
  return graph_.Map(input, to_whole_, from_whole_);
}

void ScatteringSeries::SetLayer(const PlaneF& mu_a, Layer& layer) {
  layer.whole = ToWhole(mu_a, layer.patch);
  layer.positions.SetWhole(graph_.Value(layer.whole), keep_);
}

void ScatteringSeries::SetScene(const SeriesInput& input) {
  SetLayer(input.mu_a_epidermis, epidermis_);
  SetLayer(input.mu_a_dermis, dermis_);
  junction_ = ToWhole(input.transmittance, junction_input_);
  const Region whole = domain_.Whole();
  const TablePositions &above = epidermis_.positions, &below = dermis_.positions;
  r1_forward_.Set(input.tables.r1_forward, above, domain_.patch, keep_);
  t1_forward_.Set(input.tables.t1_forward, above, whole, keep_);
  if (input.terms < 1) return;
  t1_backward_.Set(input.tables.t1_backward, above, domain_.patch, keep_);
  r2_diffuse_.Set(input.tables.r2_diffuse, below, whole, keep_);
  if (input.totals.has_ballistic()) r2_normal_.Set(input.tables.r2_normal, below, whole, keep_);
  if (input.terms < 2) return;
  // Where light comes back to the face under black tape, it stays there.
  const ProfileTable& under_tape =
      input.black_tape ? input.tables.r1_backward_black : input.tables.r1_backward;
  r1_backward_.SetTwo(input.tables.r1_backward, under_tape, above, whole, domain_.patch, keep_);
}

// A total response of every pixel's own skin, one table inside the patch and one outside.
ScatteringSeries::Id ScatteringSeries::LookUp(const LocalTotals::Totals& inside,
                                              const LocalTotals::Totals& outside, const Layer& layer) {
  const Region whole = domain_.Whole(), &patch = domain_.patch;
  const Id out = graph_.Input(whole.width, whole.height);
  const Id slope = keep_ ? graph_.Input(whole.width, whole.height) : out;
  const auto fill = [&](const LocalTotals::Totals& column, int y, int from, int to) {
    const TablePositions& at = layer.positions;
    const int* index = at.index.Row(y) + from;
    InterpolateColumn(column.data(), index, at.fraction.Row(y) + from, to - from,
                      graph_.Value(out).Row(y) + from);
    if (!keep_) return;
    InterpolateColumnSlope(column.data(), index, at.slope.Row(y) + from, to - from,
                           graph_.Value(slope).Row(y) + from);
  };
  for (int y = 0; y < whole.height; ++y) {
    fill(outside, y, 0, whole.width);
    if (y >= patch.y && y < patch.y + patch.height) fill(inside, y, patch.x, patch.x + patch.width);
  }
  if (keep_) graph_.Follows(out, layer.whole, slope, whole);
  return out;
}

ScatteringSeries::Id ScatteringSeries::ProductAndDrop(Id a, Id b) {
  const Id product = graph_.Product(a, b);
  graph_.Done(a);
  return product;
}

ScatteringSeries::Id ScatteringSeries::SumAndDrop(Id a, Id b) {
  const Id both[] = {a, b};
  const Id sum = graph_.Sum(both);
  graph_.Done(a);
  return sum;
}

ScatteringSeries::Id ScatteringSeries::Convolve(Id a, const Layer& layer, const ResponseWeights& weights) {
  const Id out = graph_.Convolve(a, layer.whole, *convolver_, weights);
  graph_.Done(a);
  return out;
}

// What the surface returns, and what goes down through it: both of the same blurs of the light.
ScatteringSeries::Id ScatteringSeries::Enter(const SeriesInput& input) {
  const Region &patch = domain_.patch, whole = domain_.Whole();
  surface_ = graph_.Input(patch.width, patch.height);
  const Id down = graph_.Input(whole.width, whole.height);
  const Id surface_slope = keep_ ? graph_.Input(patch.width, patch.height) : surface_;
  const Id down_slope = keep_ ? graph_.Input(whole.width, whole.height) : down;
  const auto target = [&](const ResponseWeights& weights, Id out, Id slope) {
    return ConvolutionTarget{&weights, &graph_.Value(out), keep_ ? &graph_.Value(slope) : nullptr};
  };
  const ConvolutionTarget both[] = {target(r1_forward_, surface_, surface_slope),
                                    target(t1_forward_, down, down_slope)};
  convolver_->Convolve(input.light, {both, input.terms > 0 ? 2u : 1u});
  if (!keep_) return down;
  graph_.Follows(surface_, epidermis_.whole, surface_slope, patch);
  if (input.terms > 0) graph_.Follows(down, epidermis_.whole, down_slope, whole);
  return down;
}

// R2 * (A down), for the diffuse part and, where there is one, for the part that has not been scattered yet.
ScatteringSeries::Id ScatteringSeries::EnterDermis(Id down, const SeriesInput& input) {
  const Id up = Convolve(ProductAndDrop(down, junction_), dermis_, r2_diffuse_);
  if (!input.totals.has_ballistic()) return up;
  const Id share = LookUp(input.totals.t1_ballistic(), input.totals.t1_ballistic(), epidermis_);
  const Id lit = graph_.Weigh(share, input.light);
  graph_.Done(share);
  return SumAndDrop(Convolve(ProductAndDrop(lit, junction_), dermis_, r2_normal_), up);
}

// All further terms as if skin and light were uniform around each pixel: a geometric series of the last term.
ScatteringSeries::Id ScatteringSeries::Remainder(Id up, const SeriesInput& input) {
  const LocalTotals& totals = input.totals;
  const Id below = LookUp(totals.r2_diffuse(), totals.r2_diffuse(), dermis_);
  const Id above = ProductAndDrop(
      LookUp(totals.r1_backward(false), totals.r1_backward(input.black_tape), epidermis_), below);
  const Id quotient = ProductAndDrop(ProductAndDrop(above, junction_), junction_);
  return graph_.Geometric(up, quotient);
}

void ScatteringSeries::Render(const SeriesInput& input, PlaneF& reflectance, bool keep) {
  keep_ = keep;
  graph_.Clear(keep);
  SetScene(input);
  const Id down = Enter(input);
  reflectance_ = surface_;
  if (input.terms > 0) {
    Id up = EnterDermis(down, input), sum = up;
    for (int term = 1; term < input.terms; ++term) {
      const Id start = graph_.Product(up, junction_);
      if (up != sum) graph_.Done(up);
      const Id back = Convolve(start, epidermis_, r1_backward_);
      up = Convolve(ProductAndDrop(back, junction_), dermis_, r2_diffuse_);
      sum = SumAndDrop(sum, up);
    }
    if (input.close) sum = SumAndDrop(sum, Remainder(up, input));
    const Id leaving = Convolve(ProductAndDrop(sum, junction_), epidermis_, t1_backward_);
    reflectance_ = SumAndDrop(surface_, leaving);
  }
  const PlaneF& result = graph_.Value(reflectance_);
  EnsureShape(reflectance, result.width(), result.height());
  std::copy(result.values().begin(), result.values().end(), reflectance.values().begin());
}

void ScatteringSeries::Tangent(const SeriesChanges& changes, PlaneF& change) {
  const Id inputs[] = {epidermis_.patch, dermis_.patch, junction_input_};
  graph_.Tangent(inputs, changes, reflectance_, change);
}

void ScatteringSeries::Transpose(const PlaneF& weights, SeriesChanges& derivatives) {
  const Id inputs[] = {epidermis_.patch, dermis_.patch, junction_input_};
  graph_.Transpose(reflectance_, weights, inputs, derivatives);
}

}  // namespace dermap
