// SPDX-License-Identifier: Apache-2.0
// A Canon EOS 5D Mark II, as far as a capture needs it: the operations and events that libgphoto2 2.5.30
// uses. Numbers of properties and layouts of events are those of libgphoto2's ptp.h and ptp-pack.c.
#include "acquire/emulator/eos_camera.h"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>

namespace dermap::emulator {
namespace {

constexpr std::uint32_t kAperture = 0xD101, kShutterSpeed = 0xD102, kIso = 0xD103, kFocusMode = 0xD108,
                        kBattery = 0xD111, kAutoPowerOff = 0xD114, kAvailableShots = 0xD11B,
                        kCaptureDestination = 0xD11C, kCurrentStorage = 0xD11E, kImageFormat = 0xD120,
                        kViewfinderOutput = 0xD1B0;
constexpr std::uint32_t kToCard = 2, kToHost = 4;
constexpr std::uint32_t kObjectAdded = 0xC181, kObjectOffered = 0xC186, kValueChanged = 0xC189,
                        kChoicesChanged = 0xC18A, kViewfinderInfo = 0xC1A5;
constexpr std::uint32_t kStorage = 0x00020001, kRootFolder = 0x91900000, kPictureFolder = 0x9190FFFF;
constexpr std::uint16_t kFolder = 0x3001, kRaw = 0xB103;
constexpr std::uint32_t kRoomForShots = 999;
constexpr std::uint32_t kAll = 0xFFFFFFFF;

struct Step {
  std::uint32_t code;
  double value;
};
// Canon's codes of exposure times (ms) and ISO; third stops.
constexpr std::array kShutters{
    Step{0x58, 1000.0 / 15}, Step{0x5D, 40},          Step{0x60, 1000.0 / 30}, Step{0x63, 25},
    Step{0x65, 20},          Step{0x68, 1000.0 / 60}, Step{0x6B, 12.5},        Step{0x6D, 10},
    Step{0x70, 8},           Step{0x73, 6.25},        Step{0x75, 5},           Step{0x78, 4},
    Step{0x50, 125},         Step{0x40, 500},         Step{0x38, 1000},        Step{0x30, 2000}};
constexpr std::array kIsos{Step{0x48, 100},  Step{0x4B, 125},  Step{0x4D, 160},  Step{0x50, 200},
                           Step{0x53, 250},  Step{0x55, 320},  Step{0x58, 400},  Step{0x5B, 500},
                           Step{0x5D, 640},  Step{0x60, 800},  Step{0x63, 1000}, Step{0x65, 1250},
                           Step{0x68, 1600}, Step{0x70, 3200}, Step{0x78, 6400}};

template <class Steps>
double ValueOf(const Steps& steps, std::uint32_t code) {
  const auto found = std::find_if(steps.begin(), steps.end(), [&](const Step& s) { return s.code == code; });
  return found == steps.end() ? 0.0 : found->value;
}

template <class Steps>
std::vector<std::uint32_t> CodesOf(const Steps& steps) {
  std::vector<std::uint32_t> codes;
  for (const Step& s : steps) codes.push_back(s.code);
  return codes;
}

PtpReply WithData(Bytes data) {
  PtpReply reply;
  reply.data = std::move(data);
  return reply;
}

PtpReply Code(std::uint16_t code) {
  PtpReply reply;
  reply.code = code;
  return reply;
}

bool Signed(std::uint32_t property) {
  return property == kImageFormat;
}

}  // namespace

EosCamera::EosCamera(Exposure exposure, const CameraTiming& timing)
    : exposure_(std::move(exposure)), timing_(timing) {
  values_ = {{kAperture, 0x38},
             {kShutterSpeed, 0x6D},
             {kIso, 0x48},
             {kFocusMode, 3},
             {kBattery, 3},
             {kAutoPowerOff, 0},
             {kAvailableShots, kRoomForShots},
             {kCaptureDestination, kToCard},
             {kCurrentStorage, kStorage},
             {kImageFormat, 0},
             {kViewfinderOutput, 0}};
}

Clock::time_point EosCamera::In(double seconds) const {
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

void EosCamera::EndSession() {
  session_open_ = remote_ = false;
  events_.clear();
}

void EosCamera::ChangeCard() {
  faults.full_for_good = false;
  faults.full_until = {};
  std::erase_if(objects_, [](const auto& object) { return object.second.on_card; });
  values_[kAvailableShots] = kRoomForShots;
  TellValue(kAvailableShots);
}

PtpReply EosCamera::Handle(const PtpRequest& request) {
  PtpReply reply;
  if (Clock::now() < faults.silent_until) {
    reply.silent = true;
    return reply;
  }
  reply = Answer(request);
  double seconds = timing_.answer_s;
  if (reply.data && timing_.bytes_per_s > 0.0)
    seconds += static_cast<double>(reply.data->size()) / timing_.bytes_per_s;
  reply.after += std::chrono::duration<double>(seconds);
  if (Clock::now() < faults.silent_until) reply.silent = true;
  return reply;
}

PtpReply EosCamera::Answer(const PtpRequest& r) {
  if (r.operation == 0x1001) return DeviceInfo();
  if (r.operation == 0x1002) {
    if (session_open_) return Code(kPtpSessionAlreadyOpen);
    session_open_ = true;
    return {};
  }
  if (!session_open_) return Code(kPtpSessionNotOpen);
  switch (r.operation) {
    case 0x1003:
      EndSession();
      return {};
    case 0x1004:
    case 0x9101:
      return WithData(PtpWriter().Array32({kStorage}).Take());
    case 0x1005:
    case 0x9102:
      return StorageInfo();
    case 0x1007:
      return ObjectHandles(r);
    case 0x1008:
      return ObjectInfo(r.Parameter(0));
    case 0x1009:
    case 0x9104:
      return ObjectPart(r.Parameter(0), 0, kAll);
    case 0x100B:
    case 0x9105:
      return Code(objects_.erase(r.Parameter(0)) == 1 ? kPtpOk : kPtpInvalidObject);
    case 0x101B:
    case 0x9107:
      return ObjectPart(r.Parameter(0), r.Parameter(1), r.Parameter(2));
    case 0x9109:
      return FolderEntries(r.Parameter(1));
    case 0x9110:
      return SetProperty(r.data);
    case 0x9114:
      remote_ = r.Parameter(0) != 0;
      return {};
    case 0x9115:
      TellAll();
      return {};
    case 0x9116:
      return Events();
    case 0x9117:  // TransferComplete: what lay in RAM is let go of
      objects_.erase(r.Parameter(0));
      return {};
    case 0x911A:  // the host says that it has room
      TellValue(kAvailableShots);
      return {};
    case 0x911B:
    case 0x911C:
    case 0x911D:
      return {};
    case 0x9128:
      return Press(r.Parameter(0));
    case 0x9129:
      return {};
    default:
      return Code(kPtpNotSupported);
  }
}

PtpReply EosCamera::DeviceInfo() const {
  PtpWriter w;
  w.U16(100).U32(0x0000000B).U16(0x0100).Text("").U16(0);
  w.Array16({0x1001, 0x1002, 0x1003, 0x1004, 0x1005, 0x1007, 0x1008, 0x1009, 0x100B,
             0x101B, 0x9101, 0x9102, 0x9104, 0x9105, 0x9107, 0x9109, 0x9110, 0x9114,
             0x9115, 0x9116, 0x9117, 0x911A, 0x911B, 0x911C, 0x911D, 0x9128, 0x9129});
  w.Array16({0x4002, 0x4003, 0xC101}).Array16({}).Array16({kRaw}).Array16({kRaw, kFolder});
  w.Text("Canon Inc.").Text("Canon EOS 5D Mark II").Text("3-2.1.2").Text("emulated-0001");
  return WithData(w.Take());
}

PtpReply EosCamera::StorageInfo() const {
  PtpWriter w;
  w.U16(4).U16(3).U16(0).U64(32'000'000'000ULL);
  const std::uint32_t shots = values_.at(kAvailableShots);
  w.U64(shots * 30'000'000ULL).U32(shots).Text("CF").Text("EOS_DIGITAL");
  return WithData(w.Take());
}

PtpReply EosCamera::ObjectHandles(const PtpRequest& r) const {
  const std::uint32_t parent = r.Parameter(2);
  std::vector<std::uint32_t> handles;
  if (parent == kAll || parent == 0) handles.push_back(kRootFolder);
  if (parent == kRootFolder || parent == 0) handles.push_back(kPictureFolder);
  for (const auto& [handle, object] : objects_) {
    if (object.on_card && (parent == kPictureFolder || parent == 0)) handles.push_back(handle);
  }
  return WithData(PtpWriter().Array32(handles).Take());
}

PtpReply EosCamera::ObjectInfo(std::uint32_t handle) const {
  const bool folder = handle == kRootFolder || handle == kPictureFolder;
  const auto found = objects_.find(handle);
  if (!folder && found == objects_.end()) return Code(kPtpInvalidObject);
  const std::string name = handle == kRootFolder      ? "DCIM"
                           : handle == kPictureFolder ? "100EOS5D"
                                                      : found->second.name;
  const auto size = folder ? 0 : static_cast<std::uint32_t>(found->second.file.size());
  const std::uint32_t parent = handle == kRootFolder      ? 0
                               : handle == kPictureFolder ? kRootFolder
                                                          : kPictureFolder;
  PtpWriter w;
  w.U32(kStorage)
      .U16(folder ? kFolder : kRaw)
      .U16(0)
      .U32(size)
      .U16(0)
      .U32(0)
      .U32(0)
      .U32(0)
      .U32(0)
      .U32(0)
      .U32(0);
  w.U32(parent)
      .U16(folder ? 1 : 0)
      .U32(0)
      .U32(0)
      .Text(name)
      .Text("20240101T090000")
      .Text("20240101T090000")
      .Text("");
  return WithData(w.Take());
}

PtpReply EosCamera::FolderEntries(std::uint32_t parent) const {
  PtpWriter entries;
  std::uint32_t count = 0;
  const auto add = [&](std::uint32_t handle, bool folder, std::size_t size, std::string name) {
    ++count;
    name.resize(16);
    entries.U32(60).U32(handle).U32(kStorage).U16(folder ? kFolder : kRaw).Zeros(6).U32(folder ? 0x10 : 0);
    entries.U32(static_cast<std::uint32_t>(size))
        .Zeros(8)
        .Raw({name.begin(), name.end()})
        .U32(1704099600)
        .Zeros(4);
  };
  if (parent == kAll || parent == 0) add(kRootFolder, true, 0, "DCIM");
  if (parent == kRootFolder) add(kPictureFolder, true, 0, "100EOS5D");
  if (parent == kPictureFolder) {
    for (const auto& [handle, object] : objects_) {
      if (object.on_card) add(handle, false, object.file.size(), object.name);
    }
  }
  return WithData(PtpWriter().U32(count).Raw(entries.bytes()).Take());
}

PtpReply EosCamera::ObjectPart(std::uint32_t handle, std::uint32_t offset, std::uint32_t size) {
  const auto found = objects_.find(handle);
  if (found == objects_.end()) return Code(kPtpInvalidObject);
  if (faults.unplug_at_read && unplug) {
    faults.unplug_at_read = false;
    unplug(faults.unplug_seconds);
    PtpReply reply;
    reply.silent = true;
    return reply;
  }
  const Bytes& file = found->second.file;
  const std::size_t begin = std::min<std::size_t>(offset, file.size());
  const std::size_t end = std::min<std::size_t>(begin + size, file.size());
  PtpReply reply = WithData(Bytes(file.begin() + static_cast<std::ptrdiff_t>(begin),
                                  file.begin() + static_cast<std::ptrdiff_t>(end)));
  reply.parameters = {static_cast<std::uint32_t>(end - begin)};
  return reply;
}

PtpReply EosCamera::SetProperty(const Bytes& data) {
  if (data.size() < 12 || PtpU32(data, 0) > data.size()) return Code(kPtpInvalidParameter);
  const std::uint32_t property = PtpU32(data, 4);
  if (values_.count(property) == 0) return Code(kPtpInvalidParameter);
  if (Clock::now() < busy_until_) return Code(kPtpDeviceBusy);
  const std::uint32_t value = PtpU32(data, 8);
  if (property == kIso && ValueOf(kIsos, value) == 0.0) return Code(kPtpInvalidParameter);
  if (property == kShutterSpeed && ValueOf(kShutters, value) == 0.0) return Code(kPtpInvalidParameter);
  if (!Signed(property)) values_[property] = value;
  TellValue(property);
  return {};
}

PtpReply EosCamera::Events() {
  PtpWriter w;
  const auto now = Clock::now();
  for (auto it = events_.begin(); it != events_.end();) {
    if (it->when > now) {
      ++it;
      continue;
    }
    w.Raw(it->bytes);
    it = events_.erase(it);
  }
  return WithData(w.U32(8).U32(0).Take());
}

void EosCamera::Tell(std::uint32_t kind, const Bytes& payload, Clock::time_point when) {
  PtpWriter w;
  w.U32(static_cast<std::uint32_t>(8 + payload.size())).U32(kind).Raw(payload);
  events_.push_back({w.Take(), when});
}

void EosCamera::TellValue(std::uint32_t property) {
  PtpWriter w;
  w.U32(property);
  if (property == kImageFormat) {
    w.U32(1).U32(0x10).U32(6).U32(0).U32(4);  // one file: raw, large, lossless
  } else {
    w.U32(values_.at(property));
  }
  Tell(kValueChanged, w.bytes(), Clock::now());
}

void EosCamera::TellChoices(std::uint32_t property, const std::vector<std::uint32_t>& values) {
  PtpWriter w;
  w.U32(property).U32(3).Array32(values);
  Tell(kChoicesChanged, w.bytes(), Clock::now());
}

void EosCamera::TellAll() {
  for (const auto& [property, value] : values_) TellValue(property);
  TellChoices(kIso, CodesOf(kIsos));
  TellChoices(kShutterSpeed, CodesOf(kShutters));
  TellChoices(kCaptureDestination, {kToCard, kToHost});
  PtpWriter format;
  format.U32(kImageFormat).U32(3).U32(1).U32(1).U32(0x10).U32(6).U32(0).U32(4);
  Tell(kChoicesChanged, format.bytes(), Clock::now());
}

void EosCamera::Store(Bytes file, Clock::time_point when) {
  const bool on_card = values_[kCaptureDestination] != kToHost;
  const std::uint32_t handle = next_object_++;
  char name[16];
  std::snprintf(name, sizeof name, "IMG_%04d.DNG", next_name_++);
  const auto size = static_cast<std::uint32_t>(file.size());
  objects_[handle] = {name, std::move(file), on_card};
  const std::string text = name;
  PtpWriter w;
  if (on_card) {
    w.U32(handle).U32(kStorage).U16(kRaw).Zeros(10).U32(size).U32(kPictureFolder).Zeros(4);
  } else {
    w.U32(handle).U16(kRaw).Zeros(6).U32(size).Zeros(4);
  }
  w.Raw({text.begin(), text.end()}).Zeros(4);
  Tell(on_card ? kObjectAdded : kObjectOffered, w.bytes(), when);
}

PtpReply EosCamera::Press(std::uint32_t how_far) {
  if (!remote_) return Code(kPtpGeneralError);
  if (Clock::now() < busy_until_) return Code(kPtpDeviceBusy);
  if (how_far == 1) {  // half-way: it says that it is in focus
    Tell(kViewfinderInfo, PtpWriter().U32(14).U16(0x0100).U16(0).Zeros(4).U8(1).U8(0).Take(), Clock::now());
    return {};
  }
  const bool full = faults.full_for_good || Clock::now() < faults.full_until;
  if (!full) values_[kAvailableShots] = kRoomForShots;
  const auto fault = faults.AtPress();
  const auto strikes = [&](EosFault kind) { return fault && fault->fault == kind; };
  if (strikes(EosFault::kBusy)) return Code(kPtpDeviceBusy);
  if (strikes(EosFault::kHang)) {
    faults.silent_until = In(fault->seconds);
    PtpReply reply;
    reply.silent = true;
    return reply;
  }
  if (strikes(EosFault::kFull)) {
    faults.full_for_good = fault->seconds == 0.0;
    faults.full_until = In(fault->seconds);
  }
  if (full || strikes(EosFault::kFull)) {
    values_[kAvailableShots] = 0;
    TellValue(kAvailableShots);
    return Code(kPtpStoreFull);
  }
  if (strikes(EosFault::kSleep) && unplug) {
    unplug(fault->seconds);
    PtpReply reply;
    reply.silent = true;
    return reply;
  }
  if (strikes(EosFault::kTaken) && taken) {
    taken(fault->seconds);
    PtpReply reply;
    reply.silent = true;
    return reply;
  }
  if (strikes(EosFault::kKilled)) ::kill(::getpid(), SIGKILL);
  if (strikes(EosFault::kStall)) faults.stalled = true;
  if (strikes(EosFault::kRam)) values_[kCaptureDestination] = kToHost;
  if (strikes(EosFault::kSettings)) values_[kIso] = 0x60;

  const double exposure_ms = ValueOf(kShutters, values_[kShutterSpeed]);
  Bytes file = exposure_(exposure_ms, static_cast<int>(ValueOf(kIsos, values_[kIso])));
  ++shots_;
  const Bytes exposed = file;
  if (strikes(EosFault::kTruncated)) file.resize(file.size() / 2);
  if (strikes(EosFault::kRepeated) && !last_file_.empty()) file = last_file_;
  last_file_ = exposed;
  const double open_s = timing_.shutter_lag_s + timing_.exposure_scale * exposure_ms / 1000.0;
  busy_until_ = In(open_s);
  const double late_s = strikes(EosFault::kLate) ? fault->seconds : 0.0;
  if (!strikes(EosFault::kMissing)) Store(std::move(file), In(open_s + timing_.store_s + late_s));
  if (strikes(EosFault::kRam)) TellValue(kCaptureDestination);
  if (strikes(EosFault::kUnplugRead)) {
    faults.unplug_at_read = true;
    faults.unplug_seconds = fault->seconds;
  }
  if (strikes(EosFault::kUnplug) && unplug) unplug(fault->seconds);
  return {};
}

}  // namespace dermap::emulator
