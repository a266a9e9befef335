// SPDX-License-Identifier: Apache-2.0
// libumockdev's side: sysfs, the device nodes, and who asks.
#include "acquire/emulator/usb_bus.h"

#include <umockdev.h>

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <cstdio>
#include <filesystem>
#include <set>
#include <thread>

#include "acquire/emulator/readiness_fifo.h"
#include "acquire/emulator/usb_line.h"
#include "acquire/emulator/usbfs.h"
#include "common/core/error.h"

namespace dermap::emulator {

const char* const kPreloadLibrary = "libumockdev-preload.so.0";

namespace {

namespace fs = std::filesystem;

struct GObjectRelease {
  void operator()(void* object) const { g_object_unref(object); }
};
template <class T>
using GPointer = std::unique_ptr<T, GObjectRelease>;

struct Port {
  Port(UsbDevice& device, const fs::path& node_path, std::string name)
      : line(device), fifo(node_path), node(std::move(name)), handler(umockdev_ioctl_base_new()) {}
  bool IsOfNoMoreUse() const { return line.gone() && clients.empty(); }
  UsbLine line;
  ReadinessFifo fifo;
  std::string node;      // /dev/bus/usb/001/NNN
  std::string sys_path;  // below /sys
  GPointer<UMockdevIoctlBase> handler;
  std::set<const void*> clients;  // programs that have the node open
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

}  // namespace

struct UsbBus::Impl {
  std::mutex mutex;
  std::condition_variable wake;
  bool stopping = false;
  int last_address = 1;
  GPointer<UMockdevTestbed> testbed{umockdev_testbed_new()};
  std::list<std::unique_ptr<Port>> ports;  // those unplugged as well, while their clients still ask
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
    for (const auto& port : ports) Detach(*port);
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

  // Nobody may open a node that no socket stands behind: libumockdev's library would end that program.
  void Detach(Port& port) {
    port.fifo.TakeAway();
    g_signal_handlers_disconnect_by_data(port.handler.get(), this);
    umockdev_testbed_detach_ioctl(testbed.get(), port.node.c_str(), nullptr);
  }

  // A node whose device has gone and that nobody has open any more keeps descriptors for nothing.
  void DetachUseless() {
    std::list<std::unique_ptr<Port>> useless;
    {
      const std::lock_guard lock(mutex);
      for (auto it = ports.begin(); it != ports.end();) {
        const auto port = it++;
        if ((*port)->IsOfNoMoreUse()) useless.splice(useless.end(), ports, port);
      }
    }
    for (const auto& port : useless) Detach(*port);
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

  static gboolean OnIoctl(UMockdevIoctlBase* handler, UMockdevIoctlClient* client, gpointer self_pointer) {
    int error = ENODEV;
    {
      const std::lock_guard living(LivingMutex());
      if (LivingBuses().count(self_pointer) != 0) {
        auto& self = *static_cast<Impl*>(self_pointer);
        const std::lock_guard lock(self.mutex);
        if (Port* port = self.PortOf(handler)) {
          error = AnswerUsbfs(port->line, client, umockdev_ioctl_client_get_request(client),
                              umockdev_ioctl_client_get_arg(client));
          port->fifo.Set(port->line.HasDone());
        }
        self.wake.notify_all();
      }
    }
    umockdev_ioctl_client_complete(client, error == 0 ? 0 : -1, error);
    return TRUE;
  }

  static void OnConnected(UMockdevIoctlBase* handler, UMockdevIoctlClient* client, gpointer self_pointer) {
    g_object_weak_ref(G_OBJECT(client), OnVanished, self_pointer);
    const std::lock_guard living(LivingMutex());
    if (LivingBuses().count(self_pointer) == 0) return;
    auto& self = *static_cast<Impl*>(self_pointer);
    const std::lock_guard lock(self.mutex);
    if (Port* port = self.PortOf(handler)) port->clients.insert(client);
  }

  // libumockdev tells of no client that has died; that its object goes is the sign.
  static void OnVanished(gpointer self_pointer, GObject* client) {
    const std::lock_guard living(LivingMutex());
    if (LivingBuses().count(self_pointer) == 0) return;
    auto& self = *static_cast<Impl*>(self_pointer);
    const std::lock_guard lock(self.mutex);
    for (const auto& port : self.ports) {
      port->clients.erase(client);
      for (const Transfer& t : port->line.Forget(client)) LetGoOf(t);
      port->fifo.Set(port->line.HasDone());
    }
  }

  void AddToSysfs(Port& port, const UsbIdentity& id, int address) {
    const std::string text = SysfsEntry(id, address);
    GError* error = nullptr;
    if (!umockdev_testbed_add_from_string(testbed.get(), text.c_str(), &error)) {
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
  impl_->DetachUseless();
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
