// SPDX-License-Identifier: Apache-2.0
// Within this folder: an owned POSIX file descriptor, a write that is complete or failed, and the sentence
// for failures.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace dermap {

class FileDescriptor {
 public:
  explicit FileDescriptor(int descriptor) : descriptor_(descriptor) {}
  ~FileDescriptor() { Close(); }
  FileDescriptor(FileDescriptor&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }

  bool valid() const noexcept { return descriptor_ >= 0; }
  int get() const noexcept { return descriptor_; }
  // 0, or -1 with errno: network file systems tell of a full disk only here.
  int Close() noexcept {
    const int descriptor = std::exchange(descriptor_, -1);
    return descriptor >= 0 ? ::close(descriptor) : 0;
  }

 private:
  int descriptor_;
};

// `folder` and those above it that are not there, the deepest first.
std::vector<std::filesystem::path> MissingFolders(std::filesystem::path folder);

// Writes all of `data`; 0, or the errno of what stopped it.
int WriteAll(int descriptor, std::string_view data) noexcept;

// "cannot WHAT PATH: No space left on device; remedy: ..."
[[noreturn]] void ThrowStorageError(const std::string& what, const std::filesystem::path& path, int error);

}  // namespace dermap
