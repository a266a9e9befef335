// SPDX-License-Identifier: Apache-2.0
// Points to the journal and from it.
#include "studies/point_journal.h"

#include <fmt/format.h>

#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "common/core/parallel.h"
#include "common/files/session_journal.h"

namespace dermap {
namespace {

std::map<std::string, nlohmann::json> Earlier(const std::filesystem::path& path,
                                              const std::vector<nlohmann::json>& lines,
                                              const nlohmann::json& settings) {
  std::map<std::string, nlohmann::json> earlier;
  if (lines.empty()) return earlier;
  const nlohmann::json found = lines.front().value("settings", nlohmann::json());
  if (found != settings)
    throw InputError(
        fmt::format("{}: holds points of the settings {}, expected {}; remedy: another folder, "
                    "or remove the journal to measure anew",
                    path.string(), found.dump(), settings.dump()));
  for (const nlohmann::json& line : lines)
    if (line.contains("key") && line.contains("record"))
      earlier[line["key"].get<std::string>()] = line["record"];
  return earlier;
}

}  // namespace

PointRun RunPoints(const std::filesystem::path& folder, const std::string& name,
                   const nlohmann::json& settings, const std::vector<PlannedPoint>& plan,
                   const ProgressFunction& progress) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw StorageError(fmt::format("cannot make the folder {}: {}; remedy: another --output", folder.string(),
                                   error.message()));
  const std::filesystem::path path = folder / (name + ".journal.jsonl");
  const std::vector<nlohmann::json> lines = ReadJournal(path);
  const auto earlier = Earlier(path, lines, settings);
  Journal journal(path);
  if (lines.empty()) journal.Append({{"settings", settings}});
  double left = 0.0, done = 0.0;
  for (const PlannedPoint& point : plan)
    if (!earlier.contains(point.key)) left += point.cost;
  PointRun run{.journal = path, .records = {}};
  for (const PlannedPoint& point : plan) {
    if (const auto found = earlier.find(point.key); found != earlier.end()) {
      run.records.push_back(found->second);
      ++run.resumed;
      continue;
    }
    run.records.push_back(point.measure());
    journal.Append({{"key", point.key}, {"record", run.records.back()}});
    ++run.measured;
    done += point.cost;
    if (progress) progress(done / left);
  }
  return run;
}

void ReadRecords(const PointRun& run, const std::function<void(const nlohmann::json&)>& read) {
  for (const nlohmann::json& record : run.records) {
    try {
      read(record);
    } catch (const nlohmann::json::exception&) {
      throw InputError(
          fmt::format("{}: holds a point that this version does not know ({}); remedy: remove the journal to "
                      "measure anew",
                      run.journal.string(), record.dump().substr(0, 80)));
    }
  }
}

double NumberOrNaN(const nlohmann::json& at) {
  return at.is_number() ? at.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::string MachineName() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  std::string name = "unknown processor";
  for (std::string line; std::getline(cpuinfo, line);) {
    if (!line.starts_with("model name")) continue;
    if (const auto colon = line.find(": "); colon != std::string::npos) name = line.substr(colon + 2);
    break;
  }
  const int threads = AllowedThreads();
  return fmt::format("{}, {} thread{}", name, threads, threads == 1 ? "" : "s");
}

}  // namespace dermap
