// SPDX-License-Identifier: Apache-2.0
// Numbers and strings on the wire.
#include "acquire/emulator/ptp.h"

namespace dermap::emulator {

PtpReply PtpData(Bytes data) {
  PtpReply reply;
  reply.data = std::move(data);
  return reply;
}

PtpReply PtpResult(std::uint16_t code) {
  PtpReply reply;
  reply.code = code;
  return reply;
}

PtpReply PtpSilence() {
  PtpReply reply;
  reply.silent = true;
  return reply;
}

PtpWriter& PtpWriter::U8(std::uint32_t v) {
  bytes_.push_back(static_cast<std::uint8_t>(v & 0xFF));
  return *this;
}
PtpWriter& PtpWriter::U16(std::uint32_t v) {
  return U8(v).U8(v >> 8);
}
PtpWriter& PtpWriter::U32(std::uint32_t v) {
  return U16(v).U16(v >> 16);
}
PtpWriter& PtpWriter::U64(std::uint64_t v) {
  return U32(static_cast<std::uint32_t>(v)).U32(static_cast<std::uint32_t>(v >> 32));
}
PtpWriter& PtpWriter::Text(const std::string& ascii) {
  if (ascii.empty()) return U8(0);
  U8(static_cast<std::uint32_t>(ascii.size() + 1));
  for (const char c : ascii) U16(static_cast<unsigned char>(c));
  return U16(0);
}
PtpWriter& PtpWriter::Raw(const Bytes& bytes) {
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  return *this;
}
PtpWriter& PtpWriter::Zeros(std::size_t count) {
  bytes_.resize(bytes_.size() + count);
  return *this;
}
PtpWriter& PtpWriter::Array16(const std::vector<std::uint16_t>& values) {
  U32(static_cast<std::uint32_t>(values.size()));
  for (const auto v : values) U16(v);
  return *this;
}
PtpWriter& PtpWriter::Array32(const std::vector<std::uint32_t>& values) {
  U32(static_cast<std::uint32_t>(values.size()));
  for (const auto v : values) U32(v);
  return *this;
}

std::uint16_t PtpU16(std::span<const std::uint8_t> b, std::size_t at) {
  return static_cast<std::uint16_t>((at < b.size() ? b[at] : 0) | (at + 1 < b.size() ? b[at + 1] << 8 : 0));
}

std::uint32_t PtpU32(std::span<const std::uint8_t> b, std::size_t at) {
  return PtpU16(b, at) | static_cast<std::uint32_t>(PtpU16(b, at + 2)) << 16;
}

bool PtpTakesData(std::uint16_t operation) {
  return operation == 0x9110 || operation == 0x1016;  // SetDevicePropValueEx, SetDevicePropValue
}

}  // namespace dermap::emulator
