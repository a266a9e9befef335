// SPDX-License-Identifier: Apache-2.0
// Files that are whole or absent, on POSIX: temporary name, fsync, rename, fsync of the folder.
#include "common/files/atomic_file.h"

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "common/core/error.h"
#include "common/files/file_descriptor.h"

namespace dermap {
namespace {

namespace fs = std::filesystem;

const char* RemedyFor(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
      return "free some space or choose another folder";
    case EROFS:
    case EACCES:
    case EPERM:
      return "choose a folder that you may write to";
    case EFBIG:
      return "raise the file size limit (ulimit -f) or choose another file system";
    case ENOTDIR:
    case EEXIST:
      return "choose a folder whose path does not lead through a file";
    case EISDIR:
      return "name a file, not a folder";
    default:
      return "check the path and the disk, or choose another folder";
  }
}

// A symbolic link is written through, as an ordinary open() would.
fs::path ResolveTarget(const fs::path& path) {
  std::error_code ignored;
  fs::path target = path;
  if (fs::is_symlink(path, ignored)) target = fs::weakly_canonical(path, ignored);
  if (target.empty()) target = path;
  const fs::file_status status = fs::status(target, ignored);
  if (fs::is_directory(status)) ThrowStorageError("write", path, EISDIR);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw StorageError(
        "cannot write " + path.string() +
        ": it is a device or a pipe, a regular file was expected; remedy: name a file in a folder");
  }
  return target;
}

fs::path TemporaryFor(const fs::path& target) {
  static std::atomic<int> counter{0};
  return target.parent_path() / fmt::format(".{}.partial-{}-{}{}", target.stem().string().substr(0, 120),
                                            ::getpid(), counter++, target.extension().string());
}

fs::path FolderOf(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

void CreateFolder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(FolderOf(path), error);
  if (error) ThrowStorageError("create the folder of", path, error.value());
}

void SyncFile(const fs::path& file, const fs::path& shown) {
  const FileDescriptor descriptor(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  if (!descriptor.valid() || ::fsync(descriptor.get()) != 0) ThrowStorageError("write", shown, errno);
}

// Some file systems refuse to sync a folder (EINVAL); then the rename is as durable as they can make it.
void SyncFolder(const fs::path& folder, const fs::path& shown) {
  const FileDescriptor descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!descriptor.valid()) return;  // a folder may be writable but not readable
  if (::fsync(descriptor.get()) != 0 && errno != EINVAL && errno != ENOTSUP) {
    ThrowStorageError("write", shown, errno);
  }
}

// The temporary file of one target, removed unless it was renamed.
class Staged {
 public:
  explicit Staged(const fs::path& path) : shown_(path) {
    CreateFolder(path);
    target_ = ResolveTarget(path);
    temporary_ = TemporaryFor(target_);
  }
  ~Staged() {
    if (!committed_) ::unlink(temporary_.c_str());
  }
  Staged(const Staged&) = delete;
  Staged& operator=(const Staged&) = delete;

  const fs::path& temporary() const { return temporary_; }
  void Sync() const { SyncFile(temporary_, shown_); }
  void Commit() {
    if (::rename(temporary_.c_str(), target_.c_str()) != 0) ThrowStorageError("write", shown_, errno);
    committed_ = true;
    SyncFolder(FolderOf(target_), shown_);
  }
  void Write(std::string_view contents) const {
    FileDescriptor file(::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (!file.valid()) ThrowStorageError("write", shown_, errno);
    if (const int error = WriteAll(file.get(), contents)) ThrowStorageError("write", shown_, error);
    if (::fsync(file.get()) != 0) ThrowStorageError("write", shown_, errno);
    if (file.Close() != 0) ThrowStorageError("write", shown_, errno);
  }

 private:
  fs::path shown_;  // as the caller named it, for messages
  fs::path target_;
  fs::path temporary_;
  bool committed_ = false;
};

}  // namespace

int WriteAll(int descriptor, std::string_view data) noexcept {
  while (!data.empty()) {
    const ssize_t written = ::write(descriptor, data.data(), data.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return errno;
    }
    data.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

void ThrowStorageError(const std::string& what, const fs::path& path, int error) {
  throw StorageError("cannot " + what + " " + path.string() + ": " + std::generic_category().message(error) +
                     "; remedy: " + RemedyFor(error));
}

void WriteFileAtomically(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  Staged staged(path);
  write(staged.temporary());
  staged.Sync();
  staged.Commit();
}

void WriteFileAtomically(const fs::path& path, std::string_view contents) {
  Staged staged(path);
  staged.Write(contents);
  staged.Commit();
}

void WriteFileAtomically(const fs::path& path, std::span<const std::byte> contents) {
  WriteFileAtomically(path,
                      std::string_view(reinterpret_cast<const char*>(contents.data()), contents.size()));
}

void WriteFilesTogether(std::span<const FileContents> files) {
  std::vector<std::unique_ptr<Staged>> staged;
  for (const FileContents& file : files) {
    staged.push_back(std::make_unique<Staged>(file.path));
    staged.back()->Write(file.contents);
  }
  for (const auto& file : staged) file->Commit();
}

}  // namespace dermap
