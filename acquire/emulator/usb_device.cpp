// SPDX-License-Identifier: Apache-2.0
// Descriptors, USB 2.0 chapter 9.6.
#include "acquire/emulator/usb_device.h"

#include <cstdio>

namespace dermap::emulator {
namespace {

std::string Hex(const Bytes& bytes) {
  std::string text;
  char digits[3];
  for (const std::uint8_t b : bytes) {
    std::snprintf(digits, sizeof digits, "%02X", b);
    text += digits;
  }
  return text;
}

}  // namespace
namespace {

void Append16(Bytes& out, unsigned value) {
  out.push_back(static_cast<std::uint8_t>(value & 0xFF));
  out.push_back(static_cast<std::uint8_t>(value >> 8 & 0xFF));
}

}  // namespace

Bytes UsbDescriptors(const UsbIdentity& id) {
  Bytes d{18, 1};
  Append16(d, 0x0200);
  d.insert(d.end(), {0, 0, 0, 64});
  Append16(d, id.vendor);
  Append16(d, id.product);
  Append16(d, 0x0100);
  d.insert(d.end(), {1, 2, static_cast<std::uint8_t>(id.serial.empty() ? 0 : 3), 1});
  d.insert(d.end(), {9, 2});
  Append16(d, static_cast<unsigned>(9 + 9 + 7 * id.endpoints.size()));
  d.insert(d.end(), {1, 1, 0, 0xC0, 1});
  d.insert(d.end(), {9, 4, 0, 0, static_cast<std::uint8_t>(id.endpoints.size()), id.interface_class,
                     id.interface_subclass, id.interface_protocol, 0});
  for (const UsbEndpoint& e : id.endpoints) {
    d.insert(d.end(), {7, 5, e.address, e.kind});
    Append16(d, e.packet_bytes);
    d.push_back(e.kind == 3 ? 10 : 0);
  }
  return d;
}

Bytes UsbString(const UsbIdentity& id, int index) {
  if (index == 0) return {4, 3, 0x09, 0x04};  // English, United States
  const std::string* texts[]{&id.manufacturer, &id.name, &id.serial};
  if (index < 1 || index > 3 || texts[index - 1]->empty()) return {};
  Bytes d{static_cast<std::uint8_t>(2 + 2 * texts[index - 1]->size()), 3};
  for (const char c : *texts[index - 1]) Append16(d, static_cast<unsigned char>(c));
  return d;
}

std::string SysfsEntry(const UsbIdentity& id, int address) {
  char text[1600];
  std::snprintf(text, sizeof text,
                "P: /devices/usb1/1-%d\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\n"
                "E: DEVNAME=/dev/bus/usb/001/%03d\nE: BUSNUM=001\nE: DEVNUM=%03d\nE: MAJOR=189\nE: MINOR=%d\n"
                "A: busnum=1\nA: devnum=%d\nA: idVendor=%04x\nA: idProduct=%04x\nA: speed=%d\n"
                "A: bConfigurationValue=1\nA: bNumConfigurations=1\nH: descriptors=%s\n",
                address, address, address, address - 1, address, id.vendor, id.product, id.speed_mbit_s,
                Hex(UsbDescriptors(id)).c_str());
  return text;
}

}  // namespace dermap::emulator
