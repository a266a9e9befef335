// SPDX-License-Identifier: Apache-2.0
// What a confused camera or helper says reaches neither the names of files nor the program's types.
#include "acquire/devices/camera_helper.h"

#include <gtest/gtest.h>

namespace dermap {
namespace {

TEST(FrameExtension, IsTheCamerasInLowerCase) {
  EXPECT_EQ(FrameExtension("IMG_0001.CR2"), ".cr2");
  EXPECT_EQ(FrameExtension("a.b.dng"), ".dng");
}

TEST(FrameExtension, IsRawWhereTheCamerasIsNoneForAFile) {
  for (const char* name :
       {"", "IMG_0001", "IMG_0001.", ".", "x.\x1b[2J", "x.a/b", "x.jpegs", "x.\xc3\xa4", "x.a b"})
    EXPECT_EQ(FrameExtension(name), ".raw") << name;
}

TEST(CameraAnswer, OfAnotherTypeCountsAsMissing) {
  const CameraAnswer odd{R"({"ok": 1, "code": "x", "what": 7, "model": null})", {}};
  EXPECT_FALSE(odd.Says("ok"));
  EXPECT_EQ(odd.Number("code", -3), -3);
  EXPECT_EQ(odd.Text("what"), "");
  EXPECT_EQ(odd.Text("model"), "");
  EXPECT_EQ(CameraAnswer({"[[", {}}).Text("what"), "");
}

}  // namespace
}  // namespace dermap
