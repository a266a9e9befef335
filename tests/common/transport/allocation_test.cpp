// SPDX-License-Identifier: Apache-2.0
// A render takes no memory once one of the same shape was made. A program of its own: every call of malloc in
// it, whosever, is counted.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>

#include "common/core/parallel.h"
#include "tests/common/transport/derivative_cases.h"
#include "tests/common/transport/scenes.h"

namespace {
std::atomic<long> allocations{0};
}

#ifndef DERMAP_SANITIZED
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  ++allocations;
  return __libc_realloc(old, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** out, std::size_t alignment, std::size_t size) {
  ++allocations;
  *out = __libc_memalign(alignment, size);
  return *out ? 0 : 12;  // ENOMEM
}
}
#endif

namespace dermap {
namespace {

const Band kBands[] = {{450.0, 0.0}, {580.0, 10.0}, {650.0, 0.0}};
using Case = DerivativeCase;

// Grids of more than 192 pixels a side are left out: their cosine transforms are OpenCV's, which takes some
// scratch each time.
const Case kCases[] = {
    {128, Illumination::kWindow, Tape::kFree, Coupling::kReciprocal, true},
    {128, Illumination::kUniform, Tape::kFree, Coupling::kGather, false},
    {64, Illumination::kWindow, Tape::kBlack, Coupling::kGather, true, BeneathTape::kMean, Engine::kPyramid},
    {64, Illumination::kUniform, Tape::kFree, Coupling::kGather, true, BeneathTape::kEdge, Engine::kCascade}};

template <class Run>
long CountIn(const Run& run) {
  const long before = allocations;
  run();
  return allocations - before;
}

class Allocations : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
#ifdef DERMAP_SANITIZED
    GTEST_SKIP() << "sanitizers have a malloc of their own";
#endif
  }
};

// Source: the promise; the first render shows that the count does count. Lists grow for two renders.
TEST_P(Allocations, AreNoneOnceRendersWereMade) {
  const ThreadLimit one(1);
  const ForwardModel model = ModelOf(GetParam(), kBands);
  ParameterMaps maps = SceneOf(GetParam());
  std::vector<PlaneF> reflectance;
  EXPECT_GT(CountIn([&] { model.Render(maps, {}, reflectance); }), 10);
  model.Render(maps, {}, reflectance);
  const PlaneF before = reflectance[1];
  maps[Parameter::kC_m](40, 40) *= 1.1f;
  EXPECT_EQ(CountIn([&] { model.Render(maps, {}, reflectance); }), 0);
  EXPECT_NE(before(40, 40), reflectance[1](40, 40));
}

// With several threads TBB hands out tasks, however many pixels there are. On a busy machine the second
// thread may first be needed in any render, and makes its renderer then: once it has, no render takes more.
TEST_P(Allocations, AreThoseOfTasksWithSeveralThreads) {
  const ThreadLimit two(2);
  const ForwardModel model = ModelOf(GetParam(), kBands);
  const ParameterMaps maps = SceneOf(GetParam());
  std::vector<PlaneF> reflectance;
  constexpr int kInARow = 6, kMostRenders = 60;
  int quiet = 0;
  for (int render = 0; render < kMostRenders && quiet < kInARow; ++render)
    quiet = CountIn([&] { model.Render(maps, {}, reflectance); }) < 20 ? quiet + 1 : 0;
  EXPECT_EQ(quiet, kInARow);
}

class TransposeAllocations : public Allocations {};

// A product with the transpose takes memory for its result, the weights that it is given and tasks only.
TEST_P(TransposeAllocations, AreItsResults) {
  const ThreadLimit one(1);
  const ForwardModel model = ModelOf(GetParam(), kBands);
  const ParameterMaps maps = SceneOf(GetParam());
  const auto weigh = [](int, const PlaneF& reflectance) { return reflectance; };
  model.Transpose(maps, weigh);
  model.Transpose(maps, weigh);
  const long results = kParameterCount + 1, weights = 3, list_and_tasks = 6;
  EXPECT_LE(CountIn([&] { model.Transpose(maps, weigh); }), results + weights + list_and_tasks);
}

INSTANTIATE_TEST_SUITE_P(Engines, Allocations, testing::ValuesIn(kCases));
// The pyramid's transpose still takes some.
INSTANTIATE_TEST_SUITE_P(Engines, TransposeAllocations, testing::Values(kCases[0], kCases[1], kCases[3]));

}  // namespace
}  // namespace dermap
