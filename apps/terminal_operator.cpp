// SPDX-License-Identifier: Apache-2.0
// One line out, one line in.
#include "apps/terminal_operator.h"

#include <poll.h>
#include <unistd.h>

#include <cstdio>

namespace dermap {
namespace {

constexpr int kLookEvery_ms = 100;

}  // namespace

AskOperator AskOnTerminal(std::function<bool()> stop) {
  return [stop = std::move(stop)](const OperatorRequest& request) {
    std::fprintf(stderr, "\n%s Then press Enter; Ctrl-C ends the session, to be resumed.\n",
                 RequestLine(request).c_str());
    std::fflush(stderr);
    while (!stop()) {
      pollfd input{0, POLLIN, 0};
      if (::poll(&input, 1, kLookEvery_ms) <= 0) continue;
      char c = 0;
      if (::read(0, &c, 1) <= 0) return false;
      if (c == '\n') return true;
    }
    return false;
  };
}

}  // namespace dermap
