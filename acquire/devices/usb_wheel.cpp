// SPDX-License-Identifier: Apache-2.0
// Moving until it stands, and coming back from a lost connection.
#include "acquire/devices/usb_wheel.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <optional>
#include <thread>
#include <utility>

#include "acquire/devices/device_fault.h"

namespace dermap {
namespace {

constexpr int kAttempts = 3;
constexpr int kAttemptsWhenStuck = 2;  // each takes as long as a whole turn
constexpr int kAsksAroundTheEnd = 4;   // of a move, from when it was last seen under way to when it was over
constexpr int kSharesOfUnknown = 8;  // a move of unknown length is asked after by eighths of its time so far
constexpr std::chrono::milliseconds kQuickestPoll{5};

}  // namespace

UsbWheel::UsbWheel(std::unique_ptr<WheelProtocol> protocol, const WheelTiming& timing)
    : protocol_(std::move(protocol)), timing_(timing), link_(protocol_->Name(), protocol_->Id()) {}

void UsbWheel::Connect() {
  link_.Open(timing_.plug_in);
  stands_at_ = 0;
  slot_count_ = protocol_->Begin(link_, timing_);
}

int UsbWheel::SlotCount() const {
  return slot_count_;
}

// A wheel is asked rarely while it turns, and often around the time at which such a move ended before: frames
// wait for it. One that is late is asked the more rarely the later it is.
UsbWheel::Clock::duration UsbWheel::PauseAfter(Clock::duration elapsed, const MoveTime& last_time) const {
  Clock::duration pause = elapsed / kSharesOfUnknown;  // none of this length was seen yet
  if (last_time.standing != Clock::duration{}) {
    if (elapsed < last_time.moving) return last_time.moving - elapsed;
    const Clock::duration late = elapsed - last_time.standing;
    pause = late < Clock::duration{} ? (last_time.standing - last_time.moving) / kAsksAroundTheEnd : late;
  }
  return std::clamp<Clock::duration>(pause, std::min(kQuickestPoll, timing_.poll), timing_.poll);
}

int UsbWheel::Move(int slot, MoveTime& took, Clock::duration limit) {
  const MoveTime last_time = std::exchange(took, {});
  const auto start = Clock::now();
  protocol_->StartMove(link_, slot, timing_);
  while (true) {
    const auto asked = Clock::now() - start;
    const int position = protocol_->Position(link_, timing_);
    took.standing = Clock::now() - start;
    if (position != 0 || asked > limit) return position;
    took.moving = asked;
    std::this_thread::sleep_for(PauseAfter(took.standing, last_time));
  }
}

void UsbWheel::MoveOnce(int slot) {
  if (!link_.is_open()) Connect();
  if (slot < 1 || slot > slot_count_) {
    throw DeviceFault(FaultKind::kSettings, Name() + ": slot " + std::to_string(slot) +
                                                " was asked for, it has 1 to " + std::to_string(slot_count_) +
                                                "; remedy: correct the slots of the rig");
  }
  const int steps = stands_at_ == 0 ? 0 : (slot - stands_at_ + slot_count_) % slot_count_;
  stands_at_ = 0;
  MoveTime took = move_times_[steps];
  const auto limit = timing_.answer + slot_count_ * timing_.per_slot;
  const int position = Move(slot, took, limit);
  if (position == slot) {
    stands_at_ = slot;
    if (steps != 0) move_times_[steps] = took;
    return;
  }
  throw DeviceFault(
      FaultKind::kStuck,
      Name() +
          (position == 0
               ? " still moves after " + std::to_string(std::chrono::duration<double>(limit).count()) + " s"
               : " stands at slot " + std::to_string(position)) +
          " on its way to slot " + std::to_string(slot) +
          "; remedy: see whether a filter or a cable blocks it, then go on");
}

void UsbWheel::MoveTo(int slot) {
  std::optional<DeviceFault> stuck;  // what a wheel that jams says afterwards is less to the point
  for (int attempt = 1;; ++attempt) {
    try {
      return MoveOnce(slot);
    } catch (const DeviceFault& fault) {
      if (fault.kind() == FaultKind::kStuck && !stuck) stuck = fault;
      const bool hopeless = fault.kind() == FaultKind::kSettings || fault.kind() == FaultKind::kNoPermission;
      // A device that has gone was open before: after waiting for it in vain there is no use in waiting
      // again.
      const bool waited = fault.kind() == FaultKind::kGone && !link_.is_open();
      link_.Close();
      if (stuck && attempt >= kAttemptsWhenStuck) throw *stuck;
      if (hopeless || waited || attempt == kAttempts) throw;
      spdlog::warn("{}; attempt {} of {}", fault.what(), attempt, kAttempts);
      // One that jams, or has gone and is waited for, has had its time.
      if (fault.kind() == FaultKind::kNoAnswer || fault.kind() == FaultKind::kInUse)
        std::this_thread::sleep_for(timing_.poll * (1 << attempt));
    }
  }
}

}  // namespace dermap
