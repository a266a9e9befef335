// SPDX-License-Identifier: Apache-2.0
// A child process that opens the file and says nothing.
#include "common/files/raw_guard.h"

#include <fcntl.h>
#include <libraw/libraw.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>

namespace dermap {
namespace {

constexpr int kFewestSide_px = 16, kMostSide_px = 20000;
constexpr long long kMostPhotosites = 200'000'000;
constexpr std::size_t kHead_bytes = 1U << 18U;  // where makers' names stand, and at the end
constexpr std::string_view kMaker = "hasselblad";

bool Names(std::string_view bytes) {
  const auto same = [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; };
  return std::search(bytes.begin(), bytes.end(), kMaker.begin(), kMaker.end(), same) != bytes.end();
}

bool NamesMaker(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes(kHead_bytes, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  const auto got = static_cast<std::size_t>(file.gcount());
  if (Names(std::string_view(bytes).substr(0, got))) return true;
  if (got < kHead_bytes) return false;
  file.seekg(-static_cast<std::streamoff>(kHead_bytes), std::ios::end);
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return Names(std::string_view(bytes).substr(0, static_cast<std::size_t>(file.gcount())));
}

bool NamesMaker(std::span<const std::byte> file) {
  const std::string_view bytes(reinterpret_cast<const char*>(file.data()), file.size());
  const std::size_t end = bytes.size() > kHead_bytes ? bytes.size() - kHead_bytes : 0;
  return Names(bytes.substr(0, kHead_bytes)) || Names(bytes.substr(end));
}

// Whether a process that does no more than `open` lives on.
template <class Open>
bool Survives(const Open& open_by) {
  const pid_t child = fork();
  if (child == 0) {
    for (const int deadly : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE}) std::signal(deadly, SIG_DFL);
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDERR_FILENO);  // libc tells of the overrun
    const auto raw = std::make_unique<LibRaw>(LIBRAW_OPIONS_NO_DATAERR_CALLBACK);
    open_by(*raw);
    _exit(0);
  }
  int status = 0;
  while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return child > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace

std::string RawSizeProblem(const RawSizes& s) {
  const std::string found = std::to_string(s.width) + "x" + std::to_string(s.height) + " photosites";
  if (s.width < kFewestSide_px || s.height < kFewestSide_px) return found + ", which is too small";
  if (s.raw_width > kMostSide_px || s.raw_height > kMostSide_px ||
      static_cast<long long>(s.raw_width) * s.raw_height > kMostPhotosites)
    return found + ", which is too large";
  if (s.left + s.width > s.raw_width || s.top + s.height > s.raw_height)
    return "an active area that exceeds the sensor";
  return "";
}

bool SurvivesLibRaw(const std::filesystem::path& path) {
  return !NamesMaker(path) || Survives([&](LibRaw& raw) { raw.open_file(path.c_str()); });
}

bool SurvivesLibRaw(std::span<const std::byte> file) {
  if (!NamesMaker(file)) return true;
  // LibRaw only reads from the buffer; its interface lacks the const.
  return Survives([&](LibRaw& raw) { raw.open_buffer(const_cast<std::byte*>(file.data()), file.size()); });
}

}  // namespace dermap
