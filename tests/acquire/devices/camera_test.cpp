// SPDX-License-Identifier: Apache-2.0
// The gphoto2 driver against an emulated EOS, through libgphoto2 in its helper process. Each shot's file is
// unlike every other: what must come out is the file of the shot that was asked for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <thread>

#include "acquire/devices/device_report.h"
#include "acquire/devices/gphoto2_camera.h"
#include "acquire/emulator/eos_camera.h"
#include "acquire/emulator/ptp_ip.h"
#include "acquire/emulator/ptp_usb.h"
#include "acquire/emulator/unplugger.h"
#include "acquire/emulator/usb_bus.h"
#include "tests/acquire/devices/patience.h"

namespace dermap {
namespace {

using namespace std::chrono_literals;
using emulator::EosFault;
using testing::HasSubstr;

constexpr std::size_t kFileBytes = 2'500'000;  // in three parts, and no multiple of a packet

class CameraOnUsb : public testing::Test {
 protected:
  CameraOnUsb() {
    eos_.unplug = [this](double seconds) { unplugger_.Unplug(usb_, seconds); };
    bus_.Plug(usb_);
    camera_.on_retry = [this](const DeviceFault& fault) { overcome_.push_back(fault.kind()); };
  }

  // The shot's number, settings and length in the first line, then zeros.
  emulator::Bytes FileOfShot(double exposure_ms, int iso) {
    const std::string text = "shot " + std::to_string(++exposed_) + " iso " + std::to_string(iso) + " ms " +
                             std::to_string(std::lround(exposure_ms)) + "\n";
    emulator::Bytes file(text.begin(), text.end());
    file.resize(kFileBytes);
    return file;
  }
  std::string Shoot(int iso = 100, double exposure_ms = 10.0) {
    camera_.Expose({exposure_ms, iso, 1});
    const RawFrame frame = camera_.Fetch();
    size_ = frame.bytes.size();
    const auto* text = reinterpret_cast<const char*>(frame.bytes.data());
    return std::string(text, std::find(text, text + std::min<std::size_t>(size_, 80), '\n'));
  }
  void Plan(EosFault fault, int press, double seconds = 0.3, int times = 1) {
    const std::lock_guard lock(bus_.lock());
    eos_.faults.Plan({fault, press, seconds, times});
  }
  // A good shot, then one that meets the fault.
  void ExpectOvercome(EosFault fault, double seconds = 0.3, int times = 1) {
    Plan(fault, 2, seconds, times);
    for (const int iso : {100, 200}) {
      const std::string first_line = Shoot(iso);
      EXPECT_EQ(first_line, "shot " + std::to_string(exposed_) + " iso " + std::to_string(iso) + " ms 10");
    }
    EXPECT_EQ(size_, kFileBytes);
  }

  int exposed_ = 0;
  std::size_t size_ = 0;
  emulator::EosCamera eos_{
      [this](double ms, int iso) { return [file = FileOfShot(ms, iso)] { return file; }; }, {}};
  emulator::PtpUsb usb_{eos_};
  emulator::UsbBus bus_;
  emulator::Unplugger unplugger_{bus_};
  Gphoto2Camera camera_{{}, kQuickCamera};
  std::vector<FaultKind> overcome_;
};

TEST_F(CameraOnUsb, GivesTheFileOfEachShotWithTheSettingsAskedFor) {
  camera_.Connect();
  EXPECT_THAT(camera_.Name(), HasSubstr("EOS 5D Mark II"));
  EXPECT_EQ(Shoot(100, 10.0), "shot 1 iso 100 ms 10");
  EXPECT_EQ(Shoot(250, 10.0), "shot 2 iso 250 ms 10");
  EXPECT_EQ(Shoot(250, 4.0), "shot 3 iso 250 ms 4");
  EXPECT_EQ(size_, kFileBytes);
  EXPECT_TRUE(overcome_.empty());
}

TEST_F(CameraOnUsb, RefusesSettingsThatItDoesNotHave) {
  try {
    camera_.Expose({10.0, 333, 1});
    FAIL() << "no fault";
  } catch (const DeviceFault& fault) {
    EXPECT_EQ(fault.kind(), FaultKind::kSettings);
    EXPECT_THAT(fault.what(), HasSubstr("iso cannot be set to 333"));
  }
}

TEST_F(CameraOnUsb, OvercomesBusy) {
  ExpectOvercome(EosFault::kBusy, 0.0, 2);
  EXPECT_THAT(overcome_, testing::Each(FaultKind::kBusy));
  EXPECT_GE(overcome_.size(), 1u);
}
TEST_F(CameraOnUsb, OvercomesAStall) {
  ExpectOvercome(EosFault::kStall);
}
TEST_F(CameraOnUsb, OvercomesAHang) {
  ExpectOvercome(EosFault::kHang, 1.5);
  EXPECT_GE(overcome_.size(), 1u);
}
TEST_F(CameraOnUsb, OvercomesUnpluggingInMidTransferWithoutExposingAgain) {
  ExpectOvercome(EosFault::kUnplugRead, 0.5);
  EXPECT_EQ(exposed_, 2);
}
TEST_F(CameraOnUsb, WaitsForALateFile) {
  ExpectOvercome(EosFault::kLate, 0.8);
  EXPECT_EQ(exposed_, 2);
}

// The file of a shot that was given up comes after all, when another is under way.
TEST_F(CameraOnUsb, NeverTakesALateFileForTheNextFrame) {
  Plan(EosFault::kLate, 1, 2.2);
  EXPECT_THROW(Shoot(100), DeviceError);
  EXPECT_EQ(Shoot(200), "shot 2 iso 200 ms 10");
  EXPECT_EQ(Shoot(400), "shot 3 iso 400 ms 10");
}

TEST_F(CameraOnUsb, SaysThatAFrameIsLostWhenItsFileNeverComes) {
  Plan(EosFault::kMissing, 1);
  EXPECT_THROW(Shoot(100), DeviceError);
  EXPECT_EQ(Shoot(100), "shot 2 iso 100 ms 10");
}

TEST_F(CameraOnUsb, FullCardIsAFaultUntilThereIsRoom) {
  Plan(EosFault::kFull, 2, 0.0);
  EXPECT_EQ(Shoot(), "shot 1 iso 100 ms 10");
  try {
    Shoot();
    FAIL() << "no fault";
  } catch (const DeviceFault& fault) {
    EXPECT_EQ(fault.kind(), FaultKind::kFull) << fault.what();
  }
}

TEST_F(CameraOnUsb, GoesOnWhenItsHelperIsKilled) {
  EXPECT_EQ(Shoot(), "shot 1 iso 100 ms 10");
  ASSERT_EQ(kill(camera_.helper_pid(), SIGKILL), 0);
  EXPECT_EQ(Shoot(), "shot 2 iso 100 ms 10");
  camera_.Expose({10.0, 100, 3});
  ASSERT_EQ(kill(camera_.helper_pid(), SIGKILL), 0);
  // Exposed, but where the file lies was not known yet: it must be exposed again.
  EXPECT_THROW(camera_.Fetch(), DeviceError);
  EXPECT_EQ(Shoot(), "shot 4 iso 100 ms 10");
}

// A desktop service, or a second capture.
TEST_F(CameraOnUsb, IsToldToBeInUseByAnotherProgram) {
  camera_.Connect();
  CameraPatience short_patience = kQuickCamera;
  short_patience.attempts = 2;
  Gphoto2Camera second({}, short_patience);
  try {
    second.Connect();
    FAIL() << "no fault";
  } catch (const DeviceFault& fault) {
    EXPECT_EQ(fault.kind(), FaultKind::kInUse) << fault.what();
  }
  EXPECT_EQ(Shoot(), "shot 1 iso 100 ms 10");
}

TEST_F(CameraOnUsb, ThatIsMissingIsAFaultThatSaysSo) {
  bus_.Unplug(usb_);
  CameraPatience short_patience = kQuickCamera;
  short_patience.plug_in = 200ms;
  short_patience.attempts = 1;
  Gphoto2Camera camera({}, short_patience);
  try {
    camera.Connect();
    FAIL() << "no fault";
  } catch (const DeviceFault& fault) {
    EXPECT_EQ(fault.kind(), FaultKind::kGone);
    EXPECT_THAT(fault.what(), HasSubstr("switch it on"));
  }
}

TEST_F(CameraOnUsb, IsListedWithItsPortAndDriver) {
  const auto cameras = ListCameras();
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_THAT(cameras[0].model, HasSubstr("5D Mark II"));
  EXPECT_THAT(cameras[0].port, HasSubstr("usb:001,"));
  EXPECT_EQ(cameras[0].driver, "ptp2");
}

// As `dermap devices` does, beside a program that holds the camera: here our own helper.
TEST_F(CameraOnUsb, IsReportedWithTheProgramThatHoldsIt) {
  const auto report = [] { return MakeDeviceReport(ListUsbDevices(), ListCameras(), FindNodeHolders()); };
  ASSERT_EQ(report().size(), 1u);
  EXPECT_TRUE(report()[0].usable) << report()[0].note;
  camera_.Connect();
  const auto held = report();
  ASSERT_EQ(held.size(), 1u);
  EXPECT_FALSE(held[0].usable);
  EXPECT_EQ(held[0].holder, "dermap-camera (process " + std::to_string(camera_.helper_pid()) + ")");
}

// The same camera on the network.
class CameraOnNetwork : public testing::Test {
 protected:
  static CameraChoice Choice(int port) {
    return {"ptpip:127.0.0.1:" + std::to_string(port) + ":" + std::to_string(port), ""};
  }
  std::string Shoot(int iso) {
    camera_.Expose({10.0, iso, 1});
    const RawFrame frame = camera_.Fetch();
    const auto* text = reinterpret_cast<const char*>(frame.bytes.data());
    EXPECT_EQ(frame.bytes.size(), kFileBytes);
    return std::string(text, std::find(text, text + 80, '\n'));
  }

  int exposed_ = 0;
  std::mutex lock_;
  emulator::EosCamera eos_{[this](double, int iso) {
                             const std::string text =
                                 "shot " + std::to_string(++exposed_) + " iso " + std::to_string(iso) + "\n";
                             emulator::Bytes file(text.begin(), text.end());
                             file.resize(kFileBytes);
                             return [file] { return file; };
                           },
                           {}};
  emulator::PtpIp network_{eos_, lock_};
  Gphoto2Camera camera_{Choice(network_.port()), kQuickCamera};
};

TEST_F(CameraOnNetwork, GivesTheFileOfEachShot) {
  EXPECT_EQ(Shoot(100), "shot 1 iso 100");
  EXPECT_EQ(Shoot(250), "shot 2 iso 250");
}

TEST_F(CameraOnNetwork, ComesBackAfterTheNetworkWasGone) {
  EXPECT_EQ(Shoot(100), "shot 1 iso 100");
  network_.Drop(0.3);
  EXPECT_EQ(Shoot(250), "shot 2 iso 250");
}

}  // namespace
}  // namespace dermap
