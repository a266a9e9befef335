// SPDX-License-Identifier: Apache-2.0
// The progress bar keeps quiet where stderr is not a terminal.
#include "common/core/progress.h"

#include <gtest/gtest.h>
#include <unistd.h>

namespace dermap {
namespace {

// What progress.h promises: log files and pipes never see a bar.
TEST(ProgressBar, IsSilentOffTheTerminal) {
  testing::internal::CaptureStderr();  // stderr is a file from here on
  ASSERT_EQ(isatty(STDERR_FILENO), 0);
  {
    ProgressBar bar("fit");
    bar.Update(0.5);
    const ProgressFunction function = bar.Function();
    function(1.0);
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace dermap
