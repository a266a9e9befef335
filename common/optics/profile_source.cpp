// SPDX-License-Identifier: Apache-2.0
// The register of profile sources, by the name that --profiles takes.
#include "common/optics/profile_source.h"

#include <spdlog/fmt/fmt.h>

#include "common/core/error.h"
#include "common/optics/exact_profile_source.h"
#include "common/optics/multipole.h"

namespace dermap {
namespace {

struct Registered {
  const char* name;
  std::unique_ptr<ProfileSource> (*make)();
};

constexpr Registered kSources[] = {
    {"exact", []() -> std::unique_ptr<ProfileSource> { return std::make_unique<ExactProfileSource>(); }},
    {"multipole", [] { return MakeMultipoleSource(MultipoleDirections::kOwn); }},
    {"multipole-symmetric", [] { return MakeMultipoleSource(MultipoleDirections::kSymmetric); }},
};

}  // namespace

std::unique_ptr<ProfileSource> MakeProfileSource(std::string_view name) {
  for (const auto& source : kSources) {
    if (name == source.name) return source.make();
  }
  throw InputError(fmt::format("There are no profiles called '{}'; choose one of: {}.", name,
                               fmt::join(ProfileSourceNames(), ", ")));
}

const std::vector<std::string>& ProfileSourceNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const auto& source : kSources) list.emplace_back(source.name);
    return list;
  }();
  return names;
}

}  // namespace dermap
