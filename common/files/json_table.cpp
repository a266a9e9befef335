// SPDX-License-Identifier: Apache-2.0
// From JSON text to configuration values, with nlohmann json.
#include "common/files/json_table.h"

#include <limits>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/config_value.h"
#include "common/files/text.h"

namespace dermap {
namespace {

constexpr int kDeepestNesting = 32;  // ours is 4; a hostile file must not exhaust the stack

ConfigValue FromJson(const nlohmann::json& json, int depth) {
  ConfigValue result;
  if (depth > kDeepestNesting) {
    result.value = ConfigValue::Other{"nested too deeply"};
  } else if (json.is_object()) {
    ConfigValue::Table entries;
    for (const auto& [key, child] : json.items()) entries.emplace(key, FromJson(child, depth + 1));
    result.value = std::move(entries);
  } else if (json.is_array()) {
    ConfigValue::Array items;
    for (const auto& child : json) items.push_back(FromJson(child, depth + 1));
    result.value = std::move(items);
  } else if (json.is_string()) {
    result.value = json.get<std::string>();
  } else if (json.is_boolean()) {
    result.value = json.get<bool>();
  } else if (json.is_number_unsigned() &&
             json.get<std::uint64_t>() > std::uint64_t{std::numeric_limits<std::int64_t>::max()}) {
    result.value = json.get<double>();
  } else if (json.is_number_integer()) {
    result.value = json.get<std::int64_t>();
  } else if (json.is_number()) {
    result.value = json.get<double>();
  } else {
    result.value = ConfigValue::Other{"null"};
  }
  return result;
}

}  // namespace

TomlTable ReadJsonTable(const std::filesystem::path& path) {
  const std::string text = ReadTextFile(path);
  nlohmann::json json;
  try {
    json = nlohmann::json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    throw InputError(path.string() + " is not valid JSON (byte " + std::to_string(error.byte) + " of " +
                     std::to_string(text.size()) + "); remedy: restore the file from a copy");
  } catch (const nlohmann::json::out_of_range&) {
    throw InputError(
        path.string() +
        " holds a number beyond 1.8e308; expected numbers as they were written; remedy: restore the "
        "file from a copy");
  }
  return ToTable(json, path.string());
}

TomlTable ToTable(const nlohmann::json& json, const std::string& where) {
  if (!json.is_object()) {
    throw InputError(where + " holds JSON of type " + std::string(json.type_name()) + "; expected an object");
  }
  return TomlTable(where, "", FromJson(json, 0));
}

}  // namespace dermap
