// SPDX-License-Identifier: Apache-2.0
// A Canon EOS behind PTP: its session, settings, card, and the EOS extension's event queue. What carries the
// protocol (ptp_usb.h, ptp_ip.h) hands it requests.
#pragma once

#include <deque>
#include <functional>
#include <optional>

#include "acquire/emulator/eos_card.h"
#include "acquire/emulator/eos_faults.h"
#include "acquire/emulator/eos_settings.h"
#include "acquire/emulator/ptp.h"

namespace dermap::emulator {

// How fast it is; zeros are as fast as it goes.
struct CameraTiming {
  double answer_s = 0.0;        // of any request
  double shutter_lag_s = 0.0;   // from the button to the open shutter
  double store_s = 0.0;         // from the closed shutter to the file on the card
  double bytes_per_s = 0.0;     // of a transfer; 0 is without limit
  double exposure_scale = 0.0;  // of the exposure's own time
  static CameraTiming Real() { return {0.002, 0.065, 0.45, 25e6, 1.0}; }
};

class EosCamera {
 public:
  // Takes the light of a shot as it is at that moment; what it returns makes the file of it, in another
  // thread.
  using Exposure = std::function<std::function<Bytes()>(double exposure_ms, int iso)>;
  EosCamera(Exposure exposure, const CameraTiming& timing);

  PtpReply Handle(const PtpRequest& request);
  // The cable came out, or the host reset it: the session is over, the card stays as it is.
  void EndSession();
  void ChangeCard();  // for an empty one
  bool session_open() const { return session_open_; }
  int shots() const { return shots_; }

  EosFaults faults;
  std::function<void(double seconds)> unplug;  // carries out faults that take it off the bus
  std::function<void(double seconds)> taken;   // and those where another program takes it

 private:
  // What the host hears of when it next asks.
  struct Event {
    std::uint32_t kind = 0;
    Bytes payload;
    std::uint32_t new_object = 0;  // 0: none; else the payload is its announcement, once its file is made
    Clock::time_point when;
  };

  PtpReply Answer(const PtpRequest& request);
  PtpReply DeviceInfo() const;
  PtpReply StorageInfo() const;
  PtpReply Read(const PtpRequest& request, std::uint32_t offset, std::uint32_t size);
  PtpReply Set(const Bytes& data);
  PtpReply Events();
  PtpReply Press(std::uint32_t how_far);
  std::optional<PtpReply> FailAt(const std::optional<PlannedFault>& fault);  // before anything is exposed
  void Shoot(const std::optional<PlannedFault>& fault);
  void TellAll();
  void TellValue(std::uint32_t property);
  void Tell(std::uint32_t kind, Bytes payload);
  Clock::time_point In(double seconds) const;

  Exposure exposure_;
  CameraTiming timing_;
  EosSettings settings_;
  EosCard card_;
  std::deque<Event> events_;
  FutureFile last_file_;
  int shots_ = 0;
  bool session_open_ = false;
  bool remote_ = false;
  Clock::time_point busy_until_{};
};

}  // namespace dermap::emulator
