// SPDX-License-Identifier: Apache-2.0
// The frame of a long study: points measured one after another, each on disk before the next begins, so that
// a run that was broken off goes on where it was.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/core/progress.h"

namespace dermap {

struct PlannedPoint {
  std::string key;    // names the point in the journal; each once
  double cost = 1.0;  // relative to the others, for the time left
  std::function<nlohmann::json()> measure;
};

struct PointRun {
  std::filesystem::path journal;
  std::vector<nlohmann::json> records;  // in the order of the plan
  int measured = 0, resumed = 0;        // now; taken over from an earlier run
};

// FOLDER/NAME.journal.jsonl: the settings, then a line a point. A journal of the same settings is gone on
// with by itself; points of it that the plan lacks are left out. One of other settings is an InputError:
// points of two settings are no study. Throws StorageError for a folder that cannot be made or written to.
PointRun RunPoints(const std::filesystem::path& folder, const std::string& name,
                   const nlohmann::json& settings, const std::vector<PlannedPoint>& plan,
                   const ProgressFunction& progress);

// Hands every record to `read`; one that it cannot read (nlohmann::json::exception) is an InputError that
// names the journal: another version wrote it.
void ReadRecords(const PointRun& run, const std::function<void(const nlohmann::json&)>& read);

// A record's number; NaN, which JSON does not know, is written as null.
double NumberOrNaN(const nlohmann::json& at);

// "AMD EPYC 7B13, 2 threads" (those that may work): what times were measured on; "unknown processor" where
// the system does not say.
std::string MachineName();

}  // namespace dermap
