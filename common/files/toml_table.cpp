// SPDX-License-Identifier: Apache-2.0
// Typed, checked access to one configuration table.
#include "common/files/toml_table.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <set>

#include "common/core/error.h"
#include "common/files/config_value.h"
#include "common/files/text.h"

namespace dermap {
namespace {

std::string Describe(const ConfigValue& value) {
  struct Visitor {
    std::string operator()(const ConfigValue::Other& other) const { return other.description; }
    std::string operator()(bool b) const { return b ? "true" : "false"; }
    std::string operator()(std::int64_t i) const { return std::to_string(i); }
    std::string operator()(double d) const { return FormatNumber(d); }
    std::string operator()(const std::string& s) const { return "the text \"" + Shorten(s, 60) + "\""; }
    std::string operator()(const ConfigValue::Array& a) const {
      return "a list of " + std::to_string(a.size()) + (a.size() == 1 ? " value" : " values");
    }
    std::string operator()(const ConfigValue::Table&) const { return "a table"; }
  };
  return std::visit(Visitor{}, value.value);
}

std::optional<double> AsNumber(const ConfigValue& value) {
  if (const auto* d = std::get_if<double>(&value.value)) return *d;
  if (const auto* i = std::get_if<std::int64_t>(&value.value)) return static_cast<double>(*i);
  return std::nullopt;
}

std::string RangeText(double lower, double upper) {
  constexpr double kUnbounded = std::numeric_limits<double>::max();
  if (lower <= -kUnbounded && upper >= kUnbounded) return "";
  if (upper >= kUnbounded) return " of at least " + FormatNumber(lower);
  if (lower <= -kUnbounded) return " of at most " + FormatNumber(upper);
  return " from " + FormatNumber(lower) + " to " + FormatNumber(upper);
}

// The known key that somebody who wrote `unknown` most likely meant: few typing errors, or a unit left out.
std::string NearestKey(const std::string& unknown, const std::set<std::string>& known) {
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(2, unknown.size() / 3) + 1;
  for (const std::string& key : known) {
    std::size_t distance = EditDistance(unknown, key);
    if (key.starts_with(unknown + "_") || unknown.starts_with(key + "_"))
      distance = std::min<std::size_t>(distance, 1);
    if (distance < best_distance) {
      best = key;
      best_distance = distance;
    }
  }
  return best;
}

}  // namespace

struct TomlTable::Impl {
  std::string file;
  std::string name;  // "camera", "wheel.slot[2]"; empty for the whole file
  int line = 0;
  ConfigValue::Table values;
  std::set<std::string> known;

  std::string KeyName(const std::string& key) const { return name.empty() ? key : name + "." + key; }

  std::string Where(const std::string& key) const {
    const auto found = values.find(key);
    const int at = found != values.end() ? found->second.line : line;
    return at > 0 ? file + " line " + std::to_string(at) : file;
  }

  const ConfigValue* Find(const std::string& key) {
    known.insert(key);
    const auto found = values.find(key);
    return found == values.end() ? nullptr : &found->second;
  }

  const ConfigValue& Require(const std::string& key, const std::string& expected) {
    if (const ConfigValue* value = Find(key)) return *value;
    throw InputError(Where(key) + ": the key '" + KeyName(key) + "' is missing; remedy: add it, " + expected);
  }

  [[noreturn]] void Reject(const std::string& key, const ConfigValue& value,
                           const std::string& expected) const {
    throw InputError(Where(key) + ": '" + KeyName(key) + "' is " + Describe(value) + "; expected " +
                     expected);
  }

  double CheckNumber(const std::string& key, const ConfigValue& value, double lower, double upper) const {
    const std::optional<double> number = AsNumber(value);
    if (!number || !std::isfinite(*number) || *number < lower || *number > upper) {
      Reject(key, value, "a number" + RangeText(lower, upper));
    }
    return *number;
  }

  int CheckInteger(const std::string& key, const ConfigValue& value, int lower, int upper) const {
    const auto* integer = std::get_if<std::int64_t>(&value.value);
    if (!integer || *integer < lower || *integer > upper)
      Reject(key, value, "an integer" + RangeText(lower, upper));
    return static_cast<int>(*integer);
  }
};

TomlTable::TomlTable(std::string file, std::string name, const ConfigValue& value)
    : impl_(std::make_unique<Impl>()) {
  assert(std::holds_alternative<ConfigValue::Table>(value.value));
  impl_->file = std::move(file);
  impl_->name = std::move(name);
  impl_->line = value.line;
  impl_->values = std::get<ConfigValue::Table>(value.value);
}

TomlTable::TomlTable(TomlTable&&) noexcept = default;
TomlTable& TomlTable::operator=(TomlTable&&) noexcept = default;
TomlTable::~TomlTable() = default;

bool TomlTable::Has(const std::string& key) const {
  return impl_->values.contains(key);
}

std::string TomlTable::Where(const std::string& key) const {
  return impl_->Where(key);
}

double TomlTable::Number(const std::string& key, double fallback, double lower, double upper) {
  const ConfigValue* value = impl_->Find(key);
  return value ? impl_->CheckNumber(key, *value, lower, upper) : fallback;
}

double TomlTable::RequiredNumber(const std::string& key, double lower, double upper) {
  return impl_->CheckNumber(key, impl_->Require(key, "a number" + RangeText(lower, upper)), lower, upper);
}

int TomlTable::Integer(const std::string& key, int fallback, int lower, int upper) {
  const ConfigValue* value = impl_->Find(key);
  return value ? impl_->CheckInteger(key, *value, lower, upper) : fallback;
}

int TomlTable::RequiredInteger(const std::string& key, int lower, int upper) {
  return impl_->CheckInteger(key, impl_->Require(key, "an integer" + RangeText(lower, upper)), lower, upper);
}

bool TomlTable::Boolean(const std::string& key, bool fallback) {
  const ConfigValue* value = impl_->Find(key);
  if (!value) return fallback;
  const bool* boolean = std::get_if<bool>(&value->value);
  if (!boolean) impl_->Reject(key, *value, "true or false");
  return *boolean;
}

std::string TomlTable::String(const std::string& key, const std::string& fallback) {
  return impl_->Find(key) ? RequiredString(key) : fallback;
}

std::string TomlTable::RequiredString(const std::string& key) {
  const ConfigValue& value = impl_->Require(key, "a text in quotes");
  const auto* text = std::get_if<std::string>(&value.value);
  if (!text) impl_->Reject(key, value, "a text in quotes");
  return *text;
}

std::vector<double> TomlTable::Numbers(const std::string& key, const std::vector<double>& fallback) {
  const ConfigValue* value = impl_->Find(key);
  if (!value) return fallback;
  const auto* array = std::get_if<ConfigValue::Array>(&value->value);
  if (!array) impl_->Reject(key, *value, "a list of numbers");
  std::vector<double> numbers;
  for (const ConfigValue& item : *array) {
    const std::optional<double> number = AsNumber(item);
    if (!number || !std::isfinite(*number)) {
      throw InputError(impl_->Where(key) + ": '" + impl_->KeyName(key) + "' holds " + Describe(item) +
                       "; expected a list of finite numbers");
    }
    numbers.push_back(*number);
  }
  return numbers;
}

std::optional<TomlTable> TomlTable::Table(const std::string& key) {
  const ConfigValue* value = impl_->Find(key);
  if (!value) return std::nullopt;
  if (!std::holds_alternative<ConfigValue::Table>(value->value)) {
    impl_->Reject(key, *value, "a table, [" + impl_->KeyName(key) + "]");
  }
  return TomlTable(impl_->file, impl_->KeyName(key), *value);
}

std::vector<TomlTable> TomlTable::Tables(const std::string& key) {
  std::vector<TomlTable> tables;
  const ConfigValue* value = impl_->Find(key);
  if (!value) return tables;
  const std::string expected = "a list of tables, [[" + impl_->KeyName(key) + "]]";
  const auto* array = std::get_if<ConfigValue::Array>(&value->value);
  if (!array) impl_->Reject(key, *value, expected);
  for (const ConfigValue& item : *array) {
    if (!std::holds_alternative<ConfigValue::Table>(item.value)) impl_->Reject(key, *value, expected);
    const std::string name = impl_->KeyName(key) + "[" + std::to_string(tables.size() + 1) + "]";
    tables.emplace_back(impl_->file, name, item);
  }
  return tables;
}

void TomlTable::Finish() const {
  for (const auto& [key, value] : impl_->values) {
    if (impl_->known.contains(key)) continue;
    const std::string nearest = NearestKey(key, impl_->known);
    std::string message = "unknown key '" + Shorten(impl_->KeyName(key), 80) + "' in " + impl_->Where(key);
    if (!nearest.empty()) {
      message += "; did you mean '" + nearest + "'?";
    } else if (!impl_->known.empty()) {
      message += "; known here: " + Join(impl_->known, ", ");
    }
    throw InputError(message);
  }
}

}  // namespace dermap
