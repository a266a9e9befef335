// SPDX-License-Identifier: Apache-2.0
// Layouts are those that libgphoto2's ptp-pack.c reads.
#include "acquire/emulator/eos_card.h"

#include <algorithm>
#include <cstdio>

namespace dermap::emulator {
namespace {

constexpr std::uint32_t kRootFolder = 0x91900000, kPictureFolder = 0x9190FFFF;
constexpr std::uint32_t kAll = 0xFFFFFFFF;
constexpr std::uint32_t kSomeTime = 1704099600;  // of every file: 2024-01-01 09:00

std::uint32_t SizeOf(const FutureFile& file) {
  return static_cast<std::uint32_t>(file.get().size());
}

}  // namespace

std::uint32_t EosCard::Store(FutureFile file, bool on_card) {
  char name[16];
  std::snprintf(name, sizeof name, "IMG_%04d.DNG", next_name_);
  next_name_ = next_name_ % 9999 + 1;
  objects_[next_handle_] = {name, std::move(file), on_card};
  return next_handle_++;
}

Bytes EosCard::Announcement(std::uint32_t handle) const {
  const auto found = objects_.find(handle);
  if (found == objects_.end()) return {};  // the card was changed meanwhile
  const Object& object = found->second;
  const std::uint32_t size = SizeOf(object.file);
  PtpWriter w;
  if (object.on_card) {
    w.U32(handle).U32(kEosStorage).U16(kEosRaw).Zeros(10).U32(size).U32(kPictureFolder).Zeros(4);
  } else {
    w.U32(handle).U16(kEosRaw).Zeros(6).U32(size).Zeros(4);
  }
  return w.Raw({object.name.begin(), object.name.end()}).Zeros(4).Take();
}

void EosCard::RemoveFiles() {
  std::erase_if(objects_, [](const auto& object) { return object.second.on_card; });
}

PtpReply EosCard::Handles(std::uint32_t parent) const {
  std::vector<std::uint32_t> handles;
  if (parent == kAll || parent == 0) handles.push_back(kRootFolder);
  if (parent == kRootFolder || parent == 0) handles.push_back(kPictureFolder);
  for (const auto& [handle, object] : objects_) {
    if (object.on_card && (parent == kPictureFolder || parent == 0)) handles.push_back(handle);
  }
  return PtpData(PtpWriter().Array32(handles).Take());
}

PtpReply EosCard::Info(std::uint32_t handle) const {
  const bool folder = handle == kRootFolder || handle == kPictureFolder;
  const auto found = objects_.find(handle);
  if (!folder && found == objects_.end()) return PtpResult(kPtpInvalidObject);
  const std::string name = handle == kRootFolder      ? "DCIM"
                           : handle == kPictureFolder ? "100EOS5D"
                                                      : found->second.name;
  const std::uint32_t parent = handle == kRootFolder      ? 0
                               : handle == kPictureFolder ? kRootFolder
                                                          : kPictureFolder;
  PtpWriter w;
  w.U32(kEosStorage).U16(folder ? kEosFolder : kEosRaw).U16(0);
  w.U32(folder ? 0 : SizeOf(found->second.file)).Zeros(26);
  w.U32(parent).U16(folder ? 1 : 0).Zeros(8).Text(name);
  w.Text("20240101T090000").Text("20240101T090000").Text("");
  return PtpData(w.Take());
}

PtpReply EosCard::Entries(std::uint32_t parent) const {
  PtpWriter entries;
  std::uint32_t count = 0;
  const auto add = [&](std::uint32_t handle, bool folder, std::uint32_t size, std::string name) {
    ++count;
    name.resize(16);
    entries.U32(60).U32(handle).U32(kEosStorage).U16(folder ? kEosFolder : kEosRaw).Zeros(6);
    entries.U32(folder ? 0x10 : 0).U32(size).Zeros(8).Raw({name.begin(), name.end()});
    entries.U32(kSomeTime).Zeros(4);
  };
  if (parent == kAll || parent == 0) add(kRootFolder, true, 0, "DCIM");
  if (parent == kRootFolder) add(kPictureFolder, true, 0, "100EOS5D");
  if (parent == kPictureFolder) {
    for (const auto& [handle, object] : objects_) {
      if (object.on_card) add(handle, false, SizeOf(object.file), object.name);
    }
  }
  return PtpData(PtpWriter().U32(count).Raw(entries.bytes()).Take());
}

PtpReply EosCard::Part(std::uint32_t handle, std::uint32_t offset, std::uint32_t size) const {
  const auto found = objects_.find(handle);
  if (found == objects_.end()) return PtpResult(kPtpInvalidObject);
  const Bytes& file = found->second.file.get();
  const std::size_t begin = std::min<std::size_t>(offset, file.size());
  const std::size_t end = std::min<std::size_t>(begin + size, file.size());
  PtpReply reply = PtpData(Bytes(file.begin() + static_cast<std::ptrdiff_t>(begin),
                                 file.begin() + static_cast<std::ptrdiff_t>(end)));
  reply.parameters = {static_cast<std::uint32_t>(end - begin)};
  return reply;
}

PtpReply EosCard::Erase(std::uint32_t handle) {
  return PtpResult(objects_.erase(handle) == 1 ? kPtpOk : kPtpInvalidObject);
}

}  // namespace dermap::emulator
