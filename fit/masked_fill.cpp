// SPDX-License-Identifier: Apache-2.0
// Filling masked pixels ring by ring; the order is found once and used in every iteration.
#include "fit/masked_fill.h"

#include <algorithm>
#include <cassert>

namespace dermap {

MaskedFill::MaskedFill(const Plane<std::uint8_t>& known) {
  const int width = known.width(), height = known.height();
  Plane<std::uint8_t> filled = known;
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < known.size(); ++i)
    if (!known.data()[i]) open.push_back(i);
  assert(open.size() < known.size());
  while (!open.empty()) {
    const std::size_t ring_begin = targets_.size();
    for (std::size_t pixel : open) {
      const int x = static_cast<int>(pixel % width), y = static_cast<int>(pixel / width);
      const int begin = static_cast<int>(sources_.size());
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height - 1); ++v)
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u)
          if (filled(u, v)) sources_.push_back(static_cast<std::size_t>(v) * width + u);
      const int end = static_cast<int>(sources_.size());
      if (end > begin) targets_.push_back({pixel, begin, end});
    }
    for (std::size_t t = ring_begin; t < targets_.size(); ++t) filled.data()[targets_[t].pixel] = 1;
    std::erase_if(open, [&](std::size_t pixel) { return filled.data()[pixel] != 0; });
  }
}

void MaskedFill::Apply(ParameterMaps& maps) const {
  for (PlaneF& plane : maps.planes) Fill(plane);
  for (PlaneF& plane : maps.junction_absorbance) Fill(plane);
}

void MaskedFill::Fill(PlaneF& plane) const {
  for (const Target& target : targets_) {
    double sum = 0.0;
    for (int s = target.begin; s < target.end; ++s) sum += plane.data()[sources_[s]];
    plane.data()[target.pixel] = static_cast<float>(sum / (target.end - target.begin));
  }
}

}  // namespace dermap
