// SPDX-License-Identifier: Apache-2.0
// Operations on planes, carried out, differentiated forwards and backwards.
#include "common/transport/plane_graph.h"

#include <algorithm>
#include <cassert>

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
  values_.clear();
  derivatives_.clear();
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
  values_.push_back(TakePlane(width, height));
  derivatives_.emplace_back();
  return static_cast<Id>(values_.size()) - 1;
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
  std::vector<Id> operands;
  for (const auto& [a, b] : pairs) operands.insert(operands.end(), {a, b});
  const PlaneF& first = values_[pairs[0].first];
  return Record(Kind::kProducts, NewPlane(first.width(), first.height()), operands);
}

PlaneGraph::Id PlaneGraph::SumOfWeighted(std::span<const Weighted> terms) {
  std::vector<Id> operands;
  for (const auto& [a, weight] : terms) {
    operands.push_back(a);
    objects_.push_back({.weight = weight});
  }
  const PlaneF& first = values_[terms[0].first];
  return Record(Kind::kWeighted, NewPlane(first.width(), first.height()), operands);
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
    default:
      ApplyLinear(operation, false, 0, a, out);
  }
}

// Adds to the derivatives by the operands what the one by the result says.
void PlaneGraph::Backward(const Operation& operation) {
  const PlaneF& weights = derivatives_[operation.out];
  const Id a = Operand(operation, 0);
  switch (operation.kind) {
    case Kind::kProducts:
      for (int i = 0; i < operation.count; i += 2) {
        const Id x = Operand(operation, i), y = Operand(operation, i + 1);
        AddProduct(weights, values_[y], Derivative(x));
        AddProduct(weights, values_[x], Derivative(y));
      }
      break;
    case Kind::kWeighted:
      for (int i = 0; i < operation.count; ++i)
        AddProduct(weights, *objects_[operation.object + i].weight, Derivative(Operand(operation, i)));
      break;
    case Kind::kSum:
      for (int i = 0; i < operation.count; ++i) AddTo(weights, Derivative(Operand(operation, i)));
      break;
    case Kind::kScale:
      AddScaled(weights, operation.factor, Derivative(a));
      break;
    case Kind::kExponential:
      AddProductScaled(weights, values_[operation.out], -operation.length, Derivative(a));
      break;
    case Kind::kGeometric: {
      const Id q = Operand(operation, 1);
      PlaneF &by_a = Derivative(a), &by_q = Derivative(q);
      for (std::size_t i = 0; i < weights.size(); ++i) {
        const float rest = 1.0f / (1.0f - values_[q].data()[i]);
        by_a.data()[i] += weights.data()[i] * values_[q].data()[i] * rest;
        by_q.data()[i] += weights.data()[i] * values_[a].data()[i] * rest * rest;
      }
      break;
    }
    case Kind::kStencil:
      stencils_.AddTo(weights, *objects_[operation.object].stencil, nullptr, Derivative(a));
      AddTo(weights, Derivative(Operand(operation, 1)));
      break;
    default: {
      PlaneF part = TakePlane(values_[a].width(), values_[a].height());
      ApplyLinear(operation, true, 0, weights, part);
      AddTo(part, Derivative(a));
      GivePlane(std::move(part));
    }
  }
}

// Adds to the change of the result what the operands' changes make of it.
void PlaneGraph::Forward(const Operation& operation) {
  const Id a = Operand(operation, 0), out = operation.out;
  bool any = false;
  for (int i = 0; i < operation.count; ++i) any = any || Has(Operand(operation, i));
  if (!any) return;
  switch (operation.kind) {
    case Kind::kProducts:
      for (int i = 0; i < operation.count; i += 2) {
        const Id x = Operand(operation, i), y = Operand(operation, i + 1);
        if (Has(x)) AddProduct(derivatives_[x], values_[y], Derivative(out));
        if (Has(y)) AddProduct(values_[x], derivatives_[y], Derivative(out));
      }
      break;
    case Kind::kWeighted:
      for (int i = 0; i < operation.count; ++i)
        if (const Id x = Operand(operation, i); Has(x))
          AddProduct(derivatives_[x], *objects_[operation.object + i].weight, Derivative(out));
      break;
    case Kind::kSum:
      for (int i = 0; i < operation.count; ++i)
        if (const Id x = Operand(operation, i); Has(x)) AddTo(derivatives_[x], Derivative(out));
      break;
    case Kind::kScale:
      AddScaled(derivatives_[a], operation.factor, Derivative(out));
      break;
    case Kind::kExponential:
      AddProductScaled(derivatives_[a], values_[out], -operation.length, Derivative(out));
      break;
    case Kind::kGeometric: {
      const Id q = Operand(operation, 1);
      PlaneF& change = Derivative(out);
      for (std::size_t i = 0; i < change.size(); ++i) {
        const float rest = 1.0f / (1.0f - values_[q].data()[i]);
        if (Has(a)) change.data()[i] += derivatives_[a].data()[i] * values_[q].data()[i] * rest;
        if (Has(q)) change.data()[i] += derivatives_[q].data()[i] * values_[a].data()[i] * rest * rest;
      }
      break;
    }
    case Kind::kStencil:
      if (Has(a))
        stencils_.AddTo(derivatives_[a], *objects_[operation.object].stencil, nullptr, Derivative(out));
      if (const Id to = Operand(operation, 1); Has(to)) AddTo(derivatives_[to], Derivative(out));
      break;
    default:
      ApplyLinear(operation, false, 0, derivatives_[a], Derivative(out));
  }
}

void PlaneGraph::Transpose(Id of, const PlaneF& weights, std::span<const Id> inputs,
                           std::span<PlaneF> derivatives) {
  ClearDerivatives();
  PlaneF& seed = Derivative(of);
  std::copy(weights.values().begin(), weights.values().end(), seed.values().begin());
  for (auto operation = operations_.rbegin(); operation != operations_.rend(); ++operation)
    if (Has(operation->out)) Backward(*operation);
  for (std::size_t i = 0; i < inputs.size(); ++i) derivatives[i] = Derivative(inputs[i]);
}

void PlaneGraph::Tangent(std::span<const Id> inputs, std::span<const PlaneF> changes, Id of, PlaneF& change) {
  ClearDerivatives();
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (changes[i].empty()) continue;
    PlaneF& seed = Derivative(inputs[i]);
    std::copy(changes[i].values().begin(), changes[i].values().end(), seed.values().begin());
  }
  for (const Operation& operation : operations_) Forward(operation);
  change = Derivative(of);
}

}  // namespace dermap
