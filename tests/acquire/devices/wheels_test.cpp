// SPDX-License-Identifier: Apache-2.0
// Wheel drivers against emulated wheels, through libusb. What must come out is where the emulated wheel
// stands.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <thread>

#include "acquire/devices/device_fault.h"
#include "acquire/devices/usb_wheel.h"
#include "acquire/emulator/starlight_wheel.h"
#include "acquire/emulator/thorlabs_wheel.h"
#include "acquire/emulator/usb_bus.h"

namespace dermap {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr WheelTiming kQuick{.plug_in = 300ms, .answer = 200ms, .per_slot = 20ms, .poll = 5ms};

// One wheel of each make, both with what the tests change about them.
struct StarlightUnderTest {
  explicit StarlightUnderTest(emulator::WheelMotion& motion) : device(motion) {}
  std::unique_ptr<FilterWheel> Driver() { return MakeStarlightWheel("", kQuick); }
  emulator::StarlightWheel device;
};
struct ThorlabsUnderTest {
  explicit ThorlabsUnderTest(emulator::WheelMotion& motion) : device(motion) {}
  std::unique_ptr<FilterWheel> Driver() { return MakeThorlabsWheel("TP00000001", kQuick); }
  emulator::ThorlabsWheel device;
};

template <class Wheel>
class Wheels : public testing::Test {
 protected:
  Wheels() { bus_.Plug(wheel_.device); }

  template <class Call>
  FaultKind KindOf(Call call) {
    try {
      call();
    } catch (const DeviceFault& fault) {
      message_ = fault.what();
      return fault.kind();
    }
    ADD_FAILURE() << "no fault";
    return FaultKind::kBusy;
  }

  emulator::WheelMotion motion_{12, 0.005};
  Wheel wheel_{motion_};
  emulator::UsbBus bus_;
  std::string message_;
};

using Makes = testing::Types<StarlightUnderTest, ThorlabsUnderTest>;
TYPED_TEST_SUITE(Wheels, Makes);

TYPED_TEST(Wheels, StandsAtTheSlotThatWasAskedFor) {
  const auto driver = this->wheel_.Driver();
  driver->Connect();
  EXPECT_EQ(driver->SlotCount(), 12);
  for (const int slot : {3, 12, 1, 7, 7}) {
    driver->MoveTo(slot);
    EXPECT_EQ(this->motion_.InTheLight(), slot);
  }
}

TYPED_TEST(Wheels, IsWaitedForUntilItIsPluggedIn) {
  this->bus_.Unplug(this->wheel_.device);
  const auto driver = this->wheel_.Driver();
  std::thread operator_thread([&] {
    std::this_thread::sleep_for(100ms);
    this->bus_.Plug(this->wheel_.device);
  });
  driver->Connect();
  operator_thread.join();
  driver->MoveTo(5);
  EXPECT_EQ(this->motion_.InTheLight(), 5);
}

TYPED_TEST(Wheels, ThatIsMissingIsAFaultThatSaysSo) {
  this->bus_.Unplug(this->wheel_.device);
  const auto driver = this->wheel_.Driver();
  EXPECT_EQ(this->KindOf([&] { driver->Connect(); }), FaultKind::kGone);
  EXPECT_THAT(this->message_, HasSubstr("plug it in"));
}

TYPED_TEST(Wheels, GoesOnAfterReplugging) {
  const auto driver = this->wheel_.Driver();
  driver->Connect();
  driver->MoveTo(2);
  this->bus_.Unplug(this->wheel_.device);
  std::thread operator_thread([&] {
    std::this_thread::sleep_for(100ms);
    this->bus_.Plug(this->wheel_.device);
  });
  driver->MoveTo(9);
  operator_thread.join();
  EXPECT_EQ(this->motion_.InTheLight(), 9);
}

// What the bus had of a plug goes once nobody has it open: files of this process, driver and bus together.
TYPED_TEST(Wheels, LeavesNothingOfAnEarlierPlugBehind) {
  const auto open_files = [] {
    namespace fs = std::filesystem;
    return std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator{});
  };
  const auto driver = this->wheel_.Driver();
  const auto replug = [&](int times) {
    for (; times > 0; --times) {
      driver->MoveTo(2);
      this->bus_.Unplug(this->wheel_.device);
      this->bus_.Plug(this->wheel_.device);
    }
    driver->MoveTo(2);
  };
  replug(3);
  const auto before = open_files();
  replug(10);
  EXPECT_LT(open_files(), before + 5);  // one or two plugs may still be held; each keeps two files
}

TYPED_TEST(Wheels, PluggedOutForGoodIsAFault) {
  const auto driver = this->wheel_.Driver();
  driver->Connect();
  this->bus_.Unplug(this->wheel_.device);
  EXPECT_EQ(this->KindOf([&] { driver->MoveTo(2); }), FaultKind::kGone);
  this->bus_.Plug(this->wheel_.device);
  driver->MoveTo(2);
  EXPECT_EQ(this->motion_.InTheLight(), 2);
}

TYPED_TEST(Wheels, ThatIsStuckIsAFault) {
  const auto driver = this->wheel_.Driver();
  driver->Connect();
  {
    const std::lock_guard lock(this->bus_.lock());
    this->motion_.stuck = true;
  }
  EXPECT_EQ(this->KindOf([&] { driver->MoveTo(6); }), FaultKind::kStuck) << this->message_;
}

TYPED_TEST(Wheels, ThatFallsSilentIsAFaultAndWorksOnceItAnswersAgain) {
  const auto driver = this->wheel_.Driver();
  driver->Connect();
  this->wheel_.device.silent = true;
  EXPECT_THROW(driver->MoveTo(6), DeviceFault);
  this->wheel_.device.silent = false;
  driver->MoveTo(6);
  EXPECT_EQ(this->motion_.InTheLight(), 6);
}

TYPED_TEST(Wheels, BelongsToOneProgramAtATime) {
  const auto driver = this->wheel_.Driver(), second = this->wheel_.Driver();
  driver->Connect();
  EXPECT_EQ(this->KindOf([&] { second->Connect(); }), FaultKind::kInUse);
  driver->MoveTo(4);
  EXPECT_EQ(this->motion_.InTheLight(), 4);
}

TYPED_TEST(Wheels, HasNoSlotBeyondItsLast) {
  const auto driver = this->wheel_.Driver();
  driver->Connect();
  EXPECT_EQ(this->KindOf([&] { driver->MoveTo(13); }), FaultKind::kSettings);
}

}  // namespace
}  // namespace dermap
