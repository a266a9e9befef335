// SPDX-License-Identifier: Apache-2.0
// The journal's file: append, fsync, lock, and repair of a torn end.
#include "common/files/session_journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <nlohmann/json.hpp>
#include <system_error>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/file_descriptor.h"

namespace dermap {

struct Journal::Impl {
  std::filesystem::path path;
  FileDescriptor file;
  off_t length = 0;  // of what is confirmed
};

namespace {

// A folder that cannot be synced is as good as it gets.
void SyncFolder(const std::filesystem::path& folder) {
  const FileDescriptor directory(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (directory.valid()) ::fsync(directory.get());
}

FileDescriptor OpenLocked(const std::filesystem::path& path) {
  std::error_code error;
  const auto made = MissingFolders(path.parent_path());
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
  if (error) ThrowStorageError("create the folder of", path, error.value());
  FileDescriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
  if (!file.valid()) ThrowStorageError("write", path, errno);
  if (::flock(file.get(), LOCK_EX | LOCK_NB) != 0) {
    throw InputError(
        path.string() +
        " is in use by another capture; remedy: wait for it to end, or name another session folder");
  }
  // The names of the journal and of its folders must survive a power cut too.
  SyncFolder(path.has_parent_path() ? path.parent_path() : ".");
  for (const auto& folder : made) SyncFolder(folder.has_parent_path() ? folder.parent_path() : ".");
  return file;
}

}  // namespace

Journal::Journal(const std::filesystem::path& path)
    : impl_(std::make_unique<Impl>(Impl{path, OpenLocked(path), 0})) {
  const std::string text = ReadTextFile(path);
  const std::size_t last_break = text.rfind('\n');
  impl_->length = last_break == std::string::npos ? 0 : static_cast<off_t>(last_break + 1);
  if (impl_->length != static_cast<off_t>(text.size()) &&
      ::ftruncate(impl_->file.get(), impl_->length) != 0) {
    ThrowStorageError("repair", path, errno);
  }
  if (::lseek(impl_->file.get(), impl_->length, SEEK_SET) < 0) ThrowStorageError("write", path, errno);
}

Journal::~Journal() = default;
Journal::Journal(Journal&&) noexcept = default;

void Journal::Append(const nlohmann::json& event) {
  const std::string line = event.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  int error = WriteAll(impl_->file.get(), line);
  if (error == 0 && ::fsync(impl_->file.get()) != 0) error = errno;
  if (error == 0) {
    impl_->length += static_cast<off_t>(line.size());
    return;
  }
  // Back to the last confirmed line; should even that fail, the next opening drops the torn one.
  if (::ftruncate(impl_->file.get(), impl_->length) == 0) ::lseek(impl_->file.get(), impl_->length, SEEK_SET);
  ThrowStorageError("write", impl_->path, error);
}

std::vector<nlohmann::json> ReadJournal(const std::filesystem::path& path) {
  std::vector<nlohmann::json> events;
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return events;
  const std::string text = ReadTextFile(path);
  std::size_t begin = 0;
  for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', begin)) {
    nlohmann::json event = nlohmann::json::parse(text.begin() + begin, text.begin() + end, nullptr, false);
    if (!event.is_object()) {
      throw InputError(
          path.string() + " line " + std::to_string(events.size() + 1) +
          " is not a JSON object; remedy: restore the journal from a copy, or start a new session");
    }
    events.push_back(std::move(event));
    begin = end + 1;
  }
  return events;
}

}  // namespace dermap
