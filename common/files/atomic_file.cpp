// SPDX-License-Identifier: Apache-2.0
// Files that are whole or absent, on POSIX: temporary name, fsync, rename, fsync of the folder.
#include "common/files/atomic_file.h"

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <memory>
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

// Makes the folder of a file; returns the folders that were not there before, the deepest first.
std::vector<fs::path> CreateFolder(const fs::path& path) {
  std::error_code error;
  const std::vector<fs::path> made = MissingFolders(FolderOf(path));
  fs::create_directories(FolderOf(path), error);
  if (error) {
    for (const fs::path& folder : made) ::rmdir(folder.c_str());
    ThrowStorageError("create the folder of", path, error.value());
  }
  return made;
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

// The temporary file of one target. Unless it is renamed, it goes, and so do the folders that were made for
// it.
class Staged {
 public:
  explicit Staged(const fs::path& path)
      : shown_(path), target_(ResolveTarget(path)), made_(CreateFolder(target_)) {
    temporary_ = TemporaryFor(target_);
  }
  ~Staged() {
    if (committed_) return;
    ::unlink(temporary_.c_str());
    for (const fs::path& folder : made_) ::rmdir(folder.c_str());
  }
  Staged(const Staged&) = delete;
  Staged& operator=(const Staged&) = delete;

  const fs::path& temporary() const { return temporary_; }
  void Sync() const { SyncFile(temporary_, shown_); }
  void Commit() {
    if (::rename(temporary_.c_str(), target_.c_str()) != 0) ThrowStorageError("write", shown_, errno);
    committed_ = true;
    SyncFolder(FolderOf(target_), shown_);
    for (const fs::path& folder : made_) SyncFolder(FolderOf(folder), shown_);  // a new folder's own name
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
  std::vector<fs::path> made_;
  fs::path temporary_;
  bool committed_ = false;
};

}  // namespace

struct FileBatch::Impl {
  std::vector<std::unique_ptr<Staged>> files;

  // Last in, first out: a folder goes after what was to lie in it.
  ~Impl() {
    while (!files.empty()) files.pop_back();
  }
};

namespace {

thread_local FileBatch::Impl* current_batch = nullptr;

// Where a file goes that is written and synced: to its place, or to the batch of this thread.
void CommitOrKeep(std::unique_ptr<Staged> staged) {
  if (current_batch) {
    current_batch->files.push_back(std::move(staged));
  } else {
    staged->Commit();
  }
}

}  // namespace

std::vector<fs::path> MissingFolders(fs::path folder) {
  std::vector<fs::path> missing;
  std::error_code error;
  for (; !folder.empty() && !fs::exists(folder, error) && !error; folder = folder.parent_path())
    missing.push_back(folder);
  return missing;
}

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

FileBatch::FileBatch() {
  if (current_batch) return;  // part of the batch around it, which commits
  impl_ = std::make_unique<Impl>();
  current_batch = impl_.get();
}

FileBatch::~FileBatch() {
  if (impl_) current_batch = nullptr;
}

void FileBatch::Commit() {
  if (!impl_) return;
  for (const auto& file : impl_->files) file->Commit();
  impl_->files.clear();
}

void WriteFileAtomically(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  auto staged = std::make_unique<Staged>(path);
  write(staged->temporary());
  staged->Sync();
  CommitOrKeep(std::move(staged));
}

void WriteFileAtomically(const fs::path& path, std::string_view contents) {
  auto staged = std::make_unique<Staged>(path);
  staged->Write(contents);
  CommitOrKeep(std::move(staged));
}

void WriteFileAtomically(const fs::path& path, std::span<const std::byte> contents) {
  WriteFileAtomically(path,
                      std::string_view(reinterpret_cast<const char*>(contents.data()), contents.size()));
}

}  // namespace dermap
