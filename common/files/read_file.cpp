// SPDX-License-Identifier: Apache-2.0
// Whole files into memory, and their SHA-256.
#include <fcntl.h>
#include <openssl/evp.h>
#include <sys/stat.h>

#include <cerrno>
#include <memory>
#include <system_error>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/file_descriptor.h"

namespace dermap {
namespace {

// No file of ours comes near; a device or an endless pipe named by mistake ends here.
constexpr std::size_t kLargestFileBytes = std::size_t{8} << 30;

[[noreturn]] void ThrowUnreadable(const std::filesystem::path& path, const std::string& why,
                                  const char* remedy) {
  throw InputError("cannot read " + path.string() + ": " + why + "; remedy: " + remedy);
}

FileDescriptor OpenForReading(const std::filesystem::path& path) {
  FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.valid()) {
    ThrowUnreadable(path, std::generic_category().message(errno),
                    errno == ENOENT ? "check the path" : "check the path and the permissions");
  }
  struct stat status {};
  if (::fstat(file.get(), &status) == 0 && S_ISDIR(status.st_mode)) {
    ThrowUnreadable(path, "it is a folder, a file was expected", "name a file in it");
  }
  return file;
}

// Calls consume(data, size) piece by piece.
template <class Consume>
void ReadPieces(const std::filesystem::path& path, const Consume& consume) {
  const FileDescriptor file = OpenForReading(path);
  std::vector<char> buffer(std::size_t{1} << 18);
  std::size_t total = 0;
  while (true) {
    const ssize_t got = ::read(file.get(), buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) ThrowUnreadable(path, std::generic_category().message(errno), "check the disk");
    if (got == 0) return;
    total += static_cast<std::size_t>(got);
    if (total > kLargestFileBytes) ThrowUnreadable(path, "it is larger than 8 GiB", "name another file");
    consume(buffer.data(), static_cast<std::size_t>(got));
  }
}

class Sha256Digest {
 public:
  Sha256Digest() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    if (!context_ || EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1) {
      throw std::runtime_error("SHA-256 is not available in this OpenSSL");
    }
  }
  void Add(const void* data, std::size_t size) { EVP_DigestUpdate(context_.get(), data, size); }
  std::string Hex() {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned int size = 0;
    EVP_DigestFinal_ex(context_.get(), digest, &size);
    static constexpr char kDigits[] = "0123456789abcdef";
    std::string hex;
    for (unsigned int i = 0; i < size; ++i) {
      hex += kDigits[digest[i] >> 4];
      hex += kDigits[digest[i] & 15];
    }
    return hex;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

}  // namespace

std::string ReadTextFile(const std::filesystem::path& path) {
  std::string text;
  ReadPieces(path, [&](const char* data, std::size_t size) { text.append(data, size); });
  return text;
}

std::vector<std::byte> ReadBinaryFile(const std::filesystem::path& path) {
  std::vector<std::byte> bytes;
  std::error_code unknown;
  const auto expected = std::filesystem::file_size(path, unknown);
  if (!unknown && expected < kLargestFileBytes) bytes.reserve(expected);
  ReadPieces(path, [&](const char* data, std::size_t size) {
    const auto* first = reinterpret_cast<const std::byte*>(data);
    bytes.insert(bytes.end(), first, first + size);
  });
  return bytes;
}

void CheckReadable(const std::filesystem::path& path) {
  const FileDescriptor file = OpenForReading(path);
  struct stat status {};
  if (::fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode)) {
    ThrowUnreadable(path, "it is a device or a pipe, a file was expected", "save it to a file first");
  }
}

std::string Sha256OfFile(const std::filesystem::path& path) {
  Sha256Digest digest;
  ReadPieces(path, [&](const char* data, std::size_t size) { digest.Add(data, size); });
  return digest.Hex();
}

std::string Sha256(std::span<const std::byte> data) {
  Sha256Digest digest;
  digest.Add(data.data(), data.size());
  return digest.Hex();
}

}  // namespace dermap
