// SPDX-License-Identifier: Apache-2.0
// What a worker process answers.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <vector>

namespace dermap {

struct WorkerAnswer {
  nlohmann::json line;
  std::vector<std::byte> bytes;
};

}  // namespace dermap
