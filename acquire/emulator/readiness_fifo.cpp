// SPDX-License-Identifier: Apache-2.0
// Full and empty.
#include "acquire/emulator/readiness_fifo.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <system_error>

#include "common/core/error.h"

namespace dermap::emulator {
namespace {

constexpr int kBytes = 4096;

}  // namespace

ReadinessFifo::ReadinessFifo(const std::filesystem::path& path) : path_(path), own_(path) {
  std::error_code ignored;
  std::filesystem::create_directories(path.parent_path(), ignored);
  // Opened under another name: whoever looks for programs that have the node open shall find its clients
  // alone.
  own_.replace_filename(std::string(1, '.').append(path.filename().string()));
  if (::mkfifo(own_.c_str(), 0666) != 0) throw DeviceError("cannot make " + own_.string());
  fd_ = ::open(own_.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0 || ::link(own_.c_str(), path_.c_str()) != 0) throw DeviceError("cannot open " + own_.string());
  ::fcntl(fd_, F_SETPIPE_SZ, kBytes);
  Set(false);
}

ReadinessFifo::~ReadinessFifo() {
  TakeAway();
  ::close(fd_);
}

void ReadinessFifo::TakeAway() {
  ::unlink(path_.c_str());
  ::unlink(own_.c_str());
}

void ReadinessFifo::Set(bool ready) {
  if (ready == ready_) return;
  ready_ = ready;
  std::array<char, kBytes> block{};
  if (ready) {
    while (::read(fd_, block.data(), block.size()) > 0) {
    }
  } else {
    while (::write(fd_, block.data(), block.size()) > 0) {
    }
  }
}

}  // namespace dermap::emulator
