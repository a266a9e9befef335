// SPDX-License-Identifier: Apache-2.0
// The picture transfer protocol (ISO 15740), whatever carries it: requests, replies, and their numbers and
// strings.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquire/emulator/usb_device.h"

namespace dermap::emulator {

enum PtpCode : std::uint16_t {
  kPtpOk = 0x2001,
  kPtpGeneralError = 0x2002,
  kPtpSessionNotOpen = 0x2003,
  kPtpNotSupported = 0x2005,
  kPtpInvalidObject = 0x2009,
  kPtpStoreFull = 0x200C,
  kPtpDeviceBusy = 0x2019,
  kPtpInvalidParameter = 0x201D,
  kPtpSessionAlreadyOpen = 0x201E,
};

struct PtpRequest {
  std::uint16_t operation = 0;
  std::uint32_t transaction = 0;
  std::vector<std::uint32_t> parameters;
  Bytes data;
  std::uint32_t Parameter(std::size_t i) const { return i < parameters.size() ? parameters[i] : 0; }
};

struct PtpReply {
  std::uint16_t code = kPtpOk;
  std::vector<std::uint32_t> parameters;
  std::optional<Bytes> data;
  std::chrono::duration<double> after{0.0};  // seconds until it comes
  bool silent = false;                       // it never comes
};

PtpReply PtpData(Bytes data);
PtpReply PtpResult(std::uint16_t code);
PtpReply PtpSilence();

// Little-endian, as PTP over USB and IP has it.
class PtpWriter {
 public:
  PtpWriter& U8(std::uint32_t value);
  PtpWriter& U16(std::uint32_t value);
  PtpWriter& U32(std::uint32_t value);
  PtpWriter& U64(std::uint64_t value);
  PtpWriter& Text(const std::string& ascii);  // PTP string: length, UTF-16, NUL
  PtpWriter& Raw(const Bytes& bytes);
  PtpWriter& Zeros(std::size_t count);
  PtpWriter& Array16(const std::vector<std::uint16_t>& values);
  PtpWriter& Array32(const std::vector<std::uint32_t>& values);
  const Bytes& bytes() const { return bytes_; }
  Bytes Take() { return std::move(bytes_); }

 private:
  Bytes bytes_;
};

// Numbers out of bytes that may be too short: what is missing is 0.
std::uint16_t PtpU16(std::span<const std::uint8_t> bytes, std::size_t at);
std::uint32_t PtpU32(std::span<const std::uint8_t> bytes, std::size_t at);

// Whether a request of this operation comes with data from the host.
bool PtpTakesData(std::uint16_t operation);

}  // namespace dermap::emulator
