// SPDX-License-Identifier: Apache-2.0
// What a killed program has left goes; what another has, or made for something else, stays.
#include "acquire/devices/private_home.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/acquire/support.h"

namespace dermap {
namespace {

namespace fs = std::filesystem;

class Home : public testing::Test {
 protected:
  Home() { setenv("TMPDIR", folder_.path().c_str(), 1); }
  ~Home() override { unsetenv("TMPDIR"); }
  fs::path Make(const std::string& name) const {
    fs::create_directories(folder_.path() / name / "below");
    return folder_.path() / name;
  }
  static void Age(const fs::path& folder) {
    fs::last_write_time(folder, fs::file_time_type::clock::now() - std::chrono::hours(1));
  }
  acquire_test::TemporaryFolder folder_;
};

TEST_F(Home, GoesWithItsOwner) {
  fs::path path;
  {
    const PrivateHome home;
    path = home.path();
    EXPECT_TRUE(fs::is_directory(path));
  }
  EXPECT_FALSE(fs::exists(path));
}

TEST_F(Home, TakesAwayWhatIsNobodysAnyMore) {
  const PrivateHome living;
  const fs::path left = Make("dermap-camera-killed"), young = Make("dermap-camera-young"),
                 other = Make("other");
  for (const fs::path& folder : {living.path(), left, other}) Age(folder);
  const PrivateHome home;
  EXPECT_FALSE(fs::exists(left));
  EXPECT_TRUE(fs::exists(living.path()));
  EXPECT_TRUE(fs::exists(young));
  EXPECT_TRUE(fs::exists(other));
}

}  // namespace
}  // namespace dermap
