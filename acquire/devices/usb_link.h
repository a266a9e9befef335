// SPDX-License-Identifier: Apache-2.0
// One USB device, by libusb: found by vendor, product and serial number, opened as soon as it is plugged in.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace dermap {

struct UsbId {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::string serial;  // empty: any
};

struct UsbSetupOut {
  std::uint8_t request_type = 0;
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
};

struct UsbFound {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  int bus = 0;
  int address = 0;
  std::string node{};  // /dev/bus/usb/001/002
  bool readable = false, writable = false;
  bool claimed = false;  // by a program, as the system's list of drivers tells
};
// Every device on the buses.
std::vector<UsbFound> ListUsbDevices();

class UsbLink {
 public:
  // `name` begins the sentence of every fault.
  UsbLink(std::string name, UsbId id);
  ~UsbLink();

  // Opens and claims interface 0, waiting for the device to be plugged in. A kernel driver that holds it is
  // detached. Throws DeviceFault.
  void Open(std::chrono::milliseconds wait);
  bool is_open() const;
  void Close() noexcept;

  void Control(const UsbSetupOut& setup, std::span<const std::uint8_t> data, std::chrono::milliseconds limit);
  void Write(std::uint8_t endpoint, std::span<const std::uint8_t> data, std::chrono::milliseconds limit);
  // Of a bulk or an interrupt endpoint; 0 where nothing came in time.
  std::size_t Read(std::uint8_t endpoint, bool interrupt, std::span<std::uint8_t> data,
                   std::chrono::milliseconds limit);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dermap
