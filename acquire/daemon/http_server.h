// SPDX-License-Identifier: Apache-2.0
// The daemon over HTTP: JSON, server-sent events, and the operator's page.
//
// GET  /                   the page
// GET  /api/schema         the JSON schema of all of it, api_schema.json
// GET  /api/state          the state, docs/daemon.md
// GET  /api/events         the same as server-sent events, whenever it changes
// GET  /api/frames/N.png   a small picture of a frame
// POST /api/steer          {"key": K or ""}: takes or keeps the helm; one client has it at a time
// POST /api/release        gives the helm up
// POST /api/start, /api/answer, /api/pause, /api/continue, /api/abort, /api/retake   with the helm's key
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "acquire/daemon/capture_daemon.h"

namespace dermap {

struct ServerOptions {
  std::string address = "127.0.0.1";
  int port = 8460;  // 0: any that is free
  std::string
      token;  // required of everyone where not empty; must not be empty unless the address is loopback
  std::chrono::milliseconds request_time{10000};  // that a request may take to come in
};

class HttpServer {
 public:
  // Throws InputError where it cannot listen there, or may not without a token.
  HttpServer(CaptureDaemon& daemon, ServerOptions options);
  ~HttpServer();
  int port() const;
  void Run();   // until Stop
  void Stop();  // from any thread

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dermap
