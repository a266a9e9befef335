// SPDX-License-Identifier: Apache-2.0
// Spectralon and black frames of an earlier session, taken over by a new one.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acquire/devices/camera.h"
#include "common/files/session.h"

namespace dermap {

class ReferenceSession {
 public:
  // Throws InputError where the session is not complete, damaged, of another camera or wheel than `rig`, or
  // younger than this machine's clock allows.
  ReferenceSession(const std::filesystem::path& directory, const RigConfig& rig);
  // Its frame for a place in the new schedule: same role, slot, filter, exposure and ISO; each is given once.
  // Throws InputError where it has none.
  FrameRecord Find(const FrameRecord& planned);
  RawFrame Read(const FrameRecord& frame) const;
  const std::vector<ExposureChange>& exposure_changes() const { return session_.exposure_changes; }
  double age_h() const { return age_h_; }
  const std::filesystem::path& directory() const { return session_.directory; }

 private:
  Session session_;
  std::vector<bool> given_;
  double age_h_ = 0.0;
};

// Hours from one ISO 8601 time to another; nothing where one of them is none.
std::optional<double> HoursBetween(const std::string& from_utc, const std::string& to_utc);

// Throws InputError where this machine's clock stands before `past_utc`, a time at which `what` ("this
// session was begun"); by less than two minutes is let pass. What is no time is let pass too.
void RequireClockBeyond(const std::string& past_utc, const std::string& what);

}  // namespace dermap
