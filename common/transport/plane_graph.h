// SPDX-License-Identifier: Apache-2.0
// A render as a record of operations on planes: each is carried out when it is asked for and remembered, so
// that the same record gives the product with the render's Jacobian (forwards) and with its transpose
// (backwards), exact to rounding, whatever the engine.
#pragma once

#include <array>
#include <deque>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "common/core/image.h"
#include "common/transport/blur.h"
#include "common/transport/domain.h"
#include "common/transport/paths/cosine_transform.h"
#include "common/transport/paths/line_map.h"
#include "common/transport/paths/stencil.h"

namespace dermap {

class Convolver;
class ResponseWeights;

// One a thread. What is passed by reference (maps, kernels, transforms) is borrowed until Clear().
class PlaneGraph {
 public:
  using Id = int;

  // `border`: what lies beyond a plane for blurs that are told so and for stencils.
  explicit PlaneGraph(Border border) : blur_(border), mirrored_blur_(Border::kMirror), stencils_(border) {}

  // Forgets the record; keeps the memory. `keep`: whether what follows will be asked for derivatives.
  void Clear(bool keep = true);
  // Not needed any more, unless for derivatives: its memory serves the next plane.
  void Done(Id id) {
    if (!keep_) GivePlane(std::move(values_[id]));
  }
  // A plane that the caller fills.
  Id Input(int width, int height);
  PlaneF& Value(Id id) { return values_[id]; }
  const PlaneF& Value(Id id) const { return values_[id]; }

  using Pair = std::pair<Id, Id>;
  using Weighted = std::pair<Id, const PlaneF*>;
  Id Product(Id a, Id b) { return SumOfProducts(std::array{Pair{a, b}}); }
  Id SumOfProducts(std::span<const Pair> pairs);
  Id Weigh(Id a, const PlaneF& weight) { return SumOfWeighted(std::array{Weighted{a, &weight}}); }
  Id SumOfWeighted(std::span<const Weighted> terms);
  Id Sum(std::span<const Id> terms);
  Id Scale(Id a, float factor);
  Id Exponential(Id a, double length, double factor = 1.0);  // factor * exp(-length * a)
  Id Geometric(Id a, Id q);                                  // a q / (1 - q)
  Id Blur(Id a, const SymmetricKernel& kernel, bool mirrored);
  Id ToSpectrum(Id a, CosineTransform& transform);
  Id FromSpectrum(Id a, CosineTransform& transform);
  Id Map(Id a, PlaneMap& map, PlaneMap& transposed);
  // to + stencil * a; where the record is not kept, `to` is used up.
  Id AddStencil(Id a, Id to, const Stencil& stencil);
  // A response of skin whose mu_a, on the whole domain, says its weights in every pixel.
  Id Convolve(Id a, Id mu_a, Convolver& convolver, const ResponseWeights& weights);
  // `out`, which the caller filled, changes by `slope` times the change of `a` in this region of it.
  void Follows(Id out, Id a, Id slope, const Region& region);

  // Backwards: from `weights` of one plane to the derivatives of their product by `inputs`, in this order.
  void Transpose(Id of, const PlaneF& weights, std::span<const Id> inputs, std::span<PlaneF> derivatives);
  // Forwards: from changes of `inputs` (an empty plane: none) to the change of one plane.
  void Tangent(std::span<const Id> inputs, std::span<const PlaneF> changes, Id of, PlaneF& change);

 private:
  enum class Kind {
    kProducts,
    kWeighted,
    kSum,
    kScale,
    kExponential,
    kGeometric,
    kBlur,
    kToSpectrum,
    kFromSpectrum,
    kMap,
    kStencil,
    kConvolve,
    kFollows
  };
  struct Operation {
    Kind kind;
    Id out;
    int first, count;      // of operands_
    float length, factor;  // of kExponential; kScale's factor
    int object;            // first of objects_, one an operand where there are any
  };

  Id NewPlane(int width, int height);
  Id Record(Kind kind, Id out, std::span<const Id> operands, float length = 0.0f, float factor = 0.0f);
  void Compute(const Operation& operation);
  // Changes of a plane or weights upon it; none where empty, zeros when first asked for.
  PlaneF& Derivative(Id id);
  void AddDerivative(Id id, const PlaneF& part);
  void AddDerivative(Id id, const PlaneF& a, const PlaneF& b);  // their product
  template <class Apply>
  void AddDerivativeBy(Id id, const Apply& apply);
  bool Has(Id id) const { return !derivatives_[id].empty(); }
  void ClearDerivatives();
  void ApplyLinear(const Operation& operation, bool transposed, int operand, const PlaneF& in, PlaneF& out);
  SeparableBlur& BlurOf(const Operation& operation) {
    return operation.factor > 0.0f ? mirrored_blur_ : blur_;
  }
  Id Operand(const Operation& operation, int i) const { return operands_[operation.first + i]; }
  void Backward(const Operation& operation);
  void Forward(const Operation& operation);
  PlaneF TakePlane(int width, int height);
  void GivePlane(PlaneF&& plane);

  SeparableBlur blur_, mirrored_blur_;
  StencilRunner stencils_;
  bool keep_ = true;
  std::deque<PlaneF> values_, derivatives_;  // of which the first count_ are in use
  Id count_ = 0;
  std::vector<Id> listed_;  // scratch
  std::vector<Operation> operations_;
  std::vector<Id> operands_;
  // What an operation works with: a kernel, a plane of weights, a transform, a map and its transpose, ...
  struct Object {
    const PlaneF* weight = nullptr;
    const SymmetricKernel* kernel = nullptr;
    const Stencil* stencil = nullptr;
    CosineTransform* transform = nullptr;
    PlaneMap *map = nullptr, *transposed = nullptr;
    Convolver* convolver = nullptr;
    const ResponseWeights* weights = nullptr;
    Region region{};
  };
  std::vector<Object> objects_;
  std::map<std::pair<int, int>, std::vector<PlaneF>> free_;  // planes by shape
};

}  // namespace dermap
