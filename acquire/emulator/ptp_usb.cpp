// SPDX-License-Identifier: Apache-2.0
// A container: length, kind (1 command, 2 data, 3 response), code, transaction, then parameters or data.
#include "acquire/emulator/ptp_usb.h"

#include <cerrno>

namespace dermap::emulator {
namespace {

constexpr std::uint8_t kDataIn = 0x81, kDataOut = 0x02, kEventsIn = 0x83;
constexpr std::size_t kHeader = 12;
constexpr std::size_t kLargestFromHost = 1 << 20;
enum Kind : std::uint16_t { kCommand = 1, kData = 2, kResponse = 3 };

Bytes Container(Kind kind, std::uint16_t code, std::uint32_t transaction, const Bytes& payload) {
  PtpWriter w;
  w.U32(static_cast<std::uint32_t>(kHeader + payload.size()))
      .U16(kind)
      .U16(code)
      .U32(transaction)
      .Raw(payload);
  return w.Take();
}

}  // namespace

UsbIdentity PtpUsb::Identity() const {
  return {.vendor = 0x04A9,
          .product = 0x3199,
          .manufacturer = "Canon Inc.",
          .name = "Canon Digital Camera",
          .serial = "",
          .interface_class = 6,
          .interface_subclass = 1,
          .interface_protocol = 1,
          .endpoints = {{kDataIn, 2, 512}, {kDataOut, 2, 512}, {kEventsIn, 3, 8}},
          .speed_mbit_s = 480};
}

void PtpUsb::Reset() {
  arrived_.clear();
  begun_.reset();
  DropAnswers(kDataIn);
  camera_.EndSession();
}

void PtpUsb::Detached() {
  Reset();
  UsbDevice::Detached();
}

int PtpUsb::Control(const UsbSetup& setup, std::span<const std::uint8_t>, Bytes& in) {
  if (setup.request == 0x66) {  // device reset
    Reset();
    return 0;
  }
  if (setup.request == 0x67) {  // device status
    in = {4, 0, 0x01, 0x20};
    return 0;
  }
  if (setup.request == 0x64) {  // cancel
    DropAnswers(kDataIn);
    return 0;
  }
  return -EPIPE;
}

int PtpUsb::InState(std::uint8_t endpoint) {
  return endpoint == kDataIn && camera_.faults.stalled ? -EPIPE : 0;
}

void PtpUsb::ClearHalt(std::uint8_t endpoint) {
  if (endpoint == kDataIn) camera_.faults.stalled = false;
}

int PtpUsb::Out(std::uint8_t endpoint, std::span<const std::uint8_t> data) {
  if (endpoint != kDataOut) return -EPIPE;
  if (Clock::now() < camera_.faults.silent_until) return kStays;
  arrived_.insert(arrived_.end(), data.begin(), data.end());
  while (arrived_.size() >= kHeader) {
    const std::size_t length = PtpU32(arrived_, 0);
    if (length < kHeader || length > kLargestFromHost) {  // no container: a real camera stalls
      arrived_.clear();
      return -EPIPE;
    }
    if (arrived_.size() < length) return 0;
    const Bytes whole(arrived_.begin(), arrived_.begin() + static_cast<std::ptrdiff_t>(length));
    arrived_.erase(arrived_.begin(), arrived_.begin() + static_cast<std::ptrdiff_t>(length));
    const std::uint16_t kind = PtpU16(whole, 4);
    if (kind == kCommand) {
      PtpRequest request{PtpU16(whole, 6), PtpU32(whole, 8), {}, {}};
      for (std::size_t at = kHeader; at + 4 <= length; at += 4)
        request.parameters.push_back(PtpU32(whole, at));
      if (PtpTakesData(request.operation)) {
        begun_ = std::move(request);
      } else {
        Run(request);
      }
    } else if (kind == kData && begun_) {
      begun_->data.assign(whole.begin() + kHeader, whole.end());
      Run(*begun_);
      begun_.reset();
    }
  }
  return 0;
}

void PtpUsb::Run(const PtpRequest& request) {
  const PtpReply reply = camera_.Handle(request);
  if (reply.silent) return;
  const auto when = Clock::now() + std::chrono::duration_cast<Clock::duration>(reply.after);
  if (reply.data)
    Answer(kDataIn, Container(kData, request.operation, request.transaction, *reply.data), when);
  PtpWriter parameters;
  for (const std::uint32_t p : reply.parameters) parameters.U32(p);
  Answer(kDataIn, Container(kResponse, reply.code, request.transaction, parameters.bytes()), when);
}

}  // namespace dermap::emulator
