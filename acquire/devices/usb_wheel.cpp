// SPDX-License-Identifier: Apache-2.0
// Moving until it stands, and coming back from a lost connection.
#include "acquire/devices/usb_wheel.h"

#include <spdlog/spdlog.h>

#include <optional>
#include <thread>

#include "acquire/devices/device_fault.h"

namespace dermap {
namespace {

constexpr int kAttempts = 3;
constexpr int kAttemptsWhenStuck = 2;  // each takes as long as a whole turn

}  // namespace

UsbWheel::UsbWheel(std::unique_ptr<WheelProtocol> protocol, const WheelTiming& timing)
    : protocol_(std::move(protocol)), timing_(timing), link_(protocol_->Name(), protocol_->Id()) {}

void UsbWheel::Connect() {
  link_.Open(timing_.plug_in);
  slot_count_ = protocol_->Begin(link_, timing_);
}

int UsbWheel::SlotCount() const {
  return slot_count_;
}

void UsbWheel::MoveOnce(int slot) {
  if (!link_.is_open()) Connect();
  if (slot < 1 || slot > slot_count_) {
    throw DeviceFault(FaultKind::kSettings, Name() + ": slot " + std::to_string(slot) +
                                                " was asked for, it has 1 to " + std::to_string(slot_count_) +
                                                "; remedy: correct the slots of the rig");
  }
  protocol_->StartMove(link_, slot, timing_);
  const auto limit = timing_.answer + slot_count_ * timing_.per_slot;
  const auto until = std::chrono::steady_clock::now() + limit;
  int position = protocol_->Position(link_, timing_);
  while (position == 0 && std::chrono::steady_clock::now() < until) {
    std::this_thread::sleep_for(timing_.poll);
    position = protocol_->Position(link_, timing_);
  }
  if (position == slot) return;
  throw DeviceFault(FaultKind::kStuck,
                    Name() +
                        (position == 0 ? " still moves after " + std::to_string(limit.count() / 1000.0) + " s"
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
    }
  }
}

}  // namespace dermap
