// SPDX-License-Identifier: Apache-2.0
// What an emulated USB device is to the bus: descriptors, and what it does with each transfer. All calls come
// with the bus's lock held.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace dermap::emulator {

using Bytes = std::vector<std::uint8_t>;
using Clock = std::chrono::steady_clock;

struct UsbSetup {
  std::uint8_t request_type = 0;
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
  std::uint16_t length = 0;
};

struct UsbEndpoint {
  std::uint8_t address;
  std::uint8_t kind;  // 2 bulk, 3 interrupt
  std::uint16_t packet_bytes;
};

struct UsbIdentity {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::string manufacturer, name, serial;
  std::uint8_t interface_class = 0xFF, interface_subclass = 0, interface_protocol = 0;
  std::vector<UsbEndpoint> endpoints;
  int speed_mbit_s = 480;
};

inline constexpr int kStays = 1;  // a transfer's status: it stays pending, as with a device that hangs

// Where a device's answers go.
class UsbAnswers {
 public:
  virtual ~UsbAnswers() = default;
  // One transfer towards the host, taken by whatever reads from the endpoint at `when` or later.
  virtual void Answer(std::uint8_t endpoint, Bytes data, Clock::time_point when) = 0;
  virtual void DropAnswers(std::uint8_t endpoint) = 0;
};

class UsbDevice {
 public:
  virtual ~UsbDevice() = default;
  virtual UsbIdentity Identity() const = 0;
  // Each returns 0, a negative errno (-EPIPE: a stall), or kStays.
  virtual int Control(const UsbSetup& setup, std::span<const std::uint8_t> out, Bytes& in) = 0;
  virtual int Out(std::uint8_t endpoint, std::span<const std::uint8_t> data) = 0;
  // Whether reading from this endpoint stalls or hangs just now; 0 where it works.
  virtual int InState(std::uint8_t) { return 0; }
  virtual void ClearHalt(std::uint8_t) {}
  // Some bridges answer a read that has waited this long with an empty report instead of letting it wait on.
  struct Idle {
    Bytes data;
    std::chrono::milliseconds after;
  };
  virtual std::optional<Idle> WhenIdle(std::uint8_t) { return std::nullopt; }
  virtual void Attached(UsbAnswers& answers) { answers_ = &answers; }
  virtual void Detached() { answers_ = nullptr; }
  virtual void Released() {}  // the last client has closed it

  Clock::time_point held_until{};  // by another program, until then

 protected:
  void Answer(std::uint8_t endpoint, Bytes data, Clock::time_point when = Clock::now()) {
    if (answers_ != nullptr) answers_->Answer(endpoint, std::move(data), when);
  }
  void DropAnswers(std::uint8_t endpoint) {
    if (answers_ != nullptr) answers_->DropAnswers(endpoint);
  }

 private:
  UsbAnswers* answers_ = nullptr;
};

// The bytes of the device descriptor and its one configuration, as a kernel shows them.
Bytes UsbDescriptors(const UsbIdentity& identity);
// What sysfs shows of it at that address of bus 1, in umockdev's text format.
std::string SysfsEntry(const UsbIdentity& identity, int address);
// String descriptor `index` (1 manufacturer, 2 name, 3 serial; 0 the languages), empty where there is none.
Bytes UsbString(const UsbIdentity& identity, int index);

}  // namespace dermap::emulator
