// SPDX-License-Identifier: Apache-2.0
// Names, numbers and secrets.
#include "acquire/daemon/request_guard.h"

#include <arpa/inet.h>
#include <sys/random.h>

#include <cstdio>

#include "common/core/error.h"

namespace dermap {
namespace {

constexpr int kPortLeftOut = 80;  // browsers do not say it

}  // namespace

bool IsLoopback(const std::string& address) {
  in_addr number{};
  if (::inet_pton(AF_INET, address.c_str(), &number) == 1) return ntohl(number.s_addr) >> 24 == 127;
  return address == "::1" || address == "localhost";
}

bool HostIsOurs(const std::string& host, const std::string& address, int port) {
  const std::string number = std::to_string(port);
  for (const std::string& name :
       {std::string("127.0.0.1"), std::string("localhost"), std::string("[::1]"), address}) {
    if (host == std::string(name).append(1, ':').append(number)) return true;
    if (port == kPortLeftOut && host == name) return true;
  }
  return false;
}

bool OriginIsOurs(const std::string& origin, const std::string& host) {
  return origin.empty() || origin == "http://" + host;
}

bool SameToken(const std::string& a, const std::string& b) {
  unsigned difference = static_cast<unsigned>(a.size() ^ b.size());
  for (std::size_t i = 0; i < a.size() && !b.empty(); ++i) {
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i % b.size()]);
  }
  return difference == 0;
}

std::string RandomKey() {
  unsigned char bytes[16];
  if (getrandom(bytes, sizeof bytes, 0) != sizeof bytes)
    throw DeviceError("the system gives no random numbers");
  std::string text;
  char digits[3];
  for (const unsigned char b : bytes) {
    std::snprintf(digits, sizeof digits, "%02x", b);
    text += digits;
  }
  return text;
}

}  // namespace dermap
