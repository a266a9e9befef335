// SPDX-License-Identifier: Apache-2.0
// Finished tables on disk, found again by what they were made of; a file that is damaged is as good as none.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "common/optics/profile_table.h"

namespace dermap {

// $DERMAP_CACHE_DIR, else $XDG_CACHE_HOME/dermap, else ~/.cache/dermap; empty (no cache) where none is set.
std::filesystem::path TableCacheDirectory();

class TableCache {
 public:
  explicit TableCache(std::filesystem::path directory = TableCacheDirectory());

  // Everything that the tables depend on, as text; two tables are the same if and only if their recipes are.
  static std::string Recipe(std::string_view source, double wavelength_nm, const TissueConfig& config);

  // The same of tables that hold totals alone, without transforms.
  static std::string TotalsRecipe(std::string_view source, double wavelength_nm, const TissueConfig& config);

  // nullopt if there is none, or what is there is not whole (said in the log).
  std::optional<BandTables> Load(const std::string& recipe) const;
  // Whole or not at all. What the disk refuses is only said in the log: a cache may fail.
  void Store(const std::string& recipe, const BandTables& tables) const;
  std::filesystem::path PathOf(const std::string& recipe) const;

 private:
  std::filesystem::path directory_;
};

}  // namespace dermap
