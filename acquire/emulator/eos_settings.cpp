// SPDX-License-Identifier: Apache-2.0
// Canon's codes, and the layouts of libgphoto2's ptp-pack.c.
#include "acquire/emulator/eos_settings.h"

#include <algorithm>
#include <array>

#include "acquire/emulator/eos_card.h"

namespace dermap::emulator {
namespace {

constexpr std::uint32_t kToCard = 2, kToHost = 4;
constexpr std::uint32_t kRoomForShots = 999;

struct Step {
  std::uint32_t code;
  double value;
};
// Exposure times (ms) and ISO; third stops.
constexpr std::array kShutters{
    Step{0x58, 1000.0 / 15}, Step{0x5D, 40},          Step{0x60, 1000.0 / 30}, Step{0x63, 25},
    Step{0x65, 20},          Step{0x68, 1000.0 / 60}, Step{0x6B, 12.5},        Step{0x6D, 10},
    Step{0x70, 8},           Step{0x73, 6.25},        Step{0x75, 5},           Step{0x78, 4},
    Step{0x50, 125},         Step{0x40, 500},         Step{0x38, 1000},        Step{0x30, 2000}};
constexpr std::uint32_t kIso800 = 0x60;
constexpr std::array kIsos{Step{0x48, 100},  Step{0x4B, 125},    Step{0x4D, 160},  Step{0x50, 200},
                           Step{0x53, 250},  Step{0x55, 320},    Step{0x58, 400},  Step{0x5B, 500},
                           Step{0x5D, 640},  Step{kIso800, 800}, Step{0x63, 1000}, Step{0x65, 1250},
                           Step{0x68, 1600}, Step{0x70, 3200},   Step{0x78, 6400}};

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

Bytes Choices(std::uint32_t property, const std::vector<std::uint32_t>& values) {
  return PtpWriter().U32(property).U32(3).Array32(values).Take();
}

// One file: raw, large, lossless.
PtpWriter& RawFormat(PtpWriter& w) {
  return w.U32(1).U32(0x10).U32(6).U32(0).U32(4);
}

}  // namespace

EosSettings::EosSettings()
    : values_{{kEosAperture, 0x38},
              {kEosShutterSpeed, 0x6D},
              {kEosIso, 0x48},
              {kEosFocusMode, 3},
              {kEosBattery, 3},
              {kEosAutoPowerOff, 0},
              {kEosAvailableShots, kRoomForShots},
              {kEosCaptureDestination, kToCard},
              {kEosCurrentStorage, kEosStorage},
              {kEosImageFormat, 0},
              {kEosViewfinderOutput, 0}} {}

std::uint16_t EosSettings::Set(const Bytes& data) {
  if (data.size() < 12 || PtpU32(data, 0) > data.size()) return kPtpInvalidParameter;
  const EosProperty property = PropertyOf(data);
  if (values_.count(property) == 0) return kPtpInvalidParameter;
  const std::uint32_t value = PtpU32(data, 8);
  if (property == kEosIso && ValueOf(kIsos, value) == 0.0) return kPtpInvalidParameter;
  if (property == kEosShutterSpeed && ValueOf(kShutters, value) == 0.0) return kPtpInvalidParameter;
  if (property != kEosImageFormat) values_[property] = value;  // there is but one format
  return kPtpOk;
}

bool EosSettings::ToCard() const {
  return Value(kEosCaptureDestination) != kToHost;
}

void EosSettings::SendToCard(bool card) {
  values_[kEosCaptureDestination] = card ? kToCard : kToHost;
}

void EosSettings::SetIso800() {
  values_[kEosIso] = kIso800;
}

void EosSettings::SetRoom(bool room) {
  values_[kEosAvailableShots] = room ? kRoomForShots : 0;
}

double EosSettings::exposure_ms() const {
  return ValueOf(kShutters, Value(kEosShutterSpeed));
}

int EosSettings::iso() const {
  return static_cast<int>(ValueOf(kIsos, Value(kEosIso)));
}

Bytes EosSettings::ValueChanged(std::uint32_t property) const {
  PtpWriter w;
  w.U32(property);
  if (property == kEosImageFormat) return RawFormat(w).Take();
  return w.U32(values_.at(property)).Take();
}

std::vector<std::uint32_t> EosSettings::Properties() const {
  std::vector<std::uint32_t> properties;
  for (const auto& [property, value] : values_) properties.push_back(property);
  return properties;
}

std::vector<Bytes> EosSettings::AllChoices() const {
  PtpWriter format;
  format.U32(kEosImageFormat).U32(3).U32(1);
  return {Choices(kEosIso, CodesOf(kIsos)), Choices(kEosShutterSpeed, CodesOf(kShutters)),
          Choices(kEosCaptureDestination, {kToCard, kToHost}), RawFormat(format).Take()};
}

}  // namespace dermap::emulator
