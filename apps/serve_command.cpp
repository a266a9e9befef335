// SPDX-License-Identifier: Apache-2.0
// dermap serve --rig RIG.toml: the capture daemon.
#include <malloc.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "acquire/daemon/capture_daemon.h"
#include "acquire/daemon/http_server.h"
#include "acquire/daemon/service_manager.h"
#include "apps/command_line.h"
#include "apps/commands.h"
#include "apps/daemon_address.h"
#include "common/tissue/tissue.h"

namespace dermap {
namespace {

std::atomic<bool> end_asked{false};

void AskToEnd(int) {
  end_asked = true;
}

Outcome Serve(const DaemonOptions& options, const ServerOptions& listen) {
  mallopt(M_ARENA_MAX, 2);  // eighty threads that mostly wait need no heap each
  CaptureDaemon daemon(options);
  HttpServer server(daemon, listen);
  std::signal(SIGINT, AskToEnd);
  std::signal(SIGTERM, AskToEnd);
  std::fprintf(stderr, "dermap serve: http://%s:%d/  sessions in %s\n", listen.address.c_str(), server.port(),
               options.root.c_str());
  std::thread watch([&] {
    TellServiceManager("READY=1");
    const auto interval = WatchdogInterval();
    auto next = std::chrono::steady_clock::now();
    while (!end_asked) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      if (!interval || std::chrono::steady_clock::now() < next) continue;
      daemon.Version();  // takes the daemon's lock: one that hangs is not alive
      TellServiceManager("WATCHDOG=1");
      next = std::chrono::steady_clock::now() + *interval;
    }
    TellServiceManager("STOPPING=1");
    server.Stop();
  });
  server.Run();
  end_asked = true;
  watch.join();
  Outcome outcome;
  outcome.text = "the daemon has ended\n";
  outcome.fill_json = [](nlohmann::json&) {};
  return outcome;
}

}  // namespace

int RunServeCommand(int argc, char** argv) {
  CommandLine command("serve", "Run the station for the operator's page and for programs.");
  DaemonOptions options;
  options.plan = ConfigDirectory() / "plans/standard.toml";
  options.root = "sessions";
  std::string listen = "127.0.0.1:8460";
  std::filesystem::path token_file;
  command.app().add_option("--rig", options.rig, "rig.toml: camera, wheel, filters, references")->required();
  command.app().add_option("--plan", options.plan, "plan.toml: exposure and ISO for every filter");
  command.app().add_option("--root", options.root, "The folder that session folders are made in");
  command.app().add_option("--listen", listen, "ADDRESS:PORT; beyond this machine only with a token");
  command.app().add_option("--token-file", token_file, "A file with a token that everyone has to show");
  return command.Run(argc, argv, [&] {
    options.on_request = [](const OperatorRequest& request) {
      std::fprintf(stderr, "%s\n", RequestLine(request).c_str());
    };
    ServerOptions server = ParseDaemonAddress("--listen", listen);
    server.token = ReadDaemonToken(token_file);
    return Serve(options, server);
  });
}

}  // namespace dermap
