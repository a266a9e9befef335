// SPDX-License-Identifier: Apache-2.0
// Starts the tests under libumockdev's preload library, so that libusb in this process (and its children)
// sees the emulated bus in place of the machine's own.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "acquire/emulator/usb_bus.h"

int main(int argc, char** argv) {
#if defined(DERMAP_SANITIZED) && !defined(DERMAP_STATIC_ASAN)
  // A sanitizer's runtime and the preload library each insist on being the first to be loaded.
  std::puts("skipped under this sanitizer: libumockdev's preload library does not work beside its runtime");
  return 0;
#endif
  const std::string preload = dermap::emulator::kPreloadLibrary;
  const char* set = std::getenv("LD_PRELOAD");
  if (set == nullptr || std::string(set).find(preload) == std::string::npos) {
    setenv("LD_PRELOAD", preload.c_str(), 1);
    // For AddressSanitizer, whose runtime is in the program. libgphoto2 and GLib keep what they allocate
    // once.
    setenv("ASAN_OPTIONS", "verify_asan_link_order=0:detect_leaks=0", 0);
    execv("/proc/self/exe", argv);
    std::perror("execv");
    return 1;
  }
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
