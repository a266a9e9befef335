// SPDX-License-Identifier: Apache-2.0
// PTP over TCP/IP (CIPA DC-005) on loopback: a command and an event connection to the same port, one client
// at a time.
#pragma once

#include <atomic>
#include <mutex>
#include <thread>

#include "acquire/emulator/eos_camera.h"

namespace dermap::emulator {

class PtpIp {
 public:
  // Listens on 127.0.0.1; port 0 takes any that is free. `lock` is held over each call of the camera.
  PtpIp(EosCamera& camera, std::mutex& lock, int port = 0);
  ~PtpIp();
  int port() const { return port_; }
  // As if the network were gone: connections end, new ones are refused for this long.
  void Drop(double seconds);

 private:
  void Serve();
  void Accept();
  bool Read(int file, Bytes& packet);  // one packet without its length; false at the end
  bool ServeRequest(const Bytes& packet);
  bool Reply(const PtpRequest& request);
  void CloseAll();
  bool Send(int file, std::uint32_t kind, const Bytes& payload);
  bool Down() const;

  EosCamera& camera_;
  std::mutex& lock_;
  int listener_ = -1;
  int port_ = 0;
  int command_ = -1, event_ = -1;
  std::atomic<bool> stopping_{false};
  std::atomic<Clock::rep> down_until_{0};
  std::optional<PtpRequest> begun_;  // waits for its data
  std::thread thread_;
};

}  // namespace dermap::emulator
