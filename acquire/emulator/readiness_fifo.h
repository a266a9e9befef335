// SPDX-License-Identifier: Apache-2.0
// The node of an emulated USB device, as far as libusb waits for it: writable exactly while a transfer is
// done. A FIFO, kept full while none is and drained once one is.
#pragma once

#include <filesystem>

namespace dermap::emulator {

class ReadinessFifo {
 public:
  explicit ReadinessFifo(const std::filesystem::path& path);
  ~ReadinessFifo();
  ReadinessFifo(const ReadinessFifo&) = delete;
  ReadinessFifo& operator=(const ReadinessFifo&) = delete;
  void Set(bool ready);
  void TakeAway();  // nobody can open it from here on

 private:
  std::filesystem::path path_, own_;
  int fd_ = -1;
  bool ready_ = true;
};

}  // namespace dermap::emulator
