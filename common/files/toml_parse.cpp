// SPDX-License-Identifier: Apache-2.0
// From TOML text to configuration values, with toml++.
#include <toml++/toml.h>

#include <sstream>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/config_value.h"
#include "common/files/toml_table.h"

namespace dermap {
namespace {

ConfigValue FromToml(const toml::node& node) {
  ConfigValue result;
  result.line = static_cast<int>(node.source().begin.line);
  if (const auto* table = node.as_table()) {
    ConfigValue::Table entries;
    for (const auto& [key, child] : *table) entries.emplace(std::string(key.str()), FromToml(child));
    result.value = std::move(entries);
  } else if (const auto* array = node.as_array()) {
    ConfigValue::Array items;
    for (const auto& child : *array) items.push_back(FromToml(child));
    result.value = std::move(items);
  } else if (const auto* text = node.as_string()) {
    result.value = text->get();
  } else if (const auto* integer = node.as_integer()) {
    result.value = integer->get();
  } else if (const auto* number = node.as_floating_point()) {
    result.value = number->get();
  } else if (const auto* boolean = node.as_boolean()) {
    result.value = boolean->get();
  } else {
    result.value = ConfigValue::Other{"a date or a time"};
  }
  return result;
}

}  // namespace

TomlTable TomlTable::ReadFile(const std::filesystem::path& path) {
  const std::string text = ReadTextFile(path);
  try {
    ConfigValue root = FromToml(toml::parse(text, path.string()));
    root.line = 0;  // a key missing from the whole file has no line
    return TomlTable(path.string(), "", root);
  } catch (const toml::parse_error& error) {
    throw InputError(path.string() + " line " + std::to_string(error.source().begin.line) +
                     ": not valid TOML: " + std::string(error.description()) + "; remedy: correct that line");
  }
}

}  // namespace dermap
