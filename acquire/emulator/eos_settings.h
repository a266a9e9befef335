// SPDX-License-Identifier: Apache-2.0
// How an emulated EOS is set: its properties, what they may be, and how it tells of them.
#pragma once

#include <map>
#include <vector>

#include "acquire/emulator/ptp.h"

namespace dermap::emulator {

enum EosProperty : std::uint32_t {
  kEosAperture = 0xD101,
  kEosShutterSpeed = 0xD102,
  kEosIso = 0xD103,
  kEosFocusMode = 0xD108,
  kEosBattery = 0xD111,
  kEosAutoPowerOff = 0xD114,
  kEosAvailableShots = 0xD11B,
  kEosCaptureDestination = 0xD11C,
  kEosCurrentStorage = 0xD11E,
  kEosImageFormat = 0xD120,
  kEosViewfinderOutput = 0xD1B0,
};

class EosSettings {
 public:
  EosSettings();
  std::uint32_t Value(EosProperty property) const { return values_.at(property); }
  // As the host asks for it, in the data of SetDevicePropValueEx; the result's code.
  std::uint16_t Set(const Bytes& data);
  static EosProperty PropertyOf(const Bytes& data) { return static_cast<EosProperty>(PtpU32(data, 4)); }

  bool ToCard() const;
  void SendToCard(bool card);
  void SetIso800();  // as somebody does who turns the dial
  void SetRoom(bool room);
  double exposure_ms() const;
  int iso() const;

  Bytes ValueChanged(std::uint32_t property) const;
  std::vector<std::uint32_t> Properties() const;
  std::vector<Bytes> AllChoices() const;

 private:
  std::map<std::uint32_t, std::uint32_t> values_;
};

}  // namespace dermap::emulator
