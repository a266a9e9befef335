// SPDX-License-Identifier: Apache-2.0
// A Canon EOS 5D Mark II, as far as a capture needs it: the operations and events that libgphoto2 2.5.30
// uses. Numbers and layouts of events are those of libgphoto2's ptp.h and ptp-pack.c.
#include "acquire/emulator/eos_camera.h"

#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>

namespace dermap::emulator {
namespace {

constexpr std::uint32_t kObjectAdded = 0xC181, kObjectOffered = 0xC186, kValueChanged = 0xC189,
                        kChoicesChanged = 0xC18A, kViewfinderInfo = 0xC1A5;
constexpr std::uint32_t kAll = 0xFFFFFFFF;
constexpr int kNicer = 5;

// A real camera takes nothing of the host's processors: this thread stands back behind the host's programs.
void StandBack() {
  ::setpriority(PRIO_PROCESS, 0, ::getpriority(PRIO_PROCESS, 0) + kNicer);
}

}  // namespace

EosCamera::EosCamera(Exposure exposure, const CameraTiming& timing)
    : exposure_(std::move(exposure)), timing_(timing) {}

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
  card_.RemoveFiles();
  settings_.SetRoom(true);
  TellValue(kEosAvailableShots);
}

PtpReply EosCamera::Handle(const PtpRequest& request) {
  if (Clock::now() < faults.silent_until) return PtpSilence();
  PtpReply reply = Answer(request);
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
    if (session_open_) return PtpResult(kPtpSessionAlreadyOpen);
    session_open_ = true;
    return {};
  }
  if (!session_open_) return PtpResult(kPtpSessionNotOpen);
  switch (r.operation) {
    case 0x1003:
      EndSession();
      return {};
    case 0x1004:
    case 0x9101:
      return PtpData(PtpWriter().Array32({kEosStorage}).Take());
    case 0x1005:
    case 0x9102:
      return StorageInfo();
    case 0x1007:
      return card_.Handles(r.Parameter(2));
    case 0x1008:
      return card_.Info(r.Parameter(0));
    case 0x1009:
    case 0x9104:
      return Read(r, 0, kAll);
    case 0x101B:
    case 0x9107:
      return Read(r, r.Parameter(1), r.Parameter(2));
    case 0x100B:
    case 0x9105:
      return card_.Erase(r.Parameter(0));
    case 0x9109:
      return card_.Entries(r.Parameter(1));
    case 0x9110:
      return Set(r.data);
    case 0x9114:
      remote_ = r.Parameter(0) != 0;
      return {};
    case 0x9115:
      TellAll();
      return {};
    case 0x9116:
      return Events();
    case 0x9117:  // TransferComplete: what lay in RAM is let go of
      card_.Erase(r.Parameter(0));
      return {};
    case 0x911A:  // the host says that it has room
      TellValue(kEosAvailableShots);
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
      return PtpResult(kPtpNotSupported);
  }
}

PtpReply EosCamera::DeviceInfo() const {
  PtpWriter w;
  w.U16(100).U32(0x0000000B).U16(0x0100).Text("").U16(0);
  w.Array16({0x1001, 0x1002, 0x1003, 0x1004, 0x1005, 0x1007, 0x1008, 0x1009, 0x100B,
             0x101B, 0x9101, 0x9102, 0x9104, 0x9105, 0x9107, 0x9109, 0x9110, 0x9114,
             0x9115, 0x9116, 0x9117, 0x911A, 0x911B, 0x911C, 0x911D, 0x9128, 0x9129});
  w.Array16({0x4002, 0x4003, 0xC101}).Array16({}).Array16({kEosRaw}).Array16({kEosRaw, kEosFolder});
  w.Text("Canon Inc.").Text("Canon EOS 5D Mark II").Text("3-2.1.2").Text("emulated-0001");
  return PtpData(w.Take());
}

PtpReply EosCamera::StorageInfo() const {
  PtpWriter w;
  w.U16(4).U16(3).U16(0).U64(32'000'000'000ULL);
  const std::uint32_t shots = settings_.Value(kEosAvailableShots);
  w.U64(shots * 30'000'000ULL).U32(shots).Text("CF").Text("EOS_DIGITAL");
  return PtpData(w.Take());
}

PtpReply EosCamera::Read(const PtpRequest& request, std::uint32_t offset, std::uint32_t size) {
  if (!faults.unplug_at_read || !unplug) return card_.Part(request.Parameter(0), offset, size);
  faults.unplug_at_read = false;
  unplug(faults.unplug_seconds);
  return PtpSilence();
}

PtpReply EosCamera::Set(const Bytes& data) {
  if (Clock::now() < busy_until_) return PtpResult(kPtpDeviceBusy);
  const std::uint16_t result = settings_.Set(data);
  if (result == kPtpOk) TellValue(EosSettings::PropertyOf(data));
  return PtpResult(result);
}

PtpReply EosCamera::Events() {
  PtpWriter w;
  const auto now = Clock::now();
  for (auto it = events_.begin(); it != events_.end();) {
    if (it->when > now) {
      ++it;
      continue;
    }
    const Bytes payload = it->new_object != 0 ? card_.Announcement(it->new_object) : it->payload;
    if (!payload.empty()) {
      w.U32(static_cast<std::uint32_t>(8 + payload.size())).U32(it->kind).Raw(payload);
    }
    it = events_.erase(it);
  }
  return PtpData(w.U32(8).U32(0).Take());
}

void EosCamera::Tell(std::uint32_t kind, Bytes payload) {
  events_.push_back({kind, std::move(payload), 0, Clock::now()});
}

void EosCamera::TellValue(std::uint32_t property) {
  Tell(kValueChanged, settings_.ValueChanged(property));
}

void EosCamera::TellAll() {
  for (const std::uint32_t property : settings_.Properties()) TellValue(property);
  for (Bytes& choices : settings_.AllChoices()) Tell(kChoicesChanged, std::move(choices));
}

PtpReply EosCamera::Press(std::uint32_t how_far) {
  if (!remote_) return PtpResult(kPtpGeneralError);
  if (Clock::now() < busy_until_) return PtpResult(kPtpDeviceBusy);
  if (how_far == 1) {  // half-way: it says that it is in focus
    Tell(kViewfinderInfo, PtpWriter().U32(14).U16(0x0100).U16(0).Zeros(4).U8(1).U8(0).Take());
    return {};
  }
  const auto fault = faults.AtPress();
  if (const auto failure = FailAt(fault)) return *failure;
  Shoot(fault);
  return {};
}

std::optional<PtpReply> EosCamera::FailAt(const std::optional<PlannedFault>& fault) {
  const auto strikes = [&](EosFault kind) { return fault && fault->fault == kind; };
  if (strikes(EosFault::kBusy)) return PtpResult(kPtpDeviceBusy);
  if (strikes(EosFault::kHang)) {
    faults.silent_until = In(fault->seconds);
    return PtpSilence();
  }
  if (strikes(EosFault::kFull)) {
    faults.full_for_good = fault->seconds == 0.0;
    faults.full_until = In(fault->seconds);
  }
  const bool full = strikes(EosFault::kFull) || faults.full_for_good || Clock::now() < faults.full_until;
  settings_.SetRoom(!full);
  if (full) {
    TellValue(kEosAvailableShots);
    return PtpResult(kPtpStoreFull);
  }
  if (strikes(EosFault::kSleep) && unplug) {
    unplug(fault->seconds);
    return PtpSilence();
  }
  if (strikes(EosFault::kTaken) && taken) {
    taken(fault->seconds);
    return PtpSilence();
  }
  if (strikes(EosFault::kKilled)) ::kill(::getpid(), SIGKILL);
  return std::nullopt;
}

void EosCamera::Shoot(const std::optional<PlannedFault>& fault) {
  const auto strikes = [&](EosFault kind) { return fault && fault->fault == kind; };
  if (strikes(EosFault::kStall)) faults.stalled = true;
  if (strikes(EosFault::kRam)) settings_.SendToCard(false);
  if (strikes(EosFault::kSettings)) settings_.SetIso800();

  const double exposure_ms = settings_.exposure_ms();
  const FutureFile exposed = std::async(std::launch::async, [make = exposure_(exposure_ms, settings_.iso())] {
                               StandBack();
                               return make();
                             }).share();
  ++shots_;
  FutureFile file = strikes(EosFault::kRepeated) && last_file_.valid() ? last_file_ : exposed;
  last_file_ = exposed;
  if (strikes(EosFault::kTruncated)) {
    file = std::async(std::launch::deferred, [file] {
             const Bytes& whole = file.get();
             return Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(whole.size() / 2));
           }).share();
  }
  const double open_s = timing_.shutter_lag_s + timing_.exposure_scale * exposure_ms / 1000.0;
  busy_until_ = In(open_s);
  if (!strikes(EosFault::kMissing)) {
    const bool to_card = settings_.ToCard();
    const double late_s = strikes(EosFault::kLate) ? fault->seconds : 0.0;
    events_.push_back({to_card ? kObjectAdded : kObjectOffered,
                       {},
                       card_.Store(std::move(file), to_card),
                       In(open_s + timing_.store_s + late_s)});
  }
  if (strikes(EosFault::kRam)) TellValue(kEosCaptureDestination);
  if (strikes(EosFault::kUnplugRead)) {
    faults.unplug_at_read = true;
    faults.unplug_seconds = fault->seconds;
  }
  if (strikes(EosFault::kUnplug) && unplug) unplug(fault->seconds);
}

}  // namespace dermap::emulator
