// SPDX-License-Identifier: Apache-2.0
// [D08 eq. 7] by path lengths.
#include "common/transport/paths/path_light.h"

#include <algorithm>
#include <cmath>

#include "common/transport/paths/attenuation.h"

namespace dermap {
namespace {

// The transpose of ReplicateOutwards: what lies outside is added to the pixel that it repeats.
void FoldOntoPatch(const PlaneF& widened, const Domain& domain, PlaneF& patch) {
  const Region& region = domain.patch;
  EnsureShape(patch, region.width, region.height);
  if (region == domain.Whole()) {
    std::copy(widened.values().begin(), widened.values().end(), patch.values().begin());
    return;
  }
  std::fill(patch.values().begin(), patch.values().end(), 0.0f);
  for (int y = 0; y < domain.height; ++y) {
    float* to = patch.Row(std::clamp(y - region.y, 0, region.height - 1));
    for (int x = 0; x < domain.width; ++x) to[std::clamp(x - region.x, 0, region.width - 1)] += widened(x, y);
  }
}

void CropToPatch(const PlaneF& widened, const Domain& domain, PlaneF& patch) {
  const Region& region = domain.patch;
  EnsureShape(patch, region.width, region.height);
  for (int y = 0; y < region.height; ++y)
    std::copy_n(widened.Row(y + region.y) + region.x, region.width, patch.Row(y));
}

}  // namespace

PathLight::PathLight(int patch_width, int patch_height, const ImagingConditions& conditions, double margin_mm,
                     const ForwardOptions& options)
    : frames_(patch_width, patch_height, conditions, margin_mm, options),
      options_(options),
      whole_transform_(frames_.transforms().width, frames_.transforms().height),
      rest_transform_(frames_.rest.width, frames_.rest.height),
      skin_share_(frames_.SkinShare()),
      patch_share_rest_(frames_.PatchShareAtRest()),
      tape_share_rest_(patch_share_rest_),
      graph_(frames_.window ? Border::kZero : Border::kMirror) {
  const auto pair = [](const PlaneMap& map, float factor) {
    return MapPair{map.Scaled(factor), map.Transposed().Scaled(factor)};
  };
  for (std::size_t level = 0; level + 1 < frames_.levels.size(); ++level) {
    const PlaneMap down = frames_.LightDown(static_cast<int>(level));
    light_down_.push_back(pair(down, 1.0f));
    light_up_.push_back(pair(down.Transposed(), frames_.halvings > 0 ? 2.0f : 1.0f));
  }
  for (const PlaneMap& map : frames_.SkinDown()) skin_down_.push_back(pair(map, 1.0f));
  to_rest_ = pair(frames_.ToRest(), 1.0f);
  from_rest_ = pair(frames_.ToRest().Transposed(), 2.0f);
  for (float& share : tape_share_rest_.values()) share = 1.0f - share;
}

PathLight::Id PathLight::OnPatch(const PlaneF& plane) {
  const Id id = graph_.Input(frames_.patch.width, frames_.patch.height);
  ReplicateOutwards(plane, frames_.patch, graph_.Value(id));
  return id;
}

PathLight::Id PathLight::MapAndDrop(Id id, MapPair& maps) {
  const Id mapped = Map(id, maps);
  graph_.Done(id);
  return mapped;
}

// Keeps `fine` itself, drops what lies between.
PathLight::Id PathLight::SkinToWhole(Id fine) {
  Id id = fine;
  for (MapPair& maps : skin_down_) id = id == fine ? Map(id, maps) : MapAndDrop(id, maps);
  return id;
}

PathLight::Id PathLight::LightToWhole(Id light) {
  for (MapPair& maps : light_down_) light = MapAndDrop(light, maps);
  return light;
}

PathLight::Layer PathLight::MakeLayer(Id mu_a, const std::vector<double>& lengths_mm,
                                      const SymmetricKernel& stray, bool need_fine) {
  const double share = reciprocal() ? 0.5 : 1.0;  // of a path, at one end
  Layer layer;
  for (const double length_mm : lengths_mm) {
    Id fine = graph_.Exponential(mu_a, share * length_mm);
    if (!stray.empty()) {
      const Id blurred = graph_.Blur(fine, stray, true);
      graph_.Done(fine);
      fine = blurred;
    }
    Id whole = SkinToWhole(fine);
    if (!need_fine) graph_.Done(fine);
    if (frames_.window) {
      const Id on_skin = graph_.Weigh(whole, skin_share_);
      graph_.Done(whole);
      whole = on_skin;
    }
    layer.fine.push_back(fine);
    layer.whole.push_back(whole);
    layer.rest.push_back(Map(whole, to_rest_));
  }
  return layer;
}

// Light as it is after the first half of its path.
PathLight::Id PathLight::At(Id light, const Ids& ends, std::size_t path) {
  return reciprocal() ? graph_.Product(light, ends[path]) : light;
}

PathLight::Id PathLight::SumAndDrop(Id a, Id b) {
  const Id both[] = {a, b};
  const Id sum = graph_.Sum(both);
  graph_.Done(a);
  graph_.Done(b);
  return sum;
}

bool PathLight::NeedsStencil(std::size_t level, std::size_t path) const {
  return level < plan_->surface.size() && path < plan_->surface[level].size();
}

// Light along every path length on every grid, and its spectrum on the last.
void PathLight::Enter(const SeriesInput& input) {
  const std::size_t paths = plan_->epidermis_mm.size();
  for (auto& levels : light_at_) levels.clear();
  entering_.clear();
  light_ = &input.light;
  for (std::size_t j = 0; j < paths; ++j) {
    if (!reciprocal() && j > 0) {  // the same for all
      light_at_[j] = light_at_[0];
      entering_.push_back(entering_[0]);
      continue;
    }
    Id light = 0;
    if (reciprocal()) {
      light = graph_.Weigh(epidermis_.fine[j], *light_);
    } else {
      light = graph_.Input(light_->width(), light_->height());
      std::copy(light_->values().begin(), light_->values().end(), graph_.Value(light).values().begin());
    }
    light_at_[j].push_back(light);
    for (std::size_t level = 0; level < light_down_.size(); ++level) {
      const Id coarser = Map(light, light_down_[level]);
      if (!NeedsStencil(level, j)) graph_.Done(light);
      light_at_[j].push_back(light = coarser);
    }
    entering_.push_back(graph_.ToSpectrum(light, whole_transform_));
    graph_.Done(light);
  }
}

// Light that crosses the epidermis unscattered keeps its place.
PathLight::Id PathLight::Ballistic(Id junction) {
  const Id passes = graph_.Exponential(mu_a_epidermis_, plan_->ballistic_mm, plan_->ballistic_share);
  const Id through = graph_.Product(passes, junction);
  graph_.Done(passes);
  const Id lit = graph_.Weigh(through, *light_);
  graph_.Done(through);
  return LightToWhole(lit);
}

// R2 * down, and R2 of ballistic light where there is some.
PathLight::Id PathLight::ReturnFromDermis(Id down, const Id* ballistic, const PathPlan::Kernels& diffuse,
                                          const Ids& ends, CosineTransform& transform) {
  Pairs leaving;
  Id spectrum = 0, unscattered = 0;
  for (std::size_t j = 0; j < ends.size(); ++j) {
    if (reciprocal() || j == 0) {
      spectrum = graph_.ToSpectrum(At(down, ends, j), transform);
      if (ballistic) unscattered = graph_.ToSpectrum(At(*ballistic, ends, j), transform);
    }
    const PlaneGraph::Weighted both[] = {{spectrum, &diffuse.planes[j]},
                                         {unscattered, ballistic ? &plan_->r2_normal.planes[j] : nullptr}};
    const Id returned = graph_.SumOfWeighted(std::span(both).first(ballistic ? 2 : 1));
    leaving.push_back({ends[j], graph_.FromSpectrum(returned, transform)});
  }
  return graph_.SumOfProducts(leaving);
}

// R1- * up; under black tape what meets the surface stays there.
PathLight::Id PathLight::ReturnFromEpidermis(Id up, bool black_tape) {
  Pairs leaving;
  Id spectrum = 0;
  for (std::size_t j = 0; j < epidermis_.rest.size(); ++j) {
    if (reciprocal() || j == 0) spectrum = graph_.ToSpectrum(At(up, epidermis_.rest, j), rest_transform_);
    Id returned =
        graph_.FromSpectrum(graph_.Weigh(spectrum, plan_->r1_backward_rest.planes[j]), rest_transform_);
    if (black_tape) {
      const Id black = graph_.FromSpectrum(graph_.Weigh(spectrum, plan_->r1_backward_black_rest.planes[j]),
                                           rest_transform_);
      const PlaneGraph::Weighted shares[] = {{returned, &patch_share_rest_}, {black, &tape_share_rest_}};
      returned = graph_.SumOfWeighted(shares);
    }
    leaving.push_back({epidermis_.rest[j], returned});
  }
  return graph_.SumOfProducts(leaving);
}

// What one more passage is to the last where skin and light are uniform: A^2 R1- R2.
PathLight::Id PathLight::Quotient(bool black_tape) {
  const auto whole_path = [&](Id end) { return reciprocal() ? graph_.Product(end, end) : end; };
  Ids below;
  ShortList<Id, 2 * kMostPaths> above;
  for (std::size_t j = 0; j < epidermis_.rest.size(); ++j) {
    const Id path = whole_path(epidermis_.rest[j]);
    const auto total = static_cast<float>(plan_->r1_backward_rest.totals[j]);
    if (!black_tape) {
      above.push_back(graph_.Scale(path, total));
      continue;
    }
    const auto black = static_cast<float>(plan_->r1_backward_black_rest.totals[j]);
    above.push_back(graph_.Scale(graph_.Weigh(path, patch_share_rest_), total));
    above.push_back(graph_.Scale(graph_.Weigh(path, tape_share_rest_), black));
  }
  for (std::size_t j = 0; j < dermis_.rest.size(); ++j)
    below.push_back(
        graph_.Scale(whole_path(dermis_.rest[j]), static_cast<float>(plan_->r2_diffuse_rest.totals[j])));
  const Id both = graph_.Product(graph_.Sum(above), graph_.Sum(below));
  return graph_.Product(both, graph_.Product(junction_rest_, junction_rest_));
}

// All light that comes up to the junction from below, and through it.
PathLight::Id PathLight::Below(const SeriesInput& input, Id junction) {
  const Id whole = SkinToWhole(junction);
  junction_rest_ = Map(whole, to_rest_);
  Pairs leaving;
  for (std::size_t j = 0; j < epidermis_.whole.size(); ++j) {
    const Id through =
        graph_.FromSpectrum(graph_.Weigh(entering_[j], plan_->t1_forward.planes[j]), whole_transform_);
    leaving.push_back({epidermis_.whole[j], through});
  }
  const Id down = graph_.Product(graph_.SumOfProducts(leaving), whole);
  const bool has_ballistic = input.totals.has_ballistic();
  const Id ballistic = has_ballistic ? Ballistic(junction) : 0;
  const Id first = ReturnFromDermis(down, has_ballistic ? &ballistic : nullptr, plan_->r2_diffuse,
                                    dermis_.whole, whole_transform_);
  later_.clear();
  Id up = Map(first, to_rest_);
  for (int term = 1; term < input.terms; ++term) {
    const Id back = ReturnFromEpidermis(graph_.Product(up, junction_rest_), input.black_tape);
    up = ReturnFromDermis(graph_.Product(back, junction_rest_), nullptr, plan_->r2_diffuse_rest, dermis_.rest,
                          rest_transform_);
    later_.push_back(up);
  }
  // All further terms as if skin and light were uniform around each pixel.
  if (input.close) later_.push_back(graph_.Geometric(up, Quotient(input.black_tape)));
  if (later_.empty()) return graph_.Product(first, whole);
  const Id all[] = {first, Map(graph_.Sum(later_), from_rest_)};
  return graph_.Product(graph_.Sum(all), whole);
}

// R1+ of the light, each grid its part, and T1- of the light from below.
PathLight::Id PathLight::Leave(const Id* below) {
  Id up = 0, sum = 0;
  for (std::size_t j = 0; j < epidermis_.fine.size(); ++j) {
    if (below && (reciprocal() || j == 0))
      up = graph_.ToSpectrum(At(*below, epidermis_.whole, j), whole_transform_);
    const PlaneGraph::Weighted both[] = {{entering_[j], &plan_->r1_forward.planes[j]},
                                         {up, below ? &plan_->t1_backward.planes[j] : nullptr}};
    const Id spectrum = graph_.SumOfWeighted(std::span(both).first(below ? 2 : 1));
    Id light = graph_.FromSpectrum(spectrum, whole_transform_);
    graph_.Done(spectrum);
    for (std::size_t level = light_up_.size(); level-- > 0;) {
      light = MapAndDrop(light, light_up_[level]);
      if (!NeedsStencil(level, j)) continue;
      const Id with_surface = graph_.AddStencil(light_at_[j][level], light, plan_->surface[level][j]);
      graph_.Done(light);
      if (reciprocal()) graph_.Done(light_at_[j][level]);
      light = with_surface;
    }
    const PlaneGraph::Pair pair[] = {{epidermis_.fine[j], light}};
    const Id leaving = graph_.SumOfProducts(pair);
    graph_.Done(light);
    graph_.Done(epidermis_.fine[j]);
    sum = j == 0 ? leaving : SumAndDrop(sum, leaving);
  }
  return sum;
}

void PathLight::SetStray(double mu_s, Stray& stray) const {
  if (stray.mu_s == mu_s) return;
  stray.mu_s = mu_s;
  stray.kernel = reciprocal() ? StrayKernel(1.0 / mu_s, frames_.pixel_size_mm) : SymmetricKernel{};
}

void PathLight::Render(const SeriesInput& input, PathPlans& plans, bool keep, PlaneF& reflectance) {
  plan_ = plans.Get(input.tables, RangeOf(input.mu_a_epidermis, options_.tolerance),
                    RangeOf(input.mu_a_dermis, options_.tolerance), input.black_tape, frames_, options_);
  graph_.Clear(keep);
  SetStray(input.mu_s_epidermis, stray_epidermis_);
  SetStray(input.mu_s_dermis, stray_dermis_);
  mu_a_epidermis_ = OnPatch(input.mu_a_epidermis);
  mu_a_dermis_ = OnPatch(input.mu_a_dermis);
  junction_ = OnPatch(input.transmittance);
  epidermis_ = MakeLayer(mu_a_epidermis_, plan_->epidermis_mm, stray_epidermis_.kernel, true);
  Enter(input);
  if (input.terms > 0) {
    dermis_ = MakeLayer(mu_a_dermis_, plan_->dermis_mm, stray_dermis_.kernel, false);
    const Id below = Below(input, junction_);
    reflectance_ = Leave(&below);
  } else {
    reflectance_ = Leave(nullptr);
  }
  CropToPatch(graph_.Value(reflectance_), frames_.patch, reflectance);
}

void PathLight::Tangent(const SeriesChanges& changes, PlaneF& change) {
  const Id inputs[] = {mu_a_epidermis_, mu_a_dermis_, junction_};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    if (changes[i].empty()) {
      widened_[i] = PlaneF();
    } else {
      ReplicateOutwards(changes[i], frames_.patch, widened_[i]);
    }
  }
  graph_.Tangent(inputs, widened_, reflectance_, widened_weights_);
  CropToPatch(widened_weights_, frames_.patch, change);
}

void PathLight::Transpose(const PlaneF& weights, SeriesChanges& derivatives) {
  const Id inputs[] = {mu_a_epidermis_, mu_a_dermis_, junction_};
  SurroundWithZeros(weights, frames_.patch, widened_weights_);
  graph_.Transpose(reflectance_, widened_weights_, inputs, widened_);
  for (std::size_t i = 0; i < widened_.size(); ++i) FoldOntoPatch(widened_[i], frames_.patch, derivatives[i]);
}

}  // namespace dermap
