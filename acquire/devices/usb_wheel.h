// SPDX-License-Identifier: Apache-2.0
// What both USB wheels share: a lost connection is made anew, the wheel homed and sent on, before a fault
// counts.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <string>

#include "acquire/devices/filter_wheel.h"
#include "acquire/devices/usb_link.h"

namespace dermap {

// Times of a wheel; tests shorten them.
struct WheelTiming {
  std::chrono::milliseconds plug_in{10000};  // how long it may be away before that is a fault
  std::chrono::milliseconds answer{1000};
  std::chrono::milliseconds per_slot{2000};  // of movement
  std::chrono::milliseconds poll{250};
};

// One wheel's protocol over an open link. Each may throw DeviceFault.
class WheelProtocol {
 public:
  virtual ~WheelProtocol() = default;
  virtual std::string Name() const = 0;
  virtual UsbId Id() const = 0;
  // Makes it ready after a (new) connection; returns how many slots it has.
  virtual int Begin(UsbLink& link, const WheelTiming& timing) = 0;
  virtual void StartMove(UsbLink& link, int slot, const WheelTiming& timing) = 0;
  virtual bool BeginFindsSlots() const = 0;                            // or only answers what it believes
  virtual int Position(UsbLink& link, const WheelTiming& timing) = 0;  // 0 while it moves
};

class UsbWheel : public FilterWheel {
 public:
  UsbWheel(std::unique_ptr<WheelProtocol> protocol, const WheelTiming& timing);
  std::string Name() const override { return protocol_->Name(); }
  void Connect() override;
  void Home() override { Connect(); }
  bool HomingFindsSlots() const override { return protocol_->BeginFindsSlots(); }
  int SlotCount() const override;
  void MoveTo(int slot) override;

 private:
  using Clock = std::chrono::steady_clock;
  // When a move was last seen under way, and when it was first seen at its end, both from its start.
  struct MoveTime {
    Clock::duration moving{}, standing{};
  };
  void MoveOnce(int slot);
  // Where it stands then; 0: it still moves. `took`: how long such a move took the last time, and now.
  int Move(int slot, MoveTime& took, Clock::duration limit);
  Clock::duration PauseAfter(Clock::duration elapsed, const MoveTime& last_time) const;
  std::unique_ptr<WheelProtocol> protocol_;
  WheelTiming timing_;
  UsbLink link_;
  int slot_count_ = 0;
  int stands_at_ = 0;                   // 0: unknown
  std::map<int, MoveTime> move_times_;  // by how many slots it goes on
};

// The drivers "starlight" and "thorlabs". `serial`: of the wheel, where several are attached.
std::unique_ptr<FilterWheel> MakeStarlightWheel(const std::string& serial, const WheelTiming& timing = {});
std::unique_ptr<FilterWheel> MakeThorlabsWheel(const std::string& serial, const WheelTiming& timing = {});

}  // namespace dermap
