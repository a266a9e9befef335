// SPDX-License-Identifier: Apache-2.0
// The record of a render, differentiated backwards and forwards.
#include <algorithm>

#include "common/transport/convolver.h"
#include "common/transport/plane_graph.h"
#include "common/transport/plane_math.h"

namespace dermap {
namespace {

// Of a plane and a region of a larger one: small += slope * large, and large += slope * small.
void AddFromRegion(const PlaneF& slope, const PlaneF& large, const Region& region, PlaneF& small) {
  for (int y = 0; y < region.height; ++y)
    AccumulateRow(slope.Row(y), large.Row(y + region.y) + region.x, region.width, small.Row(y));
}
void AddToRegion(const PlaneF& slope, const PlaneF& small, const Region& region, PlaneF& large) {
  for (int y = 0; y < region.height; ++y)
    AccumulateRow(slope.Row(y), small.Row(y), region.width, large.Row(y + region.y) + region.x);
}

}  // namespace

// The first contribution to a derivative is written, later ones are added.
void PlaneGraph::AddDerivative(Id id, const PlaneF& part) {
  if (Has(id)) return AddTo(part, derivatives_[id]);
  PlaneF& plane = derivatives_[id] = TakePlane(part.width(), part.height());
  std::copy(part.values().begin(), part.values().end(), plane.values().begin());
}

void PlaneGraph::AddDerivative(Id id, const PlaneF& a, const PlaneF& b) {
  if (Has(id)) return AddProduct(a, b, derivatives_[id]);
  dermap::Product(a, b, derivatives_[id] = TakePlane(a.width(), a.height()));
}

template <class Apply>
void PlaneGraph::AddDerivativeBy(Id id, const Apply& apply) {
  PlaneF part = TakePlane(values_[id].width(), values_[id].height());
  apply(part);
  if (!Has(id)) {
    derivatives_[id] = std::move(part);
    return;
  }
  AddTo(part, derivatives_[id]);
  GivePlane(std::move(part));
}

// Adds to the derivatives by the operands what the one by the result says.
void PlaneGraph::Backward(const Operation& operation) {
  const PlaneF& weights = derivatives_[operation.out];
  const Id a = Operand(operation, 0);
  switch (operation.kind) {
    case Kind::kProducts:
      for (int i = 0; i < operation.count; i += 2) {
        const Id x = Operand(operation, i), y = Operand(operation, i + 1);
        AddDerivative(x, weights, values_[y]);
        AddDerivative(y, weights, values_[x]);
      }
      break;
    case Kind::kWeighted:
      for (int i = 0; i < operation.count; ++i)
        AddDerivative(Operand(operation, i), weights, *objects_[operation.object + i].weight);
      break;
    case Kind::kSum:
      for (int i = 0; i < operation.count; ++i) AddDerivative(Operand(operation, i), weights);
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
      AddDerivative(Operand(operation, 1), weights);
      break;
    case Kind::kConvolve: {
      const Object& object = objects_[operation.object];
      AddDerivativeBy(
          a, [&](PlaneF& part) { object.convolver->ConvolveTransposed(weights, *object.weights, part); });
      AddToRegion(values_[Operand(operation, 2)], weights, object.region, Derivative(Operand(operation, 1)));
      break;
    }
    case Kind::kFollows:
      AddToRegion(values_[Operand(operation, 1)], weights, objects_[operation.object].region, Derivative(a));
      break;
    default:
      AddDerivativeBy(a, [&](PlaneF& part) { ApplyLinear(operation, true, 0, weights, part); });
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
    case Kind::kConvolve: {
      const Object& object = objects_[operation.object];
      if (Has(a)) {
        const ConvolutionTarget target{object.weights, &Derivative(out)};
        object.convolver->Convolve(derivatives_[a], {&target, 1});
      }
      if (const Id mu_a = Operand(operation, 1); Has(mu_a))
        AddFromRegion(values_[Operand(operation, 2)], derivatives_[mu_a], object.region, Derivative(out));
      break;
    }
    case Kind::kFollows:
      AddFromRegion(values_[Operand(operation, 1)], derivatives_[a], objects_[operation.object].region,
                    Derivative(out));
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
  for (auto operation = operations_.rbegin(); operation != operations_.rend(); ++operation) {
    if (!Has(operation->out)) continue;
    Backward(*operation);
    if (operation->kind != Kind::kFollows) GivePlane(std::move(derivatives_[operation->out]));  // made here
  }
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
