// SPDX-License-Identifier: Apache-2.0
// Devices that answer nonsense, through libusb and libgphoto2: a wheel's reports and packets, a camera's
// containers, at random but the same each time. Whatever they say, it is a fault, or a slot that the wheel
// has; never a crash.
#include <gtest/gtest.h>

#include <random>

#include "acquire/devices/gphoto2_camera.h"
#include "acquire/devices/usb_wheel.h"
#include "acquire/emulator/ptp_usb.h"
#include "acquire/emulator/starlight_wheel.h"
#include "acquire/emulator/thorlabs_wheel.h"
#include "acquire/emulator/usb_bus.h"
#include "tests/acquire/devices/patience.h"

namespace dermap {
namespace {

using namespace std::chrono_literals;
using emulator::Bytes;

constexpr WheelTiming kHasty{.plug_in = 200ms, .answer = 15ms, .per_slot = 1ms, .poll = 1ms};

// Spoils some of the answers of a device.
class Spoiler {
 public:
  explicit Spoiler(unsigned seed) : random_(seed) {}
  void Spoil(Bytes& data) {
    if (random_() % 3 != 0) return;
    for (unsigned n = 1 + random_() % 4; n > 0 && !data.empty(); --n)
      data[random_() % data.size()] = static_cast<std::uint8_t>(random_());
    if (random_() % 4 == 0 && !data.empty()) data.resize(random_() % data.size());
    if (random_() % 8 == 0) data.insert(data.end(), random_() % 200, static_cast<std::uint8_t>(random_()));
  }

 private:
  std::mt19937 random_;
};

// Between a device and its line.
template <class Device>
class Hostile : public Device, private emulator::UsbAnswers {
 public:
  template <class... Arguments>
  explicit Hostile(unsigned seed, Arguments&&... arguments)
      : Device(std::forward<Arguments>(arguments)...), spoiler_(seed) {}
  void Attached(emulator::UsbAnswers& line) override {
    line_ = &line;
    Device::Attached(*this);
  }
  void Detached() override {
    Device::Detached();
    line_ = nullptr;
  }

 private:
  void Answer(std::uint8_t endpoint, Bytes data, emulator::Clock::time_point when) override {
    spoiler_.Spoil(data);
    if (line_ != nullptr) line_->Answer(endpoint, std::move(data), when);
  }
  void DropAnswers(std::uint8_t endpoint) override {
    if (line_ != nullptr) line_->DropAnswers(endpoint);
  }
  Spoiler spoiler_;
  emulator::UsbAnswers* line_ = nullptr;
};

template <class Device, class Make>
void DriveAHostileWheel(Make make) {
  int faults = 0, moves = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    emulator::WheelMotion motion(12, 0.0);
    Hostile<Device> device(seed, motion);
    emulator::UsbBus bus;
    bus.Plug(device);
    const auto driver = make();
    for (int slot = 1; slot <= 4; ++slot) {
      try {
        driver->MoveTo(slot);
        EXPECT_GE(driver->SlotCount(), 1);
        EXPECT_LE(driver->SlotCount(), 64);
        ++moves;
      } catch (const DeviceFault& fault) {
        EXPECT_NE(std::string(fault.what()).find("remedy"), std::string::npos) << fault.what();
        ++faults;
      }
    }
  }
  EXPECT_GT(faults, 0);
  EXPECT_GT(moves, 0);
}

TEST(HostileDevices, StarlightReportsAreFaultsOrSlots) {
  DriveAHostileWheel<emulator::StarlightWheel>([] { return MakeStarlightWheel("", kHasty); });
}

TEST(HostileDevices, ThorlabsPacketsAreFaultsOrSlots) {
  DriveAHostileWheel<emulator::ThorlabsWheel>([] { return MakeThorlabsWheel("", kHasty); });
}

// libgphoto2 parses the containers, in a process of its own: should it crash or hang there, that is a fault.
TEST(HostileDevices, CameraContainersAreFaultsOrFrames) {
  CameraPatience hasty = kQuickCamera;
  hasty.answer = 60ms;
  hasty.call = 400ms;
  hasty.file = 200ms;
  hasty.first_pause = 1ms;
  hasty.attempts = 2;
  hasty.plug_in = 100ms;
  int faults = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    emulator::EosCamera eos([](double, int) { return [] { return Bytes(20000, 7); }; }, {});
    Hostile<emulator::PtpUsb> usb(seed, eos);
    emulator::UsbBus bus;
    bus.Plug(usb);
    Gphoto2Camera camera({}, hasty);
    for (int shot = 1; shot <= 2; ++shot) {
      try {
        camera.Expose({10.0, 100, shot});
        camera.Fetch();
      } catch (const DeviceError&) {
        ++faults;
      }
    }
  }
  EXPECT_GT(faults, 0);
}

}  // namespace
}  // namespace dermap
