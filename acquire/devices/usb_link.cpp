// SPDX-License-Identifier: Apache-2.0
// libusb and its errors.
#include "acquire/devices/usb_link.h"

#include <libusb.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "acquire/devices/device_fault.h"

namespace dermap {
namespace {

using std::chrono::milliseconds;
using SteadyClock = std::chrono::steady_clock;

std::string NodeOf(int bus, int address) {
  char node[40];
  std::snprintf(node, sizeof node, "/dev/bus/usb/%03d/%03d", bus, address);
  return node;
}

// The system's driver "usbfs" stands for a program that has claimed the first interface.
bool IsClaimed(libusb_device* device) {
  std::uint8_t ports[8];
  const int count = libusb_get_port_numbers(device, ports, sizeof ports);
  std::string name = std::to_string(libusb_get_bus_number(device));
  for (int i = 0; i < count; ++i) name += (i == 0 ? '-' : '.') + std::to_string(ports[i]);
  std::error_code none;
  const auto driver = std::filesystem::read_symlink("/sys/bus/usb/devices/" + name + ":1.0/driver", none);
  return driver.filename() == "usbfs";
}

struct Context {
  libusb_context* value = nullptr;
  Context() {
    if (const int error = libusb_init(&value); error != 0) {
      throw DeviceFault(FaultKind::kNoAnswer, std::string("libusb does not start (") +
                                                  libusb_error_name(error) +
                                                  "); remedy: check that /dev/bus/usb and /sys are there");
    }
  }
  ~Context() { libusb_exit(value); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
};

int OnArrival(libusb_context*, libusb_device*, libusb_hotplug_event, void* arrived) {
  *static_cast<bool*>(arrived) = true;
  return 0;
}

}  // namespace

std::vector<UsbFound> ListUsbDevices() {
  const Context context;
  libusb_device** list = nullptr;
  const auto count = libusb_get_device_list(context.value, &list);
  std::vector<UsbFound> found;
  for (ssize_t i = 0; i < count; ++i) {
    libusb_device_descriptor d{};
    if (libusb_get_device_descriptor(list[i], &d) != 0) continue;
    UsbFound f;
    f.vendor = d.idVendor;
    f.product = d.idProduct;
    f.bus = libusb_get_bus_number(list[i]);
    f.address = libusb_get_device_address(list[i]);
    f.node = NodeOf(f.bus, f.address);
    f.readable = ::access(f.node.c_str(), R_OK) == 0;
    f.writable = ::access(f.node.c_str(), W_OK) == 0;
    f.claimed = IsClaimed(list[i]);
    found.push_back(f);
  }
  if (list != nullptr) libusb_free_device_list(list, 1);
  return found;
}

struct UsbLink::Impl {
  std::string name;
  UsbId id;
  std::unique_ptr<Context> context = std::make_unique<Context>();
  libusb_device_handle* handle = nullptr;

  [[noreturn]] void Throw(const char* doing, int error) const {
    FaultKind kind = FaultKind::kNoAnswer;
    std::string remedy = "switch it off and on, and check its cable";
    if (error == LIBUSB_ERROR_NO_DEVICE || error == LIBUSB_ERROR_NOT_FOUND) {
      kind = FaultKind::kGone;
      remedy = "plug it in and check its power";
    } else if (error == LIBUSB_ERROR_BUSY) {
      kind = FaultKind::kInUse;
      remedy = "end the program that holds it ('dermap devices' names it)";
    } else if (error == LIBUSB_ERROR_ACCESS) {
      kind = FaultKind::kNoPermission;
      remedy = "install the udev rule that 'dermap devices' prints, then plug it in again";
    }
    throw DeviceFault(kind,
                      name + ": cannot " + doing + " (" + libusb_error_name(error) + "); remedy: " + remedy);
  }
  void Require(const char* doing, int error) const {
    if (error < 0) Throw(doing, error);
  }

  bool SerialFits(libusb_device_handle* candidate, int index) const {
    if (id.serial.empty()) return true;
    unsigned char text[128]{};
    const int length = libusb_get_string_descriptor_ascii(candidate, static_cast<std::uint8_t>(index), text,
                                                          sizeof text - 1);
    return length > 0 && id.serial == reinterpret_cast<const char*>(text);
  }

  // 0, or why not. libusb may still list one that has gone: only claiming it tells.
  int OpenOne(libusb_device* device, int serial_index) {
    libusb_device_handle* candidate = nullptr;
    int error = libusb_open(device, &candidate);
    if (error != 0) return error;
    if (!SerialFits(candidate, serial_index)) error = LIBUSB_ERROR_NO_DEVICE;
    libusb_set_auto_detach_kernel_driver(candidate, 1);
    if (error == 0) error = libusb_claim_interface(candidate, 0);
    if (error == 0) {
      handle = candidate;
    } else {
      libusb_close(candidate);
    }
    return error;
  }

  // Looks at the buses anew, where news of them may have been lost.
  void Renew() {
    context.reset();
    context = std::make_unique<Context>();
  }

  // 0, or why the last candidate could not be opened.
  int OpenAny() {
    libusb_device** list = nullptr;
    const auto count = libusb_get_device_list(context->value, &list);
    int error = LIBUSB_ERROR_NO_DEVICE;
    for (ssize_t i = 0; i < count && handle == nullptr; ++i) {
      libusb_device_descriptor d{};
      if (libusb_get_device_descriptor(list[i], &d) != 0) continue;
      if (d.idVendor != id.vendor || d.idProduct != id.product) continue;
      error = OpenOne(list[i], d.iSerialNumber);
    }
    if (list != nullptr) libusb_free_device_list(list, 1);
    return handle != nullptr ? 0 : error;
  }

  // Waits for a device of ours to be plugged in; false where none was in time.
  bool WaitForArrival(SteadyClock::time_point until) {
    bool arrived = false;
    libusb_hotplug_callback_handle callback{};
    const int error = libusb_hotplug_register_callback(
        context->value, LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED, LIBUSB_HOTPLUG_NO_FLAGS, id.vendor, id.product,
        LIBUSB_HOTPLUG_MATCH_ANY, OnArrival, &arrived, &callback);
    Require("watch the bus", error);
    while (!arrived && SteadyClock::now() < until) {
      timeval step{0, 50000};
      libusb_handle_events_timeout_completed(context->value, &step, nullptr);
      // One that came between our look and the registration is not told of.
      if (OpenAny() == 0) break;
    }
    libusb_hotplug_deregister_callback(context->value, callback);
    return arrived || handle != nullptr;
  }
};

UsbLink::UsbLink(std::string name, UsbId id) : impl_(new Impl{std::move(name), std::move(id)}) {}

UsbLink::~UsbLink() {
  Close();
}

void UsbLink::Open(milliseconds wait) {
  Close();
  const auto until = SteadyClock::now() + wait;
  int error = impl_->OpenAny();
  if (error == LIBUSB_ERROR_NO_DEVICE) {
    impl_->Renew();
    error = impl_->OpenAny();
  }
  if (error == LIBUSB_ERROR_NO_DEVICE && impl_->WaitForArrival(until)) {
    error = impl_->handle != nullptr ? 0 : impl_->OpenAny();
  }
  impl_->Require("find it on USB", error);
}

bool UsbLink::is_open() const {
  return impl_->handle != nullptr;
}

void UsbLink::Close() noexcept {
  if (impl_->handle == nullptr) return;
  libusb_release_interface(impl_->handle, 0);
  libusb_close(impl_->handle);
  impl_->handle = nullptr;
}

void UsbLink::Control(const UsbSetupOut& s, std::span<const std::uint8_t> data, milliseconds limit) {
  // libusb only reads what goes out; its interface lacks the const.
  const int result = libusb_control_transfer(
      impl_->handle, s.request_type, s.request, s.value, s.index, const_cast<std::uint8_t*>(data.data()),
      static_cast<std::uint16_t>(data.size()), static_cast<unsigned>(limit.count()));
  impl_->Require("tell it something", result);
}

void UsbLink::Write(std::uint8_t endpoint, std::span<const std::uint8_t> data, milliseconds limit) {
  int sent = 0;
  const int result =
      libusb_bulk_transfer(impl_->handle, endpoint, const_cast<std::uint8_t*>(data.data()),
                           static_cast<int>(data.size()), &sent, static_cast<unsigned>(limit.count()));
  if (result == LIBUSB_ERROR_PIPE) libusb_clear_halt(impl_->handle, endpoint);
  impl_->Require("write to it", result);
}

std::size_t UsbLink::Read(std::uint8_t endpoint, bool interrupt, std::span<std::uint8_t> data,
                          milliseconds limit) {
  int received = 0;
  const auto transfer = interrupt ? libusb_interrupt_transfer : libusb_bulk_transfer;
  const int result = transfer(impl_->handle, endpoint, data.data(), static_cast<int>(data.size()), &received,
                              static_cast<unsigned>(limit.count()));
  if (result == LIBUSB_ERROR_TIMEOUT) return static_cast<std::size_t>(received);
  if (result == LIBUSB_ERROR_PIPE) libusb_clear_halt(impl_->handle, endpoint);
  impl_->Require("read from it", result);
  return static_cast<std::size_t>(received);
}

}  // namespace dermap
