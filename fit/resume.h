// SPDX-License-Identifier: Apache-2.0
// Going on with a fit that was interrupted.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "common/files/stack.h"
#include "common/tissue/parameters.h"

namespace dermap {

struct FitOptions;

// What decides a fit, as names and values for people: data, method, model. How it was started or how long it
// may take is not in it.
using SettingList = std::vector<std::pair<std::string, std::string>>;
SettingList SettingsOf(const ReflectanceStack& stack, const FitOptions& options);

struct UnfinishedFit {
  std::filesystem::path directory;
  ParameterMaps maps;
  SettingList settings;
  double seconds = 0.0;  // that it took so far
  int renders = 0;
};

// A fit folder whose fit.json says that it is not finished. Throws InputError where there is none, where it
// is finished, or where a file is damaged.
UnfinishedFit ReadUnfinishedFit(const std::filesystem::path& directory);

// Pixels along the longer side of its maps. Throws InputError where another size is asked for, or the stack,
// `longer`, is smaller.
int SizeToResume(const UnfinishedFit& before, const FitOptions& options, int longer);

// Throws InputError that names the first setting that differs.
void CheckSameSettings(const UnfinishedFit& before, const SettingList& now);

}  // namespace dermap
