// SPDX-License-Identifier: Apache-2.0
// Parameters of pixels that the data do not reach: their neighbours' mean, since light passes through them
// all the same.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/core/image.h"
#include "common/tissue/parameters.h"

namespace dermap {

class MaskedFill {
 public:
  // `known` is not 0 where a pixel is fitted; at least one must be.
  explicit MaskedFill(const Plane<std::uint8_t>& known);

  // Every masked pixel becomes the mean of those of its eight neighbours that are known or were filled a ring
  // earlier.
  void Apply(ParameterMaps& maps) const;

 private:
  void Fill(PlaneF& plane) const;

  struct Target {
    std::size_t pixel;
    int begin, end;  // in sources_
  };
  std::vector<Target> targets_;  // ring by ring inwards
  std::vector<std::size_t> sources_;
};

}  // namespace dermap
