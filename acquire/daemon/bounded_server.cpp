// SPDX-License-Identifier: Apache-2.0
// The library's server on a stream of our own.
#include "acquire/daemon/bounded_server.h"

#include <httplib.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>

namespace dermap {
namespace {

using std::chrono::milliseconds;
using SteadyClock = std::chrono::steady_clock;

constexpr milliseconds kWritePatience{5000};
constexpr milliseconds kLookForTheEnd{100};
constexpr int kLooksWhileIdle = 50;
constexpr milliseconds kLinger{300};          // for what a client still sends after its answer,
constexpr std::size_t kMostUnread = 1 << 20;  // and how much of it

class Connection : public httplib::Stream {
 public:
  Connection(socket_t socket, const RequestLimits& limits) : socket_(socket), limits_(limits) {}
  ~Connection() override;

  bool Awaits(milliseconds limit) const { return begin_ < end_ || Wait(POLLIN, limit); }
  void BeginRequest() {
    left_ = limits_.bytes;
    until_ = SteadyClock::now() + limits_.time;
  }

  bool is_readable() const override { return Awaits(milliseconds(0)); }
  bool is_writable() const override { return Wait(POLLOUT, kWritePatience) && !HasGone(); }
  ssize_t read(char* to, std::size_t size) override;
  ssize_t write(const char* from, std::size_t size) override {
    return Wait(POLLOUT, kWritePatience) ? ::send(socket_, from, size, MSG_NOSIGNAL) : -1;
  }
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return socket_; }

 private:
  bool Wait(short events, milliseconds limit) const {
    pollfd file{socket_, events, 0};
    return ::poll(&file, 1, static_cast<int>(limit.count())) > 0;
  }
  bool HasGone() const {
    char byte = 0;
    return Wait(POLLIN, milliseconds(0)) && ::recv(socket_, &byte, 1, MSG_PEEK | MSG_DONTWAIT) <= 0;
  }
  bool Fill();

  socket_t socket_;
  RequestLimits limits_;
  std::size_t left_ = 0;
  SteadyClock::time_point until_{};
  std::array<char, 4096> buffer_{};
  std::size_t begin_ = 0, end_ = 0;  // of what was read from the socket and not used yet
};

bool Connection::Fill() {
  const auto left = std::chrono::duration_cast<milliseconds>(until_ - SteadyClock::now());
  if (left.count() <= 0 || !Wait(POLLIN, left)) return false;
  const ssize_t size = ::recv(socket_, buffer_.data(), buffer_.size(), 0);
  if (size <= 0) return false;
  begin_ = 0;
  end_ = static_cast<std::size_t>(size);
  return true;
}

ssize_t Connection::read(char* to, std::size_t size) {
  if (left_ == 0 || (begin_ == end_ && !Fill())) return -1;
  const std::size_t taken = std::min({size, end_ - begin_, left_});
  std::copy_n(buffer_.data() + begin_, taken, to);
  begin_ += taken;
  left_ -= taken;
  return static_cast<ssize_t>(taken);
}

// Closing a socket with unread bytes takes back the answer that is on its way.
Connection::~Connection() {
  ::shutdown(socket_, SHUT_WR);
  until_ = SteadyClock::now() + kLinger;
  for (std::size_t unread = 0; unread < kMostUnread && Fill(); unread += end_) {
  }
  ::close(socket_);
}

class BoundedServer : public httplib::Server {
 public:
  explicit BoundedServer(const RequestLimits& limits) : limits_(limits) {}

 private:
  bool process_and_close_socket(socket_t socket) override {
    Connection connection(socket, limits_);
    for (std::size_t left = keep_alive_max_count_; left > 0 && AwaitRequest(connection); --left) {
      bool closes = false, stays = false;
      const auto prepare = [&](httplib::Request& request) {
        request.ranges.clear();  // a short head can ask for the same bytes a thousand times
        stays = request.method == "GET" && !request.has_header("Content-Length") &&
                !request.has_header("Transfer-Encoding");
        if (stays) return;
        request.headers.erase("Connection");
        request.headers.emplace("Connection", "close");
      };
      connection.BeginRequest();
      if (!process_request(connection, left == 1, closes, prepare)) return false;
      if (closes || !stays) break;
    }
    return true;
  }

  bool AwaitRequest(const Connection& connection) const {
    for (int look = 0; look < kLooksWhileIdle && svr_sock_ != INVALID_SOCKET; ++look)
      if (connection.Awaits(kLookForTheEnd)) return true;
    return false;
  }

  RequestLimits limits_;
};

}  // namespace

std::unique_ptr<httplib::Server> MakeBoundedServer(const RequestLimits& limits) {
  return std::make_unique<BoundedServer>(limits);
}

}  // namespace dermap
