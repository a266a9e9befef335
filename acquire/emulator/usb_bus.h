// SPDX-License-Identifier: Apache-2.0
// A USB bus below libusb: devices in a sysfs of libumockdev's, and an answer to each request that libusb
// makes of the kernel (usbfs). Clients run with libumockdev's preload library and UMOCKDEV_DIR, which the
// constructor sets in this process's environment; the same process may be a client too.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "acquire/emulator/usb_device.h"

namespace dermap::emulator {

class UsbBus {
 public:
  UsbBus();
  ~UsbBus();  // unplugs what is plugged
  UsbBus(const UsbBus&) = delete;
  UsbBus& operator=(const UsbBus&) = delete;

  // The devices' lock: whoever changes a plugged device from outside holds it.
  std::mutex& lock();
  // The device must outlive its time on the bus. Both tell clients by a uevent; unplugging ends transfers in
  // flight.
  void Plug(UsbDevice& device);  // nothing where it is plugged already
  void Unplug(UsbDevice& device);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// "libumockdev-preload.so.0", to be preloaded into clients.
extern const char* const kPreloadLibrary;

}  // namespace dermap::emulator
