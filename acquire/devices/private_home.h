// SPDX-License-Identifier: Apache-2.0
// A folder of our own for the helper's HOME, among the system's temporary ones: gone with us, or, where we
// were killed, with the next one that is made.
#pragma once

#include <filesystem>

#include "common/files/file_descriptor.h"

namespace dermap {

class PrivateHome {
 public:
  // Removes what killed programs have left as well. Throws StorageError where it cannot be made.
  PrivateHome();
  ~PrivateHome();
  PrivateHome(const PrivateHome&) = delete;
  PrivateHome& operator=(const PrivateHome&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  FileDescriptor lock_;  // the system lets go of it however we end
};

}  // namespace dermap
