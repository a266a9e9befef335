// SPDX-License-Identifier: Apache-2.0
// Cached tables: found by what they are made of, and never believed when damaged.
#include "common/optics/table_cache.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "common/optics/sampled_source.h"

namespace dermap {
namespace {

BandTables SomeTables(float value) {
  BandTables tables;
  tables.wavelength_nm = 560.0;
  for (ProfileTable* table :
       {&tables.r1_forward, &tables.t1_forward, &tables.t1_ballistic, &tables.r1_backward,
        &tables.t1_backward, &tables.r1_backward_black, &tables.r2_diffuse, &tables.r2_normal}) {
    std::vector<GaussianWeights> entries(kTableSize);
    for (int i = 0; i < kTableSize; ++i) entries[i].fill(value + 0.001f * static_cast<float>(i));
    const std::size_t paths =
        table == &tables.t1_ballistic ? 0 : TableFrequencies_per_mm().size() * kTableSize;
    *table = ProfileTable(entries, TransformTable(std::vector<float>(paths, value)));
    value += 1.0f;
  }
  return tables;
}

class TableCacheTest : public ::testing::Test {
 protected:
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("dermap-cache-test-" + std::to_string(getpid()));
  TableCache cache_{folder_};
  std::string recipe_ = TableCache::Recipe("exact", 560.0, TissueConfig{});
  void TearDown() override { std::filesystem::remove_all(folder_); }
};

// Source: what was stored.
TEST_F(TableCacheTest, ReturnsWhatWasStored) {
  EXPECT_FALSE(cache_.Load(recipe_).has_value());
  const BandTables stored = SomeTables(0.5f);
  cache_.Store(recipe_, stored);
  const auto loaded = cache_.Load(recipe_);
  ASSERT_TRUE(loaded.has_value());
  EXPECT_EQ(loaded->wavelength_nm, 560.0);
  EXPECT_EQ(loaded->r2_normal.entries(), stored.r2_normal.entries());
  EXPECT_EQ(loaded->r1_forward.entries(), stored.r1_forward.entries());
  EXPECT_EQ(loaded->r2_diffuse.transforms().values(), stored.r2_diffuse.transforms().values());
}

// Source: the definition of a damaged file: any byte changed, any length cut, anything appended.
TEST_F(TableCacheTest, DamagedFilesAreAsGoodAsNone) {
  cache_.Store(recipe_, SomeTables(0.5f));
  const auto path = cache_.PathOf(recipe_);
  std::ifstream file(path, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const auto write = [&](const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; };
  for (const std::size_t at : {std::size_t{0}, std::size_t{30}, whole.size() / 2, whole.size() - 1}) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    write(damaged);
    EXPECT_FALSE(cache_.Load(recipe_).has_value()) << at;
    write(whole.substr(0, at));
    EXPECT_FALSE(cache_.Load(recipe_).has_value()) << at;
  }
  write(whole + "x");
  EXPECT_FALSE(cache_.Load(recipe_).has_value());
  write(whole);
  EXPECT_TRUE(cache_.Load(recipe_).has_value());
}

// Source: what the tables depend on, and what not.
TEST_F(TableCacheTest, RecipesDifferWhereTablesDo) {
  TissueConfig other;
  other.epidermis_thickness_mm = 0.1;
  EXPECT_NE(TableCache::Recipe("exact", 560.0, other), recipe_);
  EXPECT_NE(TableCache::Recipe("exact", 561.0, {}), recipe_);
  EXPECT_NE(TableCache::Recipe("multipole", 560.0, {}), recipe_);
  TissueConfig same;
  same.junction_absorbance = 0.3;
  same.oxygenation_dermis = 0.5;
  EXPECT_EQ(TableCache::Recipe("exact", 560.0, same), recipe_);
}

// A folder that cannot be made is no error. Source: a cache may fail.
TEST_F(TableCacheTest, SurvivesAFolderThatCannotBe) {
  std::ofstream(folder_) << "a file, not a folder";
  EXPECT_NO_THROW(cache_.Store(recipe_, SomeTables(0.1f)));
  EXPECT_FALSE(cache_.Load(recipe_).has_value());
}

}  // namespace
}  // namespace dermap
