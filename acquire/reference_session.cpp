// SPDX-License-Identifier: Apache-2.0
// Matching frames by what they are, not by their number.
#include "acquire/reference_session.h"

#include <cmath>
#include <ctime>

#include "acquire/session_folder.h"
#include "common/core/error.h"
#include "common/files/atomic_file.h"

namespace dermap {
namespace {

constexpr double kClockTolerance_h = 2.0 / 60.0;  // a clock that is set by the network goes back a little

std::optional<std::time_t> Seconds(const std::string& utc) {
  std::tm time{};
  if (strptime(utc.c_str(), "%Y-%m-%dT%H:%M:%S", &time) == nullptr) return std::nullopt;
  return timegm(&time);
}

void RequireSame(const std::string& what, const std::string& here, const std::string& there) {
  if (here == there) return;
  throw InputError("the reference session was taken with the " + what + " '" + there + "', this rig has '" +
                   here + "'; remedy: name a session of this rig");
}

bool SameSetting(const FrameRecord& a, const FrameRecord& b) {
  return a.role == b.role && a.slot == b.slot && a.wavelength_nm == b.wavelength_nm &&
         a.fwhm_nm == b.fwhm_nm && a.exposure_ms == b.exposure_ms && a.iso == b.iso;
}

}  // namespace

std::optional<double> HoursBetween(const std::string& from_utc, const std::string& to_utc) {
  const auto from = Seconds(from_utc), to = Seconds(to_utc);
  if (!from || !to) return std::nullopt;
  return std::difftime(*to, *from) / 3600.0;
}

void RequireClockBeyond(const std::string& past_utc, const std::string& what) {
  const auto age_h = HoursBetween(past_utc, NowUtc());
  if (!age_h || *age_h >= -kClockTolerance_h) return;
  throw InputError("this machine's clock stands at " + NowUtc() + ", before " + past_utc + ", when " + what +
                   "; remedy: set the clock");
}

ReferenceSession::ReferenceSession(const std::filesystem::path& directory, const RigConfig& rig)
    : session_(ReadSession(directory)), given_(session_.frames.size()) {
  if (!session_.complete) {
    throw InputError(directory.string() + " is not complete; remedy: go on with it by --resume first");
  }
  RequireSame("rig", rig.name, session_.rig.name);
  RequireSame("camera driver", rig.camera_driver, session_.rig.camera_driver);
  RequireSame("wheel driver", rig.wheel_driver, session_.rig.wheel_driver);
  VerifyFrames(session_);
  RequireClockBeyond(session_.started_utc, "the reference session " + directory.string() + " was begun");
  age_h_ = HoursBetween(session_.started_utc, NowUtc()).value_or(0.0);
}

FrameRecord ReferenceSession::Find(const FrameRecord& planned) {
  for (std::size_t i = 0; i < session_.frames.size(); ++i) {
    if (given_[i] || !SameSetting(session_.frames[i], planned)) continue;
    given_[i] = true;
    return session_.frames[i];
  }
  throw InputError(session_.directory.string() + " has no frame for " + DescribeFrame(planned) + " at " +
                   std::to_string(std::lround(planned.exposure_ms)) + " ms and ISO " +
                   std::to_string(planned.iso) + "; remedy: capture without --reference");
}

RawFrame ReferenceSession::Read(const FrameRecord& frame) const {
  RawFrame raw;
  raw.bytes = ReadBinaryFile(session_.directory / frame.file);
  raw.extension = std::filesystem::path(frame.file).extension().string();
  return raw;
}

}  // namespace dermap
