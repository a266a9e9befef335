// SPDX-License-Identifier: Apache-2.0
// A session taken by a daemon that runs already: this program is one more of its clients.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "acquire/daemon/capture_daemon.h"
#include "acquire/daemon/http_server.h"
#include "acquire/devices/operator.h"
#include "common/core/progress.h"

namespace dermap {

struct RemoteSession {
  ServerOptions daemon;  // where it listens, and its token
  SessionForm form;
  ProgressFunction progress;
  // Asks whoever sits here; the second function says when nobody needs to answer any more (somebody has
  // elsewhere, or `stop`). Returns whether it is done.
  std::function<bool(const OperatorRequest&, const std::function<bool()>&)> ask;
  std::function<bool()> stop;  // true ends the session, to be resumed
};

struct RemoteSummary {
  bool complete = false;
  int done = 0, total = 0;
  std::vector<std::string> warnings;
};

// Returns when the session has come to its end. Throws InputError where no daemon answers or it refuses,
// DeviceError where the session failed or the daemon went away.
RemoteSummary RunOnDaemon(const RemoteSession& session);

}  // namespace dermap
