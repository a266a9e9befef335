// SPDX-License-Identifier: Apache-2.0
// libumockdev's side: sysfs, the device nodes, and the requests of usbfs. libusb waits for a node to become
// writable; ours are FIFOs, kept full while no transfer is done and drained once one is.
#include "acquire/emulator/usb_bus.h"

#include <fcntl.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <umockdev.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <condition_variable>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <set>
#include <thread>

#include "acquire/emulator/usb_line.h"
#include "common/core/error.h"

namespace dermap::emulator {

const char* const kPreloadLibrary = "libumockdev-preload.so.0";

namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kCapabilities = USBDEVFS_CAP_BULK_SCATTER_GATHER | USBDEVFS_CAP_BULK_CONTINUATION |
                                        USBDEVFS_CAP_NO_PACKET_SIZE_LIM | USBDEVFS_CAP_REAP_AFTER_DISCONNECT |
                                        USBDEVFS_CAP_ZERO_PACKET;
constexpr int kFifoBytes = 4096;

struct GObjectRelease {
  void operator()(void* object) const { g_object_unref(object); }
};
template <class T>
using GPointer = std::unique_ptr<T, GObjectRelease>;

std::string Hex(const Bytes& bytes) {
  std::string text;
  char digits[3];
  for (const std::uint8_t b : bytes) {
    std::snprintf(digits, sizeof digits, "%02X", b);
    text += digits;
  }
  return text;
}

// A node that is writable exactly while `Set(true)`.
class ReadinessFifo {
 public:
  explicit ReadinessFifo(const fs::path& path) {
    std::error_code ignored;
    fs::create_directories(path.parent_path(), ignored);
    // Opened under another name: whoever looks for programs that have the node open shall find its clients
    // alone.
    fs::path own = path;
    own.replace_filename(std::string(1, '.').append(path.filename().string()));
    if (::mkfifo(own.c_str(), 0666) != 0) throw DeviceError("cannot make " + own.string());
    fd_ = ::open(own.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (fd_ < 0 || ::link(own.c_str(), path.c_str()) != 0) throw DeviceError("cannot open " + own.string());
    ::fcntl(fd_, F_SETPIPE_SZ, kFifoBytes);
    Set(false);
  }
  ~ReadinessFifo() { ::close(fd_); }
  ReadinessFifo(const ReadinessFifo&) = delete;
  ReadinessFifo& operator=(const ReadinessFifo&) = delete;

  void Set(bool ready) {
    if (ready == ready_) return;
    ready_ = ready;
    std::array<char, kFifoBytes> block{};
    if (ready) {
      while (::read(fd_, block.data(), block.size()) > 0) {
      }
    } else {
      while (::write(fd_, block.data(), block.size()) > 0) {
      }
    }
  }

 private:
  int fd_ = -1;
  bool ready_ = true;
};

// What is kept of a transfer's memory in the client.
struct TransferMemory {
  GPointer<UMockdevIoctlData> urb, buffer;
};

struct Port {
  Port(UsbDevice& device, const fs::path& node_path, std::string name)
      : line(device), fifo(node_path), node(std::move(name)), handler(umockdev_ioctl_base_new()) {}
  UsbLine line;
  ReadinessFifo fifo;
  std::string node;      // /dev/bus/usb/001/NNN
  std::string sys_path;  // below /sys
  GPointer<UMockdevIoctlBase> handler;
};

// libumockdev's thread outlives a testbed a little: what it calls looks here first whether there is still a
// bus.
std::mutex& LivingMutex() {
  static std::mutex mutex;
  return mutex;
}
std::set<const void*>& LivingBuses() {
  static std::set<const void*> buses;
  return buses;
}

TransferMemory* MemoryOf(const Transfer& t) {
  return static_cast<TransferMemory*>(t.handle);
}

}  // namespace

struct UsbBus::Impl {
  std::mutex mutex;
  std::condition_variable wake;
  bool stopping = false;
  int last_address = 1;
  GPointer<UMockdevTestbed> testbed{umockdev_testbed_new()};
  std::list<std::unique_ptr<Port>> ports;  // those unplugged as well: their clients still ask
  std::thread pump;

  Impl() : pump([this] { PumpUntilStopped(); }) {
    const std::lock_guard living(LivingMutex());
    LivingBuses().insert(this);
  }

  ~Impl() {
    {
      const std::lock_guard living(LivingMutex());
      LivingBuses().erase(this);
    }
    {
      const std::lock_guard lock(mutex);
      stopping = true;
    }
    wake.notify_all();
    pump.join();
    for (const auto& port : ports) {
      g_signal_handlers_disconnect_by_data(port->handler.get(), this);
      umockdev_testbed_detach_ioctl(testbed.get(), port->node.c_str(), nullptr);
    }
    testbed.reset();
  }

  void PumpUntilStopped() {
    std::unique_lock lock(mutex);
    while (!stopping) {
      std::optional<Clock::time_point> next;
      for (const auto& port : ports) {
        const auto when = port->line.Pump();
        if (when) next = next ? std::min(*next, *when) : *when;
        port->fifo.Set(port->line.HasDone());
      }
      if (next) {
        wake.wait_until(lock, *next);
      } else {
        wake.wait(lock);
      }
    }
  }

  bool IsPlugged(const UsbDevice& device) {
    const std::lock_guard lock(mutex);
    return std::any_of(ports.begin(), ports.end(), [&](const auto& port) {
      return !port->line.gone() && &port->line.device() == &device;
    });
  }

  Port* PortOf(UMockdevIoctlBase* handler) {
    for (const auto& port : ports) {
      if (port->handler.get() == handler) return port.get();
    }
    return nullptr;
  }

  int Submit(Port& port, UMockdevIoctlClient* client, UMockdevIoctlData* arg) {
    if (port.line.gone()) return ENODEV;
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
    port.line.Submit(t);
    return 0;
  }

  // 0 or an errno; the reaped transfer is handed to the client's pointer.
  int Reap(Port& port, UMockdevIoctlClient* client, UMockdevIoctlData* arg) {
    const auto transfer = port.line.Reap(client);
    port.fifo.Set(port.line.HasDone());
    if (!transfer) return port.line.gone() ? ENODEV : EAGAIN;
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
    const GPointer<UMockdevIoctlData> data(
        umockdev_ioctl_data_resolve(arg, 0, sizeof kCapabilities, nullptr));
    if (!data) return EFAULT;
    std::memcpy(data->data, &kCapabilities, sizeof kCapabilities);
    return 0;
  }

  // 0 or an errno.
  int Handle(Port& port, UMockdevIoctlClient* client, unsigned long request, UMockdevIoctlData* arg) {
    unsigned number = 0;
    switch (request) {
      case USBDEVFS_GET_CAPABILITIES:
        return Capabilities(arg);
      case USBDEVFS_CLAIMINTERFACE:
      case USBDEVFS_DISCONNECT_CLAIM:  // begins with the interface's number too
        if (const int error = Number(arg, number)) return error;
        return port.line.Claim(client, number);
      case USBDEVFS_RELEASEINTERFACE:
        port.line.Release(client);
        return 0;
      case USBDEVFS_CLEAR_HALT:
      case USBDEVFS_RESETEP:
        if (const int error = Number(arg, number)) return error;
        if (port.line.gone()) return ENODEV;
        port.line.Halt(number);
        return 0;
      case USBDEVFS_SETINTERFACE:
      case USBDEVFS_SETCONFIGURATION:
      case USBDEVFS_RESET:
        return port.line.gone() ? ENODEV : 0;
      case USBDEVFS_SUBMITURB:
        return Submit(port, client, arg);
      case USBDEVFS_DISCARDURB: {
        std::uint64_t id = 0;
        std::memcpy(&id, arg->data, sizeof id);
        return port.line.Discard(client, id) ? 0 : EINVAL;
      }
      case USBDEVFS_REAPURB:
      case USBDEVFS_REAPURBNDELAY:
        return Reap(port, client, arg);
      case USBDEVFS_GETDRIVER:
      case USBDEVFS_IOCTL:
        return ENODATA;  // no kernel driver is bound
      default:
        return ENOTTY;
    }
  }

  static gboolean OnIoctl(UMockdevIoctlBase* handler, UMockdevIoctlClient* client, gpointer self_pointer) {
    int error = ENODEV;
    {
      const std::lock_guard living(LivingMutex());
      if (LivingBuses().count(self_pointer) != 0) {
        auto& self = *static_cast<Impl*>(self_pointer);
        const std::lock_guard lock(self.mutex);
        if (Port* port = self.PortOf(handler)) {
          error = self.Handle(*port, client, umockdev_ioctl_client_get_request(client),
                              umockdev_ioctl_client_get_arg(client));
        }
        self.wake.notify_all();
      }
    }
    umockdev_ioctl_client_complete(client, error == 0 ? 0 : -1, error);
    return TRUE;
  }

  static void OnConnected(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self_pointer) {
    g_object_weak_ref(G_OBJECT(client), OnVanished, self_pointer);
  }

  // libumockdev tells of no client that has died; that its object goes is the sign.
  static void OnVanished(gpointer self_pointer, GObject* client) {
    const std::lock_guard living(LivingMutex());
    if (LivingBuses().count(self_pointer) == 0) return;
    auto& self = *static_cast<Impl*>(self_pointer);
    const std::lock_guard lock(self.mutex);
    for (const auto& port : self.ports) {
      for (const Transfer& t : port->line.Forget(client)) delete MemoryOf(t);
      port->fifo.Set(port->line.HasDone());
    }
  }

  void AddToSysfs(Port& port, const UsbIdentity& id, int address) {
    char text[1600];
    std::snprintf(
        text, sizeof text,
        "P: /devices/usb1/1-%d\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\n"
        "E: DEVNAME=/dev/bus/usb/001/%03d\nE: BUSNUM=001\nE: DEVNUM=%03d\nE: MAJOR=189\nE: MINOR=%d\n"
        "A: busnum=1\nA: devnum=%d\nA: idVendor=%04x\nA: idProduct=%04x\nA: speed=%d\n"
        "A: bConfigurationValue=1\nA: bNumConfigurations=1\nH: descriptors=%s\n",
        address, address, address, address - 1, address, id.vendor, id.product, id.speed_mbit_s,
        Hex(UsbDescriptors(id)).c_str());
    GError* error = nullptr;
    if (!umockdev_testbed_add_from_string(testbed.get(), text, &error)) {
      const std::string why = error != nullptr ? error->message : "";
      g_clear_error(&error);
      throw DeviceError("libumockdev does not take the emulated device: " + why);
    }
    port.sys_path = "/sys/devices/usb1/1-" + std::to_string(address);
  }
};

UsbBus::UsbBus() : impl_(std::make_unique<Impl>()) {}

UsbBus::~UsbBus() {
  std::list<UsbDevice*> plugged;
  {
    const std::lock_guard lock(impl_->mutex);
    for (const auto& port : impl_->ports) {
      if (!port->line.gone()) plugged.push_back(&port->line.device());
    }
  }
  for (UsbDevice* device : plugged) Unplug(*device);
}

std::mutex& UsbBus::lock() {
  return impl_->mutex;
}

void UsbBus::Plug(UsbDevice& device) {
  if (impl_->IsPlugged(device)) return;
  const int address = ++impl_->last_address;
  char node[32];
  std::snprintf(node, sizeof node, "/dev/bus/usb/001/%03d", address);
  gchar* root = umockdev_testbed_get_root_dir(impl_->testbed.get());
  const fs::path node_path = std::string(root) + node;
  g_free(root);
  std::unique_ptr<Port> port;
  {
    const std::lock_guard lock(impl_->mutex);
    port = std::make_unique<Port>(device, node_path, node);
  }
  g_signal_connect(port->handler.get(), "handle-ioctl", G_CALLBACK(Impl::OnIoctl), impl_.get());
  g_signal_connect(port->handler.get(), "client-connected", G_CALLBACK(Impl::OnConnected), impl_.get());
  umockdev_testbed_attach_ioctl(impl_->testbed.get(), node, port->handler.get(), nullptr);
  Port& plugged = *port;
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->ports.push_back(std::move(port));
  }
  impl_->AddToSysfs(plugged, device.Identity(), address);  // clients hear of it now: all else is ready
}

void UsbBus::Unplug(UsbDevice& device) {
  std::string sys_path;
  {
    const std::lock_guard lock(impl_->mutex);
    for (const auto& port : impl_->ports) {
      if (port->line.gone() || &port->line.device() != &device) continue;
      port->line.Disconnect();
      port->fifo.Set(port->line.HasDone());
      sys_path = port->sys_path;
    }
  }
  if (sys_path.empty()) return;
  umockdev_testbed_uevent(impl_->testbed.get(), sys_path.c_str(), "remove");
  umockdev_testbed_remove_device(impl_->testbed.get(), sys_path.c_str());
}

}  // namespace dermap::emulator
