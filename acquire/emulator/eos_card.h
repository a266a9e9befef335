// SPDX-License-Identifier: Apache-2.0
// What lies on an emulated EOS's card, and in its memory: folders and files as PTP objects. A file is being
// made while its event already waits, as a camera writes it while the host goes on.
#pragma once

#include <future>
#include <map>
#include <string>

#include "acquire/emulator/ptp.h"

namespace dermap::emulator {

using FutureFile = std::shared_future<Bytes>;

class EosCard {
 public:
  // Returns the object's handle.
  std::uint32_t Store(FutureFile file, bool on_card);
  // What the camera says of a new one; waits until it is made.
  Bytes Announcement(std::uint32_t handle) const;
  void RemoveFiles();  // another card was put in; what is in the memory stays

  PtpReply Handles(std::uint32_t parent) const;
  PtpReply Info(std::uint32_t handle) const;
  PtpReply Entries(std::uint32_t parent) const;
  PtpReply Part(std::uint32_t handle, std::uint32_t offset, std::uint32_t size) const;
  PtpReply Erase(std::uint32_t handle);

 private:
  struct Object {
    std::string name;
    FutureFile file;
    bool on_card = true;
  };
  std::map<std::uint32_t, Object> objects_;
  std::uint32_t next_handle_ = 0x91900001;
  int next_name_ = 1;
};

inline constexpr std::uint32_t kEosStorage = 0x00020001;
inline constexpr std::uint16_t kEosRaw = 0xB103, kEosFolder = 0x3001;

}  // namespace dermap::emulator
