// SPDX-License-Identifier: Apache-2.0
// A folder that nobody has locked is nobody's any more.
#include "acquire/devices/private_home.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/file.h>

#include <chrono>
#include <string>
#include <system_error>

#include "common/core/error.h"

namespace dermap {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPrefix = "dermap-camera-";
constexpr std::chrono::minutes kYoung{1};  // one that has just been made may not be locked yet

// Not valid where another has locked it.
FileDescriptor Lock(const fs::path& folder) {
  FileDescriptor lock(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  if (lock.valid() && ::flock(lock.get(), LOCK_EX | LOCK_NB) != 0) lock.Close();
  return lock;
}

void RemoveWhatIsNobodys(const fs::path& among) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(among, error)) {
    if (!entry.path().filename().string().starts_with(kPrefix)) continue;
    std::error_code gone;
    const auto changed = fs::last_write_time(entry.path(), gone);
    if (gone || fs::file_time_type::clock::now() - changed < kYoung) continue;
    if (Lock(entry.path()).valid()) fs::remove_all(entry.path(), gone);
  }
}

fs::path Make() {
  const fs::path among = fs::temp_directory_path();
  RemoveWhatIsNobodys(among);
  std::string name = (among / (std::string(kPrefix) + "XXXXXX")).string();
  if (::mkdtemp(name.data()) != nullptr) return name;
  throw StorageError("cannot make a folder in " + among.string() +
                     "; remedy: free some space there, or let TMPDIR name another folder");
}

}  // namespace

PrivateHome::PrivateHome() : path_(Make()), lock_(Lock(path_)) {}

PrivateHome::~PrivateHome() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace dermap
