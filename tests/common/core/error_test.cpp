// SPDX-License-Identifier: Apache-2.0
// The exceptions carry the documented exit codes.
#include "common/core/error.h"

#include <gtest/gtest.h>

namespace dermap {
namespace {

// The exit codes of the commands as users' scripts rely on them: 0 done, 1 goal not reached, 2 bad usage or
// input, 3 device, 4 storage.
TEST(Error, CarriesTheExitCodeOfItsKind) {
  const auto code_of = [](const auto& error) {
    try {
      throw error;
    } catch (const Error& caught) {
      EXPECT_STREQ(caught.what(), "a sentence");
      return static_cast<int>(caught.code());
    }
  };
  EXPECT_EQ(code_of(InputError("a sentence")), 2);
  EXPECT_EQ(code_of(DeviceError("a sentence")), 3);
  EXPECT_EQ(code_of(StorageError("a sentence")), 4);
  EXPECT_EQ(code_of(Error(ExitCode::kGoalNotReached, "a sentence")), 1);
  EXPECT_EQ(static_cast<int>(ExitCode::kSuccess), 0);
}

}  // namespace
}  // namespace dermap
