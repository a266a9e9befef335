// SPDX-License-Identifier: Apache-2.0
// A packet: length, kind, payload. Kinds: 1 and 2 command's greeting and its answer, 3 and 4 the event's, 6
// request, 7 response, 9 start of data, 10 data, 12 last data, 13 and 14 probe.
#include "acquire/emulator/ptp_ip.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "common/core/error.h"

namespace dermap::emulator {
namespace {

constexpr int kStep_ms = 50;  // how often it looks whether to stop
constexpr std::size_t kLargestPacket = 1 << 20;
constexpr std::size_t kBlock = 65536;
constexpr std::uint32_t kLastData = 12;

void Close(int& file) {
  if (file >= 0) ::close(file);
  file = -1;
}

}  // namespace

PtpIp::PtpIp(EosCamera& camera, std::mutex& lock, int port) : camera_(camera), lock_(lock) {
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int yes = 1;
  ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  socklen_t size = sizeof address;
  if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 || ::listen(listener_, 4) != 0 ||
      ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    Close(listener_);
    throw DeviceError("the emulated camera cannot listen on port " + std::to_string(port) +
                      "; remedy: name one that is free");
  }
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this] { Serve(); });
}

PtpIp::~PtpIp() {
  stopping_ = true;
  thread_.join();
  CloseAll();
  Close(listener_);
}

void PtpIp::CloseAll() {
  Close(command_);
  Close(event_);
  begun_.reset();
  const std::lock_guard lock(lock_);
  camera_.EndSession();
}

void PtpIp::Drop(double seconds) {
  down_until_ =
      (Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds)))
          .time_since_epoch()
          .count();
}

bool PtpIp::Down() const {
  return Clock::now().time_since_epoch().count() < down_until_;
}

void PtpIp::Serve() {
  while (!stopping_) {
    std::array<pollfd, 2> waits{pollfd{listener_, POLLIN, 0}, pollfd{command_, POLLIN, 0}};
    ::poll(waits.data(), command_ >= 0 ? 2 : 1, kStep_ms);
    if (Down()) {
      if (command_ >= 0) CloseAll();
      if ((waits[0].revents & POLLIN) != 0) {
        int refused = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
        Close(refused);
      }
      continue;
    }
    if ((waits[0].revents & POLLIN) != 0) Accept();
    if (command_ < 0 || (waits[1].revents & (POLLIN | POLLHUP | POLLERR)) == 0) continue;
    Bytes packet;
    if (!Read(command_, packet) || !ServeRequest(packet)) CloseAll();
  }
}

void PtpIp::Accept() {
  int file = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
  if (file < 0) return;
  const int yes = 1;
  ::setsockopt(file, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  Bytes packet;
  if (!Read(file, packet)) return Close(file);
  const std::uint32_t kind = PtpU32(packet, 0);
  if (kind == 1) {  // a new client takes the place of the one before, as cameras do it
    CloseAll();
    command_ = file;
    PtpWriter w;
    w.U32(1).Zeros(16);
    for (const char c : std::string("EOS5D2")) w.U16(static_cast<unsigned char>(c));
    Send(command_, 2, w.U16(0).U32(0x00010000).Take());
  } else if (kind == 3 && command_ >= 0) {
    Close(event_);
    event_ = file;
    Send(event_, 4, {});
  } else {
    Close(file);
  }
}

bool PtpIp::Read(int file, Bytes& packet) {
  const auto read_all = [&](std::size_t size, Bytes& into) {
    into.resize(size);
    for (std::size_t done = 0; done < size;) {
      pollfd wait{file, POLLIN, 0};
      if (stopping_ || Down()) return false;
      if (::poll(&wait, 1, kStep_ms) <= 0) continue;
      const ssize_t got = ::recv(file, into.data() + done, size - done, 0);
      if (got <= 0) return false;
      done += static_cast<std::size_t>(got);
    }
    return true;
  };
  Bytes length;
  if (!read_all(4, length)) return false;
  const std::size_t size = PtpU32(length, 0);
  return size >= 8 && size <= kLargestPacket && read_all(size - 4, packet);
}

bool PtpIp::Send(int file, std::uint32_t kind, const Bytes& payload) {
  PtpWriter w;
  w.U32(static_cast<std::uint32_t>(8 + payload.size())).U32(kind).Raw(payload);
  const Bytes& all = w.bytes();
  for (std::size_t done = 0; done < all.size();) {
    const ssize_t sent = ::send(file, all.data() + done, all.size() - done, MSG_NOSIGNAL);
    if (sent <= 0) return false;
    done += static_cast<std::size_t>(sent);
  }
  return true;
}

bool PtpIp::ServeRequest(const Bytes& p) {
  const std::uint32_t kind = PtpU32(p, 0);
  if (kind == 6) {
    PtpRequest request{PtpU16(p, 8), PtpU32(p, 10), {}, {}};
    for (std::size_t at = 14; at + 4 <= p.size(); at += 4) request.parameters.push_back(PtpU32(p, at));
    if (!PtpTakesData(request.operation)) return Reply(request);
    begun_ = std::move(request);
    return true;
  }
  if ((kind == 10 || kind == kLastData) && begun_ && p.size() >= 8) {
    begun_->data.insert(begun_->data.end(), p.begin() + 8, p.end());
    if (kind != kLastData) return begun_->data.size() <= kLargestPacket;
    const PtpRequest request = std::move(*begun_);
    begun_.reset();
    return Reply(request);
  }
  if (kind == 13) return Send(command_, 14, {});
  return kind == 9;
}

bool PtpIp::Reply(const PtpRequest& request) {
  PtpReply reply;
  {
    const std::lock_guard lock(lock_);
    reply = camera_.Handle(request);
  }
  if (reply.silent) return true;
  std::this_thread::sleep_for(reply.after);
  if (reply.data) {
    const Bytes& data = *reply.data;
    if (!Send(command_, 9, PtpWriter().U32(request.transaction).U64(data.size()).Take())) return false;
    std::size_t at = 0;
    do {
      const std::size_t end = std::min(at + kBlock, data.size());
      PtpWriter w;
      w.U32(request.transaction)
          .Raw(Bytes(data.begin() + static_cast<std::ptrdiff_t>(at),
                     data.begin() + static_cast<std::ptrdiff_t>(end)));
      if (!Send(command_, end == data.size() ? kLastData : 10, w.bytes())) return false;
      at = end;
    } while (at < data.size());
  }
  PtpWriter w;
  w.U16(reply.code).U32(request.transaction);
  for (const std::uint32_t parameter : reply.parameters) w.U32(parameter);
  return Send(command_, 7, w.bytes());
}

}  // namespace dermap::emulator
