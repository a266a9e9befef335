// SPDX-License-Identifier: Apache-2.0
// What `dermap devices` says, for buses as the system would show them.
#include "acquire/devices/device_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dermap {
namespace {

using testing::HasSubstr;

const UsbFound kWheel{0x1278, 0x0920, 1, 2, "/dev/bus/usb/001/002", true, true};
const UsbFound kCamera{0x04A9, 0x3199, 1, 3, "/dev/bus/usb/001/003", true, true};
const std::vector<AttachedCamera> kFound{{"Canon EOS 5D Mark II", "usb:001,003", "ptp2"}};

TEST(DeviceReport, NamesDriverAndPort) {
  const UsbFound keyboard{0x046D, 0xC31C, 1, 4, "/dev/bus/usb/001/004", true, true};
  const auto report = MakeDeviceReport({kWheel, kCamera, keyboard}, kFound, {});
  ASSERT_EQ(report.size(), 2u);
  EXPECT_EQ(report[0].driver, "starlight");
  EXPECT_TRUE(report[0].usable);
  EXPECT_EQ(report[1].name, "Canon EOS 5D Mark II");
  EXPECT_EQ(report[1].driver, "gphoto2");
  EXPECT_EQ(report[1].port, "usb:001,003");
  EXPECT_TRUE(report[1].usable);
}

TEST(DeviceReport, AsksForTheRuleWherePermissionIsMissing) {
  UsbFound locked = kWheel;
  locked.writable = false;
  const auto report = MakeDeviceReport({locked}, {}, {});
  EXPECT_TRUE(report[0].needs_rule);
  EXPECT_FALSE(report[0].usable);
  EXPECT_THAT(report[0].note, HasSubstr("udev rule"));
}

TEST(DeviceReport, NamesTheDesktopServiceThatHoldsTheCamera) {
  const auto report = MakeDeviceReport({kCamera}, kFound, {{kCamera.node, "gvfsd-gphoto2", 4711}});
  EXPECT_FALSE(report[0].usable);
  EXPECT_EQ(report[0].holder, "gvfsd-gphoto2 (process 4711)");
  EXPECT_THAT(report[0].note, HasSubstr("gvfs-gphoto2-volume-monitor"));
}

// Of another user's program, as a service is, the system shows that it holds the device and not which it is.
TEST(DeviceReport, SaysThatAProgramHoldsItThatWeMayNotLookInto) {
  UsbFound claimed = kWheel;
  claimed.claimed = true;
  const auto report = MakeDeviceReport({claimed}, {}, {});
  EXPECT_FALSE(report[0].usable);
  EXPECT_EQ(report[0].holder, "another user's program");
  EXPECT_THAT(report[0].note, HasSubstr("sudo dermap devices"));
  EXPECT_EQ(MakeDeviceReport({claimed}, {}, {{kWheel.node, "dermap", 4711}})[0].holder,
            "dermap (process 4711)");
}

TEST(DeviceReport, SaysWhichModeOfThe20DTakesFrames) {
  const UsbFound normal{0x04A9, 0x30EB, 1, 5, "/dev/bus/usb/001/005", true, true};
  const UsbFound ptp{0x04A9, 0x30EC, 1, 6, "/dev/bus/usb/001/006", true, true};
  const auto report = MakeDeviceReport({normal, ptp}, {}, {});
  EXPECT_THAT(report[0].note, HasSubstr("best effort"));
  EXPECT_TRUE(report[0].usable);
  EXPECT_THAT(report[1].note, HasSubstr("takes no frames"));
  EXPECT_FALSE(report[1].usable);
}

}  // namespace
}  // namespace dermap
