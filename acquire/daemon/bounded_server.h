// SPDX-License-Identifier: Apache-2.0
// An HTTP server that reads no more of a request than so many bytes, and no longer than so long, whatever the
// request says of itself. The library by itself bounds neither a line of the head, nor how many there are,
// nor a body in chunks.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>

namespace httplib {
class Server;
}

namespace dermap {

struct RequestLimits {
  std::size_t bytes;  // head and body
  std::chrono::milliseconds time;
};

// Only a GET without a body leaves its connection open: of any other request a part may have been left
// unread, and would be taken for the next one.
std::unique_ptr<httplib::Server> MakeBoundedServer(const RequestLimits& limits);

}  // namespace dermap
