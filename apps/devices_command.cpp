// SPDX-License-Identifier: Apache-2.0
// dermap devices: what is attached, by which driver, and what stands in the way.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "acquire/devices/device_report.h"
#include "apps/command_line.h"
#include "apps/commands.h"
#include "common/files/atomic_file.h"
#include "common/tissue/tissue.h"

namespace dermap {
namespace {

std::string RuleText() {
  const auto rule = ConfigDirectory() / "udev/60-dermap.rules";
  return "\nThe udev rule, to be installed once:\n  sudo install -m 644 " + rule.string() +
         " /etc/udev/rules.d/ && sudo udevadm control --reload && sudo udevadm trigger\n\n" +
         ReadTextFile(rule);
}

std::string DescribeDevice(const DeviceReport& d) {
  std::string line = d.kind + ": " + d.name + "\n  driver " + (d.driver.empty() ? "none" : d.driver);
  if (!d.port.empty()) line += ", port " + d.port;
  line += std::string(", ") + (d.usable ? "ready" : "not usable now") + "\n";
  if (!d.note.empty()) line += "  " + d.note + "\n";
  return line;
}

Outcome Report(const std::vector<DeviceReport>& devices) {
  Outcome outcome;
  bool rule = false;
  for (const DeviceReport& d : devices) {
    outcome.text += DescribeDevice(d);
    rule = rule || d.needs_rule;
  }
  for (const char* kind : {"camera", "wheel"}) {
    const bool usable = std::any_of(devices.begin(), devices.end(),
                                    [&](const auto& d) { return d.usable && d.kind == kind; });
    if (usable) continue;
    outcome.code = ExitCode::kDevice;
    const bool any =
        std::any_of(devices.begin(), devices.end(), [&](const auto& d) { return d.kind == kind; });
    if (!any) outcome.text += std::string("no ") + kind + " is found; remedy: plug it in and switch it on\n";
  }
  if (rule) outcome.text += RuleText();
  outcome.fill_json = [devices](nlohmann::json& json) {
    json["devices"] = nlohmann::json::array();
    for (const DeviceReport& d : devices) {
      json["devices"].push_back({{"kind", d.kind},
                                 {"name", d.name},
                                 {"driver", d.driver},
                                 {"port", d.port},
                                 {"node", d.node},
                                 {"usable", d.usable},
                                 {"needs_rule", d.needs_rule},
                                 {"holder", d.holder},
                                 {"note", d.note}});
    }
  };
  return outcome;
}

}  // namespace

int RunDevicesCommand(int argc, char** argv) {
  CommandLine command("devices",
                      "What is attached, by which driver, and what stands in the way of using it.");
  return command.Run(argc, argv, [] {
    return Report(MakeDeviceReport(ListUsbDevices(), ListCameras(), FindNodeHolders()));
  });
}

}  // namespace dermap
