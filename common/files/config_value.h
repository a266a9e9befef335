// SPDX-License-Identifier: Apache-2.0
// Within this folder: a parsed configuration value with the line it stands on, whatever the syntax it came
// from.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

namespace dermap {

struct ConfigValue {
  using Array = std::vector<ConfigValue>;
  using Table = std::map<std::string, ConfigValue>;
  struct Other {
    std::string description;  // a date, null: nothing of ours is one
  };

  int line = 0;  // counts from 1; 0 where the syntax has no lines worth naming
  std::variant<Other, bool, std::int64_t, double, std::string, Array, Table> value;
};

}  // namespace dermap
