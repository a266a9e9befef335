// SPDX-License-Identifier: Apache-2.0
// Names of spectral channels: PREFIX.NUMBERUNIT, comma as the decimal sign [Fichet, Pacanowski, Wilkie, JCGT
// 2021].
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include "common/files/stack.h"

namespace dermap {
namespace {

constexpr double kLightNmHz = 2.99792458e17;  // speed of light, nm/s (exact, SI)

struct Multiplier {
  std::string_view prefix;
  double factor;
};
// The layout's SI prefixes.
constexpr std::array<Multiplier, 16> kMultipliers{{{"Y", 1e24},
                                                   {"Z", 1e21},
                                                   {"E", 1e18},
                                                   {"P", 1e15},
                                                   {"T", 1e12},
                                                   {"G", 1e9},
                                                   {"M", 1e6},
                                                   {"k", 1e3},
                                                   {"h", 1e2},
                                                   {"da", 1e1},
                                                   {"d", 1e-1},
                                                   {"c", 1e-2},
                                                   {"m", 1e-3},
                                                   {"u", 1e-6},
                                                   {"n", 1e-9},
                                                   {"p", 1e-12}}};

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

// Takes a number off the front of `text`; a point is read like the layout's comma.
std::optional<double> TakeNumber(std::string_view& text) {
  std::string number;
  std::size_t i = 0;
  for (; i < text.size() && (IsDigit(text[i]) || text[i] == ',' || text[i] == '.'); ++i) {
    number += text[i] == ',' ? '.' : text[i];
  }
  if (i + 1 < text.size() && (text[i] == 'e' || text[i] == 'E')) {
    const std::size_t digit = text[i + 1] == '+' || text[i + 1] == '-' ? i + 2 : i + 1;
    if (digit < text.size() && IsDigit(text[digit])) {
      number += 'e';
      if (text[i + 1] == '-') number += '-';
      for (i = digit; i < text.size() && IsDigit(text[i]); ++i) number += text[i];
    }
  }
  double value = 0.0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
  if (error != std::errc{} || end != number.data() + number.size()) return std::nullopt;
  text.remove_prefix(i);
  return value;
}

}  // namespace

std::string SpectralChannelName(const std::string& prefix, double wavelength_nm) {
  std::string number = fmt::format("{:.6f}", wavelength_nm);
  std::replace(number.begin(), number.end(), '.', ',');
  return fmt::format("{}.{}nm", prefix, number);
}

std::optional<double> WavelengthOfChannel(const std::string& name, const std::string& prefix) {
  if (name.size() <= prefix.size() || !name.starts_with(prefix) || name[prefix.size()] != '.')
    return std::nullopt;
  std::string_view rest = std::string_view(name).substr(prefix.size() + 1);
  const std::optional<double> number = TakeNumber(rest);
  if (!number) return std::nullopt;
  const bool frequency = rest.ends_with("Hz");
  if (!frequency && !rest.ends_with("m")) return std::nullopt;
  rest.remove_suffix(frequency ? 2 : 1);
  double factor = 1.0;
  if (!rest.empty()) {
    const auto found = std::find_if(kMultipliers.begin(), kMultipliers.end(),
                                    [&](const Multiplier& m) { return m.prefix == rest; });
    if (found == kMultipliers.end()) return std::nullopt;
    factor = found->factor;
  }
  const double nm = frequency ? kLightNmHz / (*number * factor) : *number * (factor * 1e9);
  if (!std::isfinite(nm) || nm <= 0.0) return std::nullopt;
  return nm;
}

}  // namespace dermap
