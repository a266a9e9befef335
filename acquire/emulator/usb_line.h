// SPDX-License-Identifier: Apache-2.0
// One plugged device as its clients see it: transfers in flight, transfers done, answers that wait to be
// read. Knows nothing of how requests reach it (usb_bus.cpp does that).
#pragma once

#include <deque>
#include <functional>
#include <list>
#include <map>
#include <set>

#include "acquire/emulator/usb_device.h"

namespace dermap::emulator {

// A transfer as the kernel knows it. `buffer` is the client's memory, mirrored; for control transfers it
// begins with the eight bytes of setup.
struct Transfer {
  const void* client = nullptr;
  std::uint64_t id = 0;  // the client's address of it
  int kind = 0;          // 1 interrupt, 2 control, 3 bulk
  std::uint8_t endpoint = 0;
  std::span<std::uint8_t> buffer;
  Clock::time_point since;
  int status = 0;
  int actual = 0;
  void* handle = nullptr;  // the bus's own
};

class UsbLine : public UsbAnswers {
 public:
  explicit UsbLine(UsbDevice& device);
  ~UsbLine() override;

  UsbDevice& device() { return device_; }
  bool gone() const { return gone_; }
  // 0 or an errno.
  int Claim(const void* client, unsigned interface);
  void Release(const void* client);
  void Submit(Transfer transfer);
  bool Discard(const void* client, std::uint64_t id);  // completes it as cancelled
  void Halt(unsigned endpoint) { device_.ClearHalt(static_cast<std::uint8_t>(endpoint)); }
  std::optional<Transfer> Reap(const void* client);
  bool HasDone() const { return !done_.empty(); }
  // Transfers of a client that has vanished.
  std::list<Transfer> Forget(const void* client);
  // Ends every transfer: the device has gone.
  void Disconnect();
  // Completes what can be by now; returns when to look again.
  std::optional<Clock::time_point> Pump();

  void Answer(std::uint8_t endpoint, Bytes data, Clock::time_point when) override;
  void DropAnswers(std::uint8_t endpoint) override;

 private:
  struct Waiting {
    Bytes data;
    std::size_t taken = 0;
    Clock::time_point when;
  };
  void Finish(std::list<Transfer>::iterator transfer, int status, int actual);
  void Control(std::list<Transfer>::iterator transfer);
  bool Feed(Transfer& transfer, std::optional<Clock::time_point>& next);  // true once it is complete

  UsbDevice& device_;
  UsbIdentity identity_;
  std::list<Transfer> pending_;
  std::deque<Transfer> done_;
  std::map<std::uint8_t, std::deque<Waiting>> answers_;
  const void* owner_ = nullptr;  // who has claimed the interface
  bool gone_ = false;
};

}  // namespace dermap::emulator
