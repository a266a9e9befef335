// SPDX-License-Identifier: Apache-2.0
// Halving a line, and its transpose.
#include "common/transport/paths/line_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/common/transport/scenes.h"

namespace dermap {
namespace {

double Dot(const PlaneF& a, const PlaneF& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += double(a.data()[i]) * b.data()[i];
  return sum;
}

// Source: the definition of a transpose, <A x, y> = <x, A' y>, for every end, size and offset.
TEST(PlaneMap, TransposeIsTheTranspose) {
  for (const LineEnd end : {LineEnd::kZero, LineEnd::kReplicate, LineEnd::kMirror}) {
    for (const Halver halver : {Halver::kSmooth, Halver::kFlat}) {
      for (const int first : {0, -8, 4}) {
        PlaneMap map{LineMap::Halving(halver, 64, 40, first, end), LineMap::Halving(halver, 48, 24, 0, end)};
        PlaneMap transposed = map.Transposed();
        const PlaneF x = Noise(64, 48, 1, -1.0f, 1.0f), y = Noise(40, 24, 2, -1.0f, 1.0f);
        PlaneF ax, aty;
        map.Apply(x, ax);
        transposed.Apply(y, aty);
        ASSERT_EQ(ax.width(), 40);
        ASSERT_EQ(aty.height(), 48);
        EXPECT_NEAR(Dot(ax, y), Dot(x, aty), 1e-4) << static_cast<int>(end) << ' ' << first;
      }
    }
  }
}

// Source: a wave goes through a halving with the gain of its frequency (mirrored ends make waves of whole
// half periods eigenfunctions), and a constant stays.
TEST(LineMap, HalvesWavesWithTheirGain) {
  const int n = 64;
  for (const Halver halver : {Halver::kSmooth, Halver::kFlat}) {
    EXPECT_NEAR(LineMap::Gain(halver, 0.0), 1.0, 1e-6);
    EXPECT_NEAR(LineMap::Gain(halver, std::numbers::pi), 0.0, 1e-6);
    const LineMap map = LineMap::Halving(halver, n, n / 2, 0, LineEnd::kMirror);
    for (const int mode : {0, 3, 11, 20}) {
      const double omega = std::numbers::pi * mode / n;
      std::vector<float> in(n), out(n / 2);
      for (int i = 0; i < n; ++i) in[i] = static_cast<float>(std::cos(omega * (i + 0.5)));
      map.Apply(in.data(), out.data());
      for (int i = 0; i < n / 2; ++i)
        EXPECT_NEAR(out[i], LineMap::Gain(halver, omega) * std::cos(omega * (2 * i + 1)), 1e-5) << mode;
    }
  }
}

// Source: the same sparse matrix, tap by tap; loops over its regular part must do what the taps say.
TEST(LineMap, LoopsDoWhatTheTapsSay) {
  for (const int inputs : {4, 6, 16, 30, 64}) {
    for (const LineEnd end : {LineEnd::kZero, LineEnd::kReplicate, LineEnd::kMirror}) {
      const LineMap halving = LineMap::Halving(Halver::kSmooth, inputs, inputs / 2, 0, end);
      const LineMap doubling = halving.Transposed();
      for (const LineMap* map : {&halving, &doubling}) {
        for (int i = 0; i < map->inputs(); ++i) {
          std::vector<float> unit(map->inputs()), line(map->outputs());
          unit[i] = 1.0f;
          map->Apply(unit.data(), line.data());
          PlaneF column(1, map->inputs()), columns;
          column(0, i) = 1.0f;
          map->ApplyToRows(column, columns);
          for (int o = 0; o < map->outputs(); ++o) EXPECT_NEAR(line[o], columns(0, o), 1e-7f);
        }
      }
    }
  }
}

}  // namespace
}  // namespace dermap
