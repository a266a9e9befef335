// SPDX-License-Identifier: Apache-2.0
// Reading the flags.
#include "apps/daemon_address.h"

#include <algorithm>

#include "common/core/error.h"
#include "common/files/atomic_file.h"

namespace dermap {
namespace {

constexpr std::size_t kLongestToken = 1000;

}  // namespace

ServerOptions ParseDaemonAddress(const std::string& flag, const std::string& listen) {
  const auto colon = listen.rfind(':');
  ServerOptions options;
  const std::string port = colon == std::string::npos ? "" : listen.substr(colon + 1);
  const bool digits =
      !port.empty() && port.size() <= 5 && port.find_first_not_of("0123456789") == std::string::npos;
  options.port = digits ? std::stoi(port) : -1;
  options.address = listen.substr(0, colon == std::string::npos ? 0 : colon);
  if (options.address.empty() || options.port < 0 || options.port > 65535) {
    throw InputError(flag + " is '" + listen + "'; expected ADDRESS:PORT, such as 127.0.0.1:8460");
  }
  return options;
}

std::string ReadDaemonToken(const std::filesystem::path& path) {
  if (path.empty()) return "";
  std::string token = ReadTextFile(path);
  while (!token.empty() && (token.back() == '\n' || token.back() == '\r')) token.pop_back();
  if (token.size() < 16)
    throw InputError(path.string() + " holds fewer than 16 characters; expected a token to guard");
  const bool printable = std::all_of(token.begin(), token.end(), [](char c) { return c > ' ' && c <= '~'; });
  if (!printable || token.size() > kLongestToken) {
    throw InputError(
        path.string() +
        " is no token; expected one line of 16 to 1000 letters, digits and signs, without blanks");
  }
  return token;
}

}  // namespace dermap
