// SPDX-License-Identifier: Apache-2.0
// Any bytes at the door of a daemon that runs on the simulated station: as they come, or as the body of a
// request from whoever has the helm. The first byte chooses. The daemon answers what it was asked, never
// "internal error", and its state stays JSON.
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "acquire/daemon/http_server.h"
#include "tests/acquire/support.h"

namespace {

using namespace dermap;

constexpr int kPatience_ms = 10000;  // for an answer to a whole request
constexpr int kQuiet_ms = 20;        // what is no whole request is not waited for longer
constexpr std::size_t kMostRead = 1 << 20;
constexpr std::array kPaths{"steer", "release", "start", "answer", "pause", "continue", "abort", "retake"};

class Door {
 public:
  Door() {
    folder_.Write("scene.toml", acquire_test::SmallSceneToml());
    DaemonOptions options;
    options.rig = folder_.Write("rig.toml", acquire_test::SmallRigToml("scene.toml"));
    options.plan = folder_.Write("plan.toml", acquire_test::SmallPlanToml());
    options.root = folder_.path() / "sessions";
    daemon_ = std::make_unique<CaptureDaemon>(options);
    ServerOptions server;
    server.port = 0;
    server_ = std::make_unique<HttpServer>(*daemon_, server);
    std::thread([this] { server_->Run(); }).detach();
    TakeTheHelm();
  }

  // What comes back until the other side closes, or enough of it.
  std::string Send(const std::string& bytes, int patience_ms) const {
    const int file = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(server_->port()));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(file, reinterpret_cast<sockaddr*>(&to), sizeof to) != 0) std::abort();
    ::send(file, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    std::string answer;
    pollfd readable{file, POLLIN, 0};
    while (answer.size() < kMostRead && answer.find("text/event-stream") == std::string::npos &&
           ::poll(&readable, 1, patience_ms) > 0) {
      std::array<char, 65536> block;
      const ssize_t size = ::recv(file, block.data(), block.size(), 0);
      if (size <= 0) break;
      answer.append(block.data(), static_cast<std::size_t>(size));
    }
    ::close(file);
    return answer;
  }

  std::string Post(const std::string& path, const std::string& body) const {
    return Send("POST /api/" + path + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(server_->port()) +
                    "\r\nConnection: close\r\nContent-Type: application/json\r\nX-Dermap-Key: " + key_ +
                    "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body,
                kPatience_ms);
  }

  void TakeTheHelm() {
    const std::string answer = Post("steer", "{\"key\": \"" + key_ + "\"}");
    const auto at = answer.find("\r\n\r\n{");
    if (at == std::string::npos) std::abort();
    key_ = nlohmann::json::parse(answer.substr(at + 4)).at("key");
  }

  CaptureDaemon& daemon() { return *daemon_; }

 private:
  acquire_test::TemporaryFolder folder_;
  std::unique_ptr<CaptureDaemon> daemon_;
  std::unique_ptr<HttpServer> server_;
  std::string key_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Door& door = *new Door;  // its threads outlive main
  if (size == 0) return 0;
  const std::string bytes(data + 1, data + size);
  const std::size_t choice = data[0] % (kPaths.size() + 1);
  if (choice == kPaths.size()) {
    if (door.Send(bytes, kQuiet_ms).starts_with("HTTP/1.1 500")) std::abort();
  } else {
    door.TakeTheHelm();
    const std::string answer = door.Post(kPaths[choice], bytes);
    if (!answer.starts_with("HTTP/1.1 200") && !answer.starts_with("HTTP/1.1 4")) std::abort();
  }
  if (!door.daemon().State().is_object()) std::abort();
  return 0;
}
