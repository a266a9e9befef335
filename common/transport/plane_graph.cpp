// SPDX-License-Identifier: Apache-2.0
// Operations on planes, carried out, differentiated forwards and backwards.
#include "common/transport/plane_graph.h"

#include <algorithm>
#include <cassert>

#include "common/transport/convolver.h"
#include "common/transport/domain.h"
#include "common/transport/paths/attenuation.h"
#include "common/transport/plane_math.h"

namespace dermap {

PlaneF PlaneGraph::TakePlane(int width, int height) {
  std::vector<PlaneF>& planes = free_[{width, height}];
  if (planes.empty()) return {width, height};
  PlaneF plane = std::move(planes.back());
  planes.pop_back();
  return plane;
}

void PlaneGraph::GivePlane(PlaneF&& plane) {
  if (plane.empty()) return;
  const std::pair shape{plane.width(), plane.height()};
  free_[shape].push_back(std::move(plane));
  plane = PlaneF();
}

void PlaneGraph::Clear(bool keep) {
  keep_ = keep;
  ClearDerivatives();
  for (PlaneF& plane : values_) GivePlane(std::move(plane));
  count_ = 0;
  operations_.clear();
  operands_.clear();
  objects_.clear();
}

void PlaneGraph::ClearDerivatives() {
  for (PlaneF& plane : derivatives_) {
    GivePlane(std::move(plane));
    plane = PlaneF();
  }
}

PlaneF& PlaneGraph::Derivative(Id id) {
  PlaneF& plane = derivatives_[id];
  if (plane.empty()) {
    plane = TakePlane(values_[id].width(), values_[id].height());
    std::fill(plane.values().begin(), plane.values().end(), 0.0f);
  }
  return plane;
}

PlaneGraph::Id PlaneGraph::NewPlane(int width, int height) {
  if (count_ == static_cast<Id>(values_.size())) {
    values_.emplace_back();
    derivatives_.emplace_back();
  }
  values_[count_] = TakePlane(width, height);
  return count_++;
}

PlaneGraph::Id PlaneGraph::Input(int width, int height) {
  return NewPlane(width, height);
}

// Objects, where there are any, were appended just before.
PlaneGraph::Id PlaneGraph::Record(Kind kind, Id out, std::span<const Id> operands, float length,
                                  float factor) {
  const int count = static_cast<int>(operands.size());
  operations_.push_back({kind, out, static_cast<int>(operands_.size()), count, length, factor,
                         static_cast<int>(objects_.size()) - count});
  operands_.insert(operands_.end(), operands.begin(), operands.end());
  Compute(operations_.back());
  return out;
}

PlaneGraph::Id PlaneGraph::SumOfProducts(std::span<const Pair> pairs) {
  listed_.clear();
  for (const auto& [a, b] : pairs) {
    listed_.push_back(a);
    listed_.push_back(b);
  }
  const PlaneF& first = values_[pairs[0].first];
  return Record(Kind::kProducts, NewPlane(first.width(), first.height()), listed_);
}

PlaneGraph::Id PlaneGraph::SumOfWeighted(std::span<const Weighted> terms) {
  listed_.clear();
  for (const auto& [a, weight] : terms) {
    listed_.push_back(a);
    objects_.push_back({.weight = weight});
  }
  const PlaneF& first = values_[terms[0].first];
  return Record(Kind::kWeighted, NewPlane(first.width(), first.height()), listed_);
}

PlaneGraph::Id PlaneGraph::Sum(std::span<const Id> terms) {
  const PlaneF& first = values_[terms[0]];
  return Record(Kind::kSum, NewPlane(first.width(), first.height()), terms);
}

PlaneGraph::Id PlaneGraph::Scale(Id a, float factor) {
  return Record(Kind::kScale, NewPlane(values_[a].width(), values_[a].height()), {&a, 1}, 0.0f, factor);
}

PlaneGraph::Id PlaneGraph::Exponential(Id a, double length, double factor) {
  return Record(Kind::kExponential, NewPlane(values_[a].width(), values_[a].height()), {&a, 1},
                static_cast<float>(length), static_cast<float>(factor));
}

PlaneGraph::Id PlaneGraph::Geometric(Id a, Id q) {
  const Id operands[] = {a, q};
  return Record(Kind::kGeometric, NewPlane(values_[a].width(), values_[a].height()), operands);
}

PlaneGraph::Id PlaneGraph::Blur(Id a, const SymmetricKernel& kernel, bool mirrored) {
  objects_.push_back({.kernel = &kernel});
  return Record(Kind::kBlur, NewPlane(values_[a].width(), values_[a].height()), {&a, 1}, 0.0f,
                mirrored ? 1.0f : 0.0f);
}

PlaneGraph::Id PlaneGraph::ToSpectrum(Id a, CosineTransform& transform) {
  objects_.push_back({.transform = &transform});
  return Record(Kind::kToSpectrum, NewPlane(values_[a].width(), values_[a].height()), {&a, 1});
}

PlaneGraph::Id PlaneGraph::FromSpectrum(Id a, CosineTransform& transform) {
  objects_.push_back({.transform = &transform});
  return Record(Kind::kFromSpectrum, NewPlane(values_[a].width(), values_[a].height()), {&a, 1});
}

PlaneGraph::Id PlaneGraph::Map(Id a, PlaneMap& map, PlaneMap& transposed) {
  objects_.push_back({.map = &map, .transposed = &transposed});
  return Record(Kind::kMap, NewPlane(map.width(), map.height()), {&a, 1});
}

PlaneGraph::Id PlaneGraph::AddStencil(Id a, Id to, const Stencil& stencil) {
  const Id operands[] = {a, to};
  objects_.push_back({.stencil = &stencil});
  objects_.push_back({});
  return Record(Kind::kStencil, NewPlane(values_[a].width(), values_[a].height()), operands);
}

PlaneGraph::Id PlaneGraph::Convolve(Id a, Id mu_a, Convolver& convolver, const ResponseWeights& weights) {
  const Region& region = weights.region();
  const Id out = NewPlane(region.width, region.height);
  const Id operands[] = {a, mu_a, keep_ ? NewPlane(region.width, region.height) : a};
  objects_.push_back({.convolver = &convolver, .weights = &weights, .region = region});
  objects_.insert(objects_.end(), 2, {});
  return Record(Kind::kConvolve, out, operands);
}

void PlaneGraph::Follows(Id out, Id a, Id slope, const Region& region) {
  const Id operands[] = {a, slope};
  objects_.push_back({.region = region});
  objects_.push_back({});
  Record(Kind::kFollows, out, operands);
}

// One operand's part of a linear operation, or of its transpose: out = part(in).
void PlaneGraph::ApplyLinear(const Operation& operation, bool transposed, int operand, const PlaneF& in,
                             PlaneF& out) {
  const Object& object = objects_[operation.object + operand];
  switch (operation.kind) {
    case Kind::kBlur:
      BlurOf(operation).Apply(in, *object.kernel, out);
      break;
    case Kind::kToSpectrum:
    case Kind::kFromSpectrum:
      EnsureShape(out, in.width(), in.height());
      std::copy(in.values().begin(), in.values().end(), out.values().begin());
      // Orthonormal: the inverse is the transpose.
      if ((operation.kind == Kind::kToSpectrum) != transposed) {
        object.transform->Forward(out);
      } else {
        object.transform->Inverse(out);
      }
      break;
    case Kind::kMap:
      (transposed ? object.transposed : object.map)->Apply(in, out);
      break;
    default:
      assert(false);
  }
}

void PlaneGraph::Compute(const Operation& operation) {
  PlaneF& out = values_[operation.out];
  const PlaneF& a = values_[Operand(operation, 0)];
  switch (operation.kind) {
    case Kind::kProducts:
      for (int i = 0; i < operation.count; i += 2) {
        const PlaneF &x = values_[Operand(operation, i)], &y = values_[Operand(operation, i + 1)];
        i == 0 ? dermap::Product(x, y, out) : AddProduct(x, y, out);
      }
      break;
    case Kind::kWeighted:
      for (int i = 0; i < operation.count; ++i) {
        const PlaneF &x = values_[Operand(operation, i)], &weight = *objects_[operation.object + i].weight;
        i == 0 ? dermap::Product(x, weight, out) : AddProduct(x, weight, out);
      }
      break;
    case Kind::kSum:
      std::copy(a.values().begin(), a.values().end(), out.values().begin());
      for (int i = 1; i < operation.count; ++i) AddTo(values_[Operand(operation, i)], out);
      break;
    case Kind::kScale:
      Scaled(a, operation.factor, out);
      break;
    case Kind::kExponential:
      Attenuate(a, operation.length, out);
      if (operation.factor != 1.0f) Scaled(out, operation.factor, out);
      break;
    case Kind::kGeometric: {
      const PlaneF& q = values_[Operand(operation, 1)];
      for (std::size_t i = 0; i < out.size(); ++i)
        out.data()[i] = a.data()[i] * q.data()[i] / (1.0f - q.data()[i]);
      break;
    }
    case Kind::kStencil: {
      PlaneF& to = values_[Operand(operation, 1)];
      if (keep_) {
        std::copy(to.values().begin(), to.values().end(), out.values().begin());
      } else {
        std::swap(to, out);
      }
      stencils_.AddTo(a, *objects_[operation.object].stencil, nullptr, out);
      break;
    }
    case Kind::kConvolve: {
      const Object& object = objects_[operation.object];
      const ConvolutionTarget target{object.weights, &out, keep_ ? &values_[Operand(operation, 2)] : nullptr};
      object.convolver->Convolve(a, {&target, 1});
      break;
    }
    case Kind::kFollows:
      break;
    default:
      ApplyLinear(operation, false, 0, a, out);
  }
}

}  // namespace dermap
