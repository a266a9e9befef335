// SPDX-License-Identifier: Apache-2.0
// Plugging all together, and the list of faults.
#include "acquire/emulator/station.h"

#include <algorithm>
#include <array>
#include <regex>
#include <string_view>
#include <utility>

#include "common/core/error.h"

namespace dermap::emulator {
namespace {

constexpr double kSecondsPerSlot = 0.6;  // of a real wheel
constexpr std::array<std::string_view, 4> kWheelFaults{"wheel-stuck", "wheel-slip", "wheel-unplug",
                                                       "wheel-silent"};

int SlotsOf(const RigConfig& rig) {
  int slots = 0;
  for (const WheelSlot& s : rig.slots) slots = std::max(slots, s.slot);
  return slots;
}

}  // namespace

EmulatedStation::EmulatedStation(const StationOptions& o, const ProgressFunction& progress)
    : motion_(SlotsOf(o.rig), o.real_time ? kSecondsPerSlot : 0.0),
      light_(o.rig, motion_, o.real_time ? o.rig.flash_recycle_s : 0.0, progress),
      camera_([this](double ms, int iso) { return light_.Expose(ms, iso); },
              o.real_time ? CameraTiming::Real() : CameraTiming{}),
      camera_usb_(camera_),
      starlight_(motion_),
      thorlabs_(motion_),
      unplugger_(bus_) {
  if (o.wheel != "starlight" && o.wheel != "thorlabs") {
    throw InputError("there is no emulated wheel '" + o.wheel + "'; known: starlight, thorlabs");
  }
  for (const std::string& fault : o.faults) PlanFault(fault);
  motion_.on_move = [this](int move) { BefallWheel(move); };
  wheel_ = o.wheel == "starlight" ? static_cast<UsbDevice*>(&starlight_) : &thorlabs_;
  bus_.Plug(*wheel_);
  if (o.network_port) {
    network_ = std::make_unique<PtpIp>(camera_, bus_.lock(), *o.network_port);
    camera_.unplug = [this](double seconds) { network_->Drop(seconds); };
  } else {
    camera_.unplug = [this](double seconds) { unplugger_.Unplug(camera_usb_, seconds); };
    camera_.taken = [this](double seconds) {
      camera_usb_.held_until =
          Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
      unplugger_.Unplug(camera_usb_, 0.1);
    };
    bus_.Plug(camera_usb_);
  }
}

EmulatedStation::~EmulatedStation() = default;

void EmulatedStation::PlanFault(const std::string& text) {
  static const std::regex kForm(R"(([a-z-]+)@(\d{1,6})(:(\d{1,4}(\.\d{1,6})?)(x(\d{1,4}))?)?)");
  std::smatch parts;
  if (std::regex_match(text, parts, kForm)) {
    const std::string name = parts[1];
    const int count = std::stoi(parts[2]), times = parts[7].matched ? std::stoi(parts[7]) : 1;
    const double seconds = parts[4].matched ? std::stod(parts[4]) : 0.5;
    const bool is_counted = count >= 1 && times >= 1;
    if (std::find(kWheelFaults.begin(), kWheelFaults.end(), name) != kWheelFaults.end() && is_counted) {
      wheel_faults_.push_back({name, count, seconds});
      return;
    }
    if (const auto fault = EosFaultFromName(name); fault && is_counted) {
      camera_.faults.Plan({*fault, count, seconds, times});
      return;
    }
  }
  throw InputError(
      "'" + text +
      "' is no fault; expected NAME@COUNT[:SECONDS[xTIMES]], NAME one of busy, stall, hang, "
      "unplug, unplug-read, sleep, full, ram, late, missing, truncated, repeated, settings, second-client, "
      "emulator-killed, wheel-stuck, wheel-slip, wheel-unplug, wheel-silent");
}

// With the bus's lock held.
void EmulatedStation::BefallWheel(int move) {
  for (const WheelFault& fault : wheel_faults_) {
    if (fault.move != move) continue;
    if (fault.name == "wheel-stuck") motion_.stuck = true;
    if (fault.name == "wheel-slip") motion_.slip = 1;
    if (fault.name == "wheel-unplug") unplugger_.Unplug(*wheel_, fault.seconds);
    if (fault.name == "wheel-silent") starlight_.silent = thorlabs_.silent = true;
  }
}

void EmulatedStation::Place(FrameRole role) {
  const std::lock_guard lock(bus_.lock());
  light_.target = role;
}

void EmulatedStation::TurnWheel(int slot) {
  const std::lock_guard lock(bus_.lock());
  motion_.MoveTo(slot);
}

void EmulatedStation::SeeToIt() {
  const std::lock_guard lock(bus_.lock());
  const bool was_stuck = std::exchange(motion_.stuck, false);
  motion_.slip = 0;               // it finds its slots anew when it is switched off and on
  if (was_stuck) motion_.Home();  // else it would wait for its move to end, and obey nothing
  starlight_.silent = thorlabs_.silent = false;
  camera_usb_.held_until = {};
  camera_.ChangeCard();
}

int EmulatedStation::shots() {
  const std::lock_guard lock(bus_.lock());
  return camera_.shots();
}

}  // namespace dermap::emulator
