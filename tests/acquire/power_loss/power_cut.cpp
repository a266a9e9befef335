// SPDX-License-Identifier: Apache-2.0
// A power cut, for a program that has this library preloaded: at the N-th change below DERMAP_POWER_ROOT (a
// write, sync, rename, new file or folder) all that was never synced is taken back, and the process is
// killed. Harsher than most disks: nothing unsynced survives, no rename and no new name before its folder was
// synced.
#include <dlfcn.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

template <class Function>
Function Real(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

// A name in a folder that is not on disk yet, and how to take it back.
struct PendingName {
  std::string folder, path;
  std::string moved_from;  // empty: it was made there
  std::string replaced;    // a copy of what it replaced; empty: nothing
  bool is_folder = false;
};

struct Disk {
  std::recursive_mutex mutex;  // taking back renames too
  std::string root;
  long cut_at = 0, changes = 0;
  std::map<std::string, off_t> synced_bytes;  // of files that were written to
  std::vector<PendingName> names;
  int copies = 0;

  Disk() {
    const char* r = std::getenv("DERMAP_POWER_ROOT");
    const char* n = std::getenv("DERMAP_POWER_CUT_AT");
    root = r == nullptr ? "" : r;
    cut_at = n == nullptr ? 0 : std::atol(n);
  }
  bool Mine(const std::string& path) const { return cut_at > 0 && !root.empty() && path.rfind(root, 0) == 0; }

  void TakeBack() {
    for (const auto& [path, bytes] : synced_bytes) {
      if (::truncate(path.c_str(), bytes) != 0) continue;  // it is gone already
    }
    for (auto name = names.rbegin(); name != names.rend(); ++name) {
      std::error_code ignored;
      if (!name->moved_from.empty()) fs::rename(name->path, name->moved_from, ignored);
      if (!name->replaced.empty()) fs::rename(name->replaced, name->path, ignored);
      if (name->moved_from.empty()) fs::remove_all(name->path, ignored);
    }
  }
  // Before each change; does not return from the last.
  void Change() {
    if (++changes < cut_at) return;
    cut_at = 0;  // what we do ourselves is no change
    TakeBack();
    ::kill(::getpid(), SIGKILL);
  }
};

Disk& TheDisk() {
  static Disk* disk = new Disk;  // outlives whatever writes while the program ends
  return *disk;
}

std::string PathOf(int file) {
  char link[64], path[PATH_MAX];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  const ssize_t size = ::readlink(link, path, sizeof path - 1);
  return size <= 0 ? "" : std::string(path, static_cast<std::size_t>(size));
}

std::string Absolute(const char* path) {
  std::error_code ignored;
  return fs::absolute(path, ignored).lexically_normal().string();
}

// A file is made, or one that is there is opened to be written.
void NoteOpen(const char* path, int flags) {
  if ((flags & (O_CREAT | O_WRONLY | O_RDWR)) == 0) return;
  Disk& disk = TheDisk();
  const std::lock_guard lock(disk.mutex);
  const std::string name = Absolute(path);
  if (!disk.Mine(name)) return;
  struct stat known {};
  if (::stat(name.c_str(), &known) == 0) {
    disk.synced_bytes.try_emplace(name, known.st_size);
  } else if ((flags & O_CREAT) != 0) {
    disk.Change();
    disk.names.push_back({fs::path(name).parent_path().string(), name, "", "", false});
    disk.synced_bytes[name] = 0;
  }
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(more, mode_t) : 0;
  va_end(more);
  NoteOpen(path, flags);
  return Real<int (*)(const char*, int, ...)>("open")(path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(more, mode_t) : 0;
  va_end(more);
  NoteOpen(path, flags);
  return Real<int (*)(const char*, int, ...)>("open64")(path, flags, mode);
}

ssize_t write(int file, const void* data, size_t size) {
  Disk& disk = TheDisk();
  if (disk.cut_at > 0 && file > 2) {
    const std::lock_guard lock(disk.mutex);
    if (disk.Mine(PathOf(file))) disk.Change();
  }
  return Real<ssize_t (*)(int, const void*, size_t)>("write")(file, data, size);
}

int fsync(int file) {
  Disk& disk = TheDisk();
  const std::lock_guard lock(disk.mutex);
  const std::string path = PathOf(file);
  if (disk.Mine(path)) disk.Change();
  struct stat known {};
  ::fstat(file, &known);
  if (S_ISDIR(known.st_mode)) {
    std::erase_if(disk.names, [&](const PendingName& name) { return name.folder == path; });
  } else {
    disk.synced_bytes[path] = known.st_size;
  }
  return 0;  // nothing is gained by waiting for the disk here
}

int rename(const char* from, const char* to) {
  Disk& disk = TheDisk();
  const std::lock_guard lock(disk.mutex);
  const std::string source = Absolute(from), target = Absolute(to);
  if (disk.Mine(target)) {
    disk.Change();
    PendingName name{fs::path(target).parent_path().string(), target, source, "", false};
    if (::access(target.c_str(), F_OK) == 0) {
      name.replaced = disk.root + "." + std::to_string(disk.copies++) + ".before";
      if (::link(target.c_str(), name.replaced.c_str()) != 0) name.replaced.clear();
    }
    disk.names.push_back(name);
    disk.synced_bytes[target] = disk.synced_bytes[source];
    disk.synced_bytes.erase(source);
  }
  return Real<int (*)(const char*, const char*)>("rename")(from, to);
}

int mkdir(const char* path, mode_t mode) {
  Disk& disk = TheDisk();
  const std::lock_guard lock(disk.mutex);
  const std::string name = Absolute(path);
  if (disk.Mine(name) && ::access(name.c_str(), F_OK) != 0) {
    disk.Change();
    disk.names.push_back({fs::path(name).parent_path().string(), name, "", "", true});
  }
  return Real<int (*)(const char*, mode_t)>("mkdir")(path, mode);
}

int ftruncate(int file, off_t size) {
  Disk& disk = TheDisk();
  const std::lock_guard lock(disk.mutex);
  if (disk.Mine(PathOf(file))) disk.Change();
  return Real<int (*)(int, off_t)>("ftruncate")(file, size);
}

}  // extern "C"
