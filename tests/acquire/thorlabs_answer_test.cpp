// SPDX-License-Identifier: Apache-2.0
// Dialogues as the wheels' manual shows them, and nonsense.
#include "acquire/devices/thorlabs_answer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "acquire/devices/device_fault.h"

namespace dermap {
namespace {

TEST(ThorlabsAnswer, StandsBetweenEchoAndPrompt) {
  EXPECT_EQ(ThorlabsAnswer("wheel", "pos?", "pos?\r7\r> "), "7");
  EXPECT_EQ(ThorlabsAnswer("wheel", "pos=7", "pos=7\r> "), "");
  EXPECT_EQ(ThorlabsNumber("wheel", "12"), 12);
}

TEST(ThorlabsAnswer, OfAnErrorOrNoNumberIsAFaultWithoutControlCharacters) {
  EXPECT_THROW(ThorlabsAnswer("wheel", "x", "x\rCommand error CMD_NOT_DEFINED\r> "), DeviceFault);
  for (const char* text : {"", "0", "65", "-1", "7a", "99999999999999999999", "\x1b[2J"}) {
    try {
      ThorlabsNumber("wheel", text);
      ADD_FAILURE() << text;
    } catch (const DeviceFault& fault) {
      EXPECT_EQ(std::string(fault.what()).find('\x1b'), std::string::npos);
    }
  }
}

// Another maker's thing behind the same bridge, and the answer of a wheel by its manual.
TEST(ThorlabsAnswer, TellsAWheelFromOtherThings) {
  EXPECT_NO_THROW(RequireThorlabsWheel("THORLABS FW102C/FW212C Filter Wheel version 1.07"));
  for (const char* text : {"", "ARDUINO", "\x1b[2J\x07"}) {
    try {
      RequireThorlabsWheel(text);
      ADD_FAILURE() << text;
    } catch (const DeviceFault& fault) {
      EXPECT_EQ(std::string(fault.what()).find('\x1b'), std::string::npos);
      EXPECT_NE(std::string(fault.what()).find("remedy"), std::string::npos);
    }
  }
}

TEST(ThorlabsAnswer, LeavesOutTheBridgesStatus) {
  const std::vector<std::uint8_t> packet{0x01, 0x60, 'p', '>'};
  EXPECT_EQ(PayloadOfPacket(packet), "p>");
  EXPECT_EQ(PayloadOfPacket(std::span(packet).first(2)), "");
  EXPECT_EQ(PayloadOfPacket({}), "");
}

TEST(ThorlabsAnswer, OfRandomPacketsIsAnAnswerOrAFault) {
  std::mt19937 random(11);
  const std::string alphabet = "pos?=0123456789> \r\nCommand error\x80\xff";
  for (int i = 0; i < 20000; ++i) {
    std::vector<std::uint8_t> packet(random() % 70);
    for (auto& b : packet) b = static_cast<std::uint8_t>(alphabet[random() % alphabet.size()]);
    const std::string text = PayloadOfPacket(packet);
    try {
      const int number = ThorlabsNumber("wheel", ThorlabsAnswer("wheel", "pos?", text));
      EXPECT_TRUE(number >= 1 && number <= 64);
    } catch (const DeviceFault&) {
    }
  }
}

}  // namespace
}  // namespace dermap
