// SPDX-License-Identifier: Apache-2.0
// The table of devices that are known, and what stands in the way of using one.
#include "acquire/devices/device_report.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace dermap {
namespace {

namespace fs = std::filesystem;

struct KnownDevice {
  std::uint16_t vendor, product;
  const char *kind, *name, *driver, *note;
};
constexpr std::array kKnown{
    KnownDevice{0x1278, 0x0920, "wheel", "Starlight Xpress filter wheel", "starlight", ""},
    KnownDevice{0x0403, 0x6001, "wheel", "FTDI bridge, as Thorlabs FW102C and FW212C have it", "thorlabs",
                "Other things have this bridge too; the driver asks what it is."},
    KnownDevice{0x03C3, 0x1F01, "wheel", "ZWO EFW filter wheel", "", "There is no driver for it yet."},
    KnownDevice{0x0F18, 0x0007, "wheel", "FLI filter wheel", "", "There is no driver for it yet."},
    KnownDevice{0x04A9, 0x30EB, "camera", "Canon EOS 20D (normal mode)", "gphoto2",
                "Driven by libgphoto2's old Canon driver: best effort, frames take longer."},
    KnownDevice{0x04A9, 0x30EC, "camera", "Canon EOS 20D (PTP mode)", "",
                "In this mode it takes no frames; set Communication to Normal in its menu."}};
constexpr std::uint16_t kCanon = 0x04A9;

std::string PortOf(const UsbFound& f) {
  char port[32];
  std::snprintf(port, sizeof port, "usb:%03d,%03d", f.bus, f.address);
  return port;
}

// Services of desktops that take a camera as soon as it is plugged in.
bool IsDesktopService(const std::string& program) {
  return program.rfind("gvfs", 0) == 0 || program.rfind("kio", 0) == 0 || program.rfind("kamera", 0) == 0 ||
         program.rfind("shotwell", 0) == 0 || program.rfind("darktable", 0) == 0;
}

void Judge(DeviceReport& report, const UsbFound& f, const std::vector<NodeHolder>& holders) {
  report.node = f.node;
  report.needs_rule = !f.writable;
  const auto held =
      std::find_if(holders.begin(), holders.end(), [&](const NodeHolder& h) { return h.node == f.node; });
  if (held != holders.end()) {
    report.holder = held->program + " (process " + std::to_string(held->pid) + ")";
    const std::string unmount =
        IsDesktopService(held->program)
            ? " It is a desktop's service: end it, or mask it (systemctl --user mask --now "
              "gvfs-gphoto2-volume-monitor.service)."
            : " End it first.";
    report.note = "It is held by " + report.holder + "." + unmount;
  } else if (f.claimed) {
    report.holder = "another user's program";
    report.note = "It is held by " + report.holder +
                  ", as the daemon is where it runs as a service; 'sudo dermap devices' names it.";
  } else if (report.needs_rule) {
    report.note = "You may not write to " + f.node + ": install the udev rule below, then plug it in again.";
  }
  report.usable = !report.driver.empty() && !report.needs_rule && report.holder.empty();
}

// Elsewhere a path may end in the same words: in a container, or on the bus of another emulator.
bool IsSameFile(const fs::path& a, const fs::path& b) {
  struct stat of_a {
  }, of_b{};
  return ::stat(a.c_str(), &of_a) == 0 && ::stat(b.c_str(), &of_b) == 0 && of_a.st_dev == of_b.st_dev &&
         of_a.st_ino == of_b.st_ino;
}

}  // namespace

std::vector<NodeHolder> FindNodeHolders() {
  std::vector<NodeHolder> holders;
  std::error_code error;
  const std::string nodes = "/dev/bus/usb/";
  for (const auto& process : fs::directory_iterator("/proc", error)) {
    const int pid = std::atoi(process.path().filename().c_str());
    if (pid <= 0 || pid == ::getpid()) continue;
    std::error_code hidden;
    for (const auto& file : fs::directory_iterator(process.path() / "fd", hidden)) {
      const std::string target = fs::read_symlink(file.path(), hidden).string();
      const auto at = target.find(nodes);
      if (at == std::string::npos || target.find("/.", at) != std::string::npos) continue;
      if (!IsSameFile(file.path(), target.substr(at))) continue;
      std::string program;
      std::ifstream(process.path() / "comm") >> program;
      holders.push_back({target.substr(at), program, pid});
    }
  }
  return holders;
}

std::vector<DeviceReport> MakeDeviceReport(const std::vector<UsbFound>& usb,
                                           const std::vector<AttachedCamera>& cameras,
                                           const std::vector<NodeHolder>& holders) {
  std::vector<DeviceReport> reports;
  for (const UsbFound& f : usb) {
    DeviceReport report;
    const auto camera = std::find_if(cameras.begin(), cameras.end(),
                                     [&](const AttachedCamera& c) { return c.port == PortOf(f); });
    const auto known = std::find_if(kKnown.begin(), kKnown.end(), [&](const KnownDevice& k) {
      return k.vendor == f.vendor && k.product == f.product;
    });
    if (known != kKnown.end()) {
      report = {known->kind, known->name, known->driver, "", "", false, false, "", known->note};
    } else if (camera != cameras.end()) {
      report = {"camera", camera->model, "gphoto2", "", "", false, false, "", ""};
    } else if (f.vendor == kCanon) {  // one that libgphoto2 does not find: perhaps for lack of permission
      report = {"camera", "Canon camera that libgphoto2 does not know", "", "", "", false, false, "", ""};
    } else {
      continue;
    }
    if (camera != cameras.end() && report.driver == "gphoto2") report.name = camera->model;
    if (report.kind == "camera") report.port = PortOf(f);
    Judge(report, f, holders);
    reports.push_back(report);
  }
  return reports;
}

}  // namespace dermap
