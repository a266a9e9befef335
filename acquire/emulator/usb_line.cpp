// SPDX-License-Identifier: Apache-2.0
// Matching transfers with a device's answers.
#include "acquire/emulator/usb_line.h"

#include <algorithm>
#include <cerrno>

namespace dermap::emulator {
namespace {

constexpr std::uint8_t kIn = 0x80;
constexpr int kControl = 2;

UsbSetup SetupOf(std::span<const std::uint8_t> b) {
  const auto word = [&](std::size_t i) { return static_cast<std::uint16_t>(b[i] | b[i + 1] << 8); };
  return {b[0], b[1], word(2), word(4), word(6)};
}

}  // namespace

UsbLine::UsbLine(UsbDevice& device) : device_(device), identity_(device.Identity()) {
  device_.Attached(*this);
}

UsbLine::~UsbLine() {
  if (!gone_) device_.Detached();
}

int UsbLine::Claim(const void* client, unsigned interface) {
  if (gone_) return ENODEV;
  if (interface != 0) return ENOENT;
  if ((owner_ != nullptr && owner_ != client) || Clock::now() < device_.held_until) return EBUSY;
  owner_ = client;
  return 0;
}

void UsbLine::Release(const void* client) {
  if (owner_ == client) owner_ = nullptr;
}

void UsbLine::Finish(std::list<Transfer>::iterator transfer, int status, int actual) {
  transfer->status = status;
  transfer->actual = actual;
  done_.push_back(*transfer);
  pending_.erase(transfer);
}

void UsbLine::Control(std::list<Transfer>::iterator transfer) {
  if (transfer->buffer.size() < 8) return Finish(transfer, -EINVAL, 0);
  const UsbSetup setup = SetupOf(transfer->buffer);
  const std::size_t room = std::min<std::size_t>(setup.length, transfer->buffer.size() - 8);
  Bytes in;
  int status = 0;
  const bool get_string = setup.request_type == kIn && setup.request == 6 && setup.value >> 8 == 3;
  if (get_string) {
    in = UsbString(identity_, setup.value & 0xFF);
    if (in.empty()) status = -EPIPE;
  } else {
    status = device_.Control(setup, transfer->buffer.subspan(8, (setup.request_type & kIn) ? 0 : room), in);
  }
  if (status == kStays) return;
  if ((setup.request_type & kIn) == 0)
    return Finish(transfer, status, status == 0 ? static_cast<int>(room) : 0);
  in.resize(std::min(in.size(), room));
  std::copy(in.begin(), in.end(), transfer->buffer.begin() + 8);
  Finish(transfer, status, static_cast<int>(in.size()));
}

void UsbLine::Submit(Transfer transfer) {
  transfer.since = Clock::now();
  pending_.push_back(transfer);
  const auto it = std::prev(pending_.end());
  if (transfer.kind == kControl) return Control(it);
  if ((transfer.endpoint & kIn) != 0) return;  // Pump() feeds it
  const int status = device_.Out(transfer.endpoint, transfer.buffer);
  if (status != kStays) Finish(it, status, status == 0 ? static_cast<int>(transfer.buffer.size()) : 0);
}

bool UsbLine::Discard(const void* client, std::uint64_t id) {
  const auto it = std::find_if(pending_.begin(), pending_.end(),
                               [&](const Transfer& t) { return t.client == client && t.id == id; });
  if (it == pending_.end()) return false;
  Finish(it, -ENOENT, 0);
  return true;
}

std::optional<Transfer> UsbLine::Reap(const void* client) {
  const auto it =
      std::find_if(done_.begin(), done_.end(), [&](const Transfer& t) { return t.client == client; });
  if (it == done_.end()) return std::nullopt;
  const Transfer transfer = *it;
  done_.erase(it);
  return transfer;
}

std::list<Transfer> UsbLine::Forget(const void* client) {
  std::list<Transfer> forgotten;
  for (auto it = pending_.begin(); it != pending_.end();) {
    if (it->client == client) forgotten.push_back(*it);
    it = it->client == client ? pending_.erase(it) : std::next(it);
  }
  for (const Transfer& t : done_) {
    if (t.client == client) forgotten.push_back(t);
  }
  std::erase_if(done_, [&](const Transfer& t) { return t.client == client; });
  if (owner_ == client) {
    owner_ = nullptr;
    if (!gone_) device_.Released();
  }
  return forgotten;
}

void UsbLine::Disconnect() {
  if (gone_) return;
  gone_ = true;
  device_.Detached();
  while (!pending_.empty()) Finish(pending_.begin(), -ESHUTDOWN, 0);
}

bool UsbLine::Feed(Transfer& t, std::optional<Clock::time_point>& next) {
  const auto look_again = [&](Clock::time_point when) { next = next ? std::min(*next, when) : when; };
  const int state = device_.InState(t.endpoint);
  if (state == kStays) return false;
  if (state != 0) {
    t.status = state;
    return true;
  }
  const auto now = Clock::now();
  auto& queue = answers_[t.endpoint];
  if (!queue.empty() && queue.front().when <= now) {
    Waiting& front = queue.front();
    const std::size_t size = std::min(t.buffer.size(), front.data.size() - front.taken);
    std::copy_n(front.data.begin() + static_cast<std::ptrdiff_t>(front.taken), size, t.buffer.begin());
    front.taken += size;
    t.status = 0;
    t.actual = static_cast<int>(size);
    // A transfer ends with a packet that is not full: where the last one is, an empty one follows.
    const bool full = size == t.buffer.size();
    const std::size_t packet = 512;
    const bool owes_empty_packet = full && !front.data.empty() && front.data.size() % packet == 0;
    if (front.taken == front.data.size()) {
      if (owes_empty_packet) {
        front = {{}, 0, front.when};
      } else {
        queue.pop_front();
      }
    }
    return true;
  }
  if (!queue.empty()) look_again(queue.front().when);
  if (const auto idle = device_.WhenIdle(t.endpoint)) {
    if (t.since + idle->after <= now) {
      const std::size_t size = std::min(t.buffer.size(), idle->data.size());
      std::copy_n(idle->data.begin(), size, t.buffer.begin());
      t.status = 0;
      t.actual = static_cast<int>(size);
      return true;
    }
    look_again(t.since + idle->after);
  }
  return false;
}

std::optional<Clock::time_point> UsbLine::Pump() {
  std::optional<Clock::time_point> next;
  std::set<std::uint8_t> waiting;  // endpoints whose first reader waits: those behind it wait too
  for (auto it = pending_.begin(); it != pending_.end();) {
    const auto current = it++;
    if (current->kind == kControl || (current->endpoint & kIn) == 0) continue;
    if (waiting.count(current->endpoint) != 0) continue;
    if (Feed(*current, next)) {
      Finish(current, current->status, current->actual);
    } else {
      waiting.insert(current->endpoint);
    }
  }
  return next;
}

void UsbLine::Answer(std::uint8_t endpoint, Bytes data, Clock::time_point when) {
  answers_[endpoint].push_back({std::move(data), 0, when});
}

void UsbLine::DropAnswers(std::uint8_t endpoint) {
  answers_[endpoint].clear();
}

}  // namespace dermap::emulator
