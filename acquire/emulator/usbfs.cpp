// SPDX-License-Identifier: Apache-2.0
// Requests by number, with the client's memory mirrored by libumockdev.
#include "acquire/emulator/usbfs.h"

#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <umockdev.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <memory>

namespace dermap::emulator {
namespace {

constexpr std::uint32_t kCapabilities = USBDEVFS_CAP_BULK_SCATTER_GATHER | USBDEVFS_CAP_BULK_CONTINUATION |
                                        USBDEVFS_CAP_NO_PACKET_SIZE_LIM | USBDEVFS_CAP_REAP_AFTER_DISCONNECT |
                                        USBDEVFS_CAP_ZERO_PACKET;

struct GObjectRelease {
  void operator()(void* object) const { g_object_unref(object); }
};
template <class T>
using GPointer = std::unique_ptr<T, GObjectRelease>;

// What is kept of a transfer's memory in the client.
struct TransferMemory {
  GPointer<UMockdevIoctlData> urb, buffer;
};

TransferMemory* MemoryOf(const Transfer& t) {
  return static_cast<TransferMemory*>(t.handle);
}

int Submit(UsbLine& line, UMockdevIoctlClient* client, UMockdevIoctlData* arg) {
  if (line.gone()) return ENODEV;
  auto memory = std::make_unique<TransferMemory>();
  memory->urb.reset(umockdev_ioctl_data_resolve(arg, 0, sizeof(usbdevfs_urb), nullptr));
  if (!memory->urb) return EFAULT;
  auto* urb = reinterpret_cast<usbdevfs_urb*>(memory->urb->data);
  if (urb->type == USBDEVFS_URB_TYPE_ISO || urb->buffer_length < 0) return EINVAL;
  Transfer t;
  t.client = client;
  t.id = memory->urb->client_addr;
  t.kind = urb->type;
  t.endpoint = urb->endpoint;
  if (urb->buffer_length > 0) {
    memory->buffer.reset(umockdev_ioctl_data_resolve(memory->urb.get(), offsetof(usbdevfs_urb, buffer),
                                                     static_cast<gsize>(urb->buffer_length), nullptr));
    if (!memory->buffer) return EFAULT;
    t.buffer = {memory->buffer->data, static_cast<std::size_t>(memory->buffer->data_len)};
  }
  t.handle = memory.release();
  line.Submit(t);
  return 0;
}

// 0 or an errno; the reaped transfer is handed to the client's pointer.
int Reap(UsbLine& line, UMockdevIoctlClient* client, UMockdevIoctlData* arg) {
  const auto transfer = line.Reap(client);
  if (!transfer) return line.gone() ? ENODEV : EAGAIN;
  const std::unique_ptr<TransferMemory> memory(MemoryOf(*transfer));
  auto* urb = reinterpret_cast<usbdevfs_urb*>(memory->urb->data);
  urb->status = transfer->status;
  urb->actual_length = transfer->actual;
  const GPointer<UMockdevIoctlData> slot(umockdev_ioctl_data_resolve(arg, 0, sizeof(void*), nullptr));
  if (!slot) return EFAULT;
  umockdev_ioctl_data_set_ptr(slot.get(), 0, memory->urb.get());
  return 0;
}

int Number(UMockdevIoctlData* arg, unsigned& value) {
  const GPointer<UMockdevIoctlData> data(umockdev_ioctl_data_resolve(arg, 0, sizeof value, nullptr));
  if (!data) return EFAULT;
  std::memcpy(&value, data->data, sizeof value);
  return 0;
}

int Capabilities(UMockdevIoctlData* arg) {
  const GPointer<UMockdevIoctlData> data(umockdev_ioctl_data_resolve(arg, 0, sizeof kCapabilities, nullptr));
  if (!data) return EFAULT;
  std::memcpy(data->data, &kCapabilities, sizeof kCapabilities);
  return 0;
}

}  // namespace

int AnswerUsbfs(UsbLine& line, UMockdevIoctlClient* client, unsigned long request, UMockdevIoctlData* arg) {
  unsigned number = 0;
  switch (request) {
    case USBDEVFS_GET_CAPABILITIES:
      return Capabilities(arg);
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_DISCONNECT_CLAIM:  // begins with the interface's number too
      if (const int error = Number(arg, number)) return error;
      return line.Claim(client, number);
    case USBDEVFS_RELEASEINTERFACE:
      line.Release(client);
      return 0;
    case USBDEVFS_CLEAR_HALT:
    case USBDEVFS_RESETEP:
      if (const int error = Number(arg, number)) return error;
      if (line.gone()) return ENODEV;
      line.Halt(number);
      return 0;
    case USBDEVFS_SETINTERFACE:
    case USBDEVFS_SETCONFIGURATION:
    case USBDEVFS_RESET:
      return line.gone() ? ENODEV : 0;
    case USBDEVFS_SUBMITURB:
      return Submit(line, client, arg);
    case USBDEVFS_DISCARDURB: {
      std::uint64_t id = 0;
      std::memcpy(&id, arg->data, sizeof id);
      return line.Discard(client, id) ? 0 : EINVAL;
    }
    case USBDEVFS_REAPURB:
    case USBDEVFS_REAPURBNDELAY:
      return Reap(line, client, arg);
    case USBDEVFS_GETDRIVER:
    case USBDEVFS_IOCTL:
      return ENODATA;  // no kernel driver is bound
    default:
      return ENOTTY;
  }
}

void LetGoOf(const Transfer& transfer) {
  delete MemoryOf(transfer);
}

}  // namespace dermap::emulator
