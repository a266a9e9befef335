// SPDX-License-Identifier: Apache-2.0
// Files that are whole or absent: written under a temporary name beside the target, fsynced, renamed.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace dermap {

// Calls write(temporary_path), which must create that file, then fsyncs it and renames it onto `path` (and
// fsyncs the folder). Whatever fails, the temporary file is removed and `path` is left as it was. Parent
// folders are created. Throws StorageError for what the system refuses; exceptions of `write` pass through.
// The temporary name keeps the extension of `path`, since image libraries choose the format by it.
void WriteFileAtomically(const std::filesystem::path& path,
                         const std::function<void(const std::filesystem::path& temporary)>& write);
void WriteFileAtomically(const std::filesystem::path& path, std::string_view contents);
void WriteFileAtomically(const std::filesystem::path& path, std::span<const std::byte> contents);

// Files that belong together. While a batch lives, what this thread writes with WriteFileAtomically stays
// under temporary names; Commit() renames all in the order in which they were written (so write last what
// names the others). Without Commit(), as when a disk is full half-way, none of them appears and the old ones
// stay. A batch inside a batch is part of the outer one.
class FileBatch {
 public:
  FileBatch();
  ~FileBatch();
  FileBatch(const FileBatch&) = delete;
  FileBatch& operator=(const FileBatch&) = delete;
  void Commit();

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

// Whole file; throws InputError naming the file and why.
std::string ReadTextFile(const std::filesystem::path& path);
std::vector<std::byte> ReadBinaryFile(const std::filesystem::path& path);

// Throws InputError unless `path` is a file that can be read: for libraries that open files by name.
void CheckReadable(const std::filesystem::path& path);

// Hexadecimal SHA-256.
std::string Sha256OfFile(const std::filesystem::path& path);
std::string Sha256(std::span<const std::byte> data);

}  // namespace dermap
