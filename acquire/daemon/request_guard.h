// SPDX-License-Identifier: Apache-2.0
// Who may ask: whether a request comes from where it says, and whoever sends it may send it. Knows nothing of
// HTTP's libraries.
#pragma once

#include <string>

namespace dermap {

// An address of this machine that no other can reach: 127.x.y.z, ::1 or "localhost"; no other name, whatever
// it leads to.
bool IsLoopback(const std::string& address);

// Whether a browser that was led here by another site, or by a name that leads elsewhere, would send this.
bool HostIsOurs(const std::string& host, const std::string& address, int port);
bool OriginIsOurs(const std::string& origin, const std::string& host);

// Takes the same time for every wrong token of a length.
bool SameToken(const std::string& a, const std::string& b);

// 32 hexadecimal digits that nobody can guess.
std::string RandomKey();

}  // namespace dermap
