// SPDX-License-Identifier: Apache-2.0
// One check after the other.
#include "acquire/preflight.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <system_error>
#include <utility>

#include "acquire/devices/device_fault.h"
#include "acquire/reference_session.h"
#include "common/core/error.h"

namespace dermap {
namespace {

namespace fs = std::filesystem;

constexpr double kSpareShare = 1.2;                 // of disk space, the frames themselves being 1
constexpr std::time_t kEarliestClock = 1704067200;  // 2024: a clock before it was never set

void CheckSlots(const SessionFolder& folder, const FilterWheel& wheel) {
  for (const FrameRecord& f : folder.schedule()) {
    if (f.slot <= wheel.SlotCount()) continue;
    throw InputError("the plan needs slot " + std::to_string(f.slot) + ", but the " + wheel.Name() + " has " +
                     std::to_string(wheel.SlotCount()) + "; remedy: correct the slots of the rig");
  }
}

void CheckSpace(const SessionFolder& folder, Camera& camera) {
  std::error_code error;
  const fs::path& out = folder.session().directory;
  const fs::space_info space = fs::space(out, error);
  const int missing = folder.total() - folder.done();
  const double needed = kSpareShare * static_cast<double>(camera.FrameBytes()) * missing;
  if (!error && static_cast<double>(space.available) < needed) {
    throw StorageError(out.string() + " has " + std::to_string(space.available / 1000000) +
                       " MB free, and the session needs " + std::to_string(std::lround(needed / 1e6)) +
                       " MB; remedy: free some space, then go on with --resume");
  }
  const auto room = camera.RoomForFrames();
  if (room && *room < missing) {
    throw DeviceFault(FaultKind::kFull, camera.Name() + ": its card takes " + std::to_string(*room) +
                                            " more frames, the session needs " + std::to_string(missing) +
                                            "; remedy: put an empty card into it");
  }
}

void CheckClock(const SessionFolder& folder) {
  if (std::time(nullptr) < kEarliestClock) {
    throw InputError(
        "this machine's clock stands before 2024; remedy: set it, since sessions are told apart by time");
  }
  RequireClockBeyond(folder.session().started_utc, "this session was begun");
}

void CheckSettings(const SessionFolder& folder, Camera& camera) {
  std::vector<std::pair<double, int>> seen;
  for (const FrameRecord& f : folder.schedule()) {
    const std::pair<double, int> setting{f.exposure_ms, f.iso};
    if (folder.Has(f) || std::find(seen.begin(), seen.end(), setting) != seen.end()) continue;
    seen.push_back(setting);
    camera.Check({f.exposure_ms, f.iso, f.number});
  }
}

}  // namespace

void CheckBeforeFirstFrame(const SessionFolder& folder, Station& station) {
  CheckClock(folder);
  CheckSlots(folder, station.wheel());
  CheckSpace(folder, station.camera());
  CheckSettings(folder, station.camera());
}

}  // namespace dermap
