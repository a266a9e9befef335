// SPDX-License-Identifier: Apache-2.0
// Pieces of TIFF 6.0 in either byte order, and bits in a row: what the tests' camera files are made of.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

namespace dermap {

using Bytes = std::vector<std::byte>;

inline void Append(Bytes& to, const Bytes& more) {
  to.insert(to.end(), more.begin(), more.end());
}

class Numbers {  // in one byte order
 public:
  explicit Numbers(bool big_endian) : big_endian_(big_endian) {}
  Bytes Of(std::uint32_t value, int size) const {
    Bytes out;
    for (int i = 0; i < size; ++i)
      out.push_back(static_cast<std::byte>(value >> 8 * (big_endian_ ? size - 1 - i : i) & 0xFF));
    return out;
  }
  Bytes Header() const {
    Bytes out(2, std::byte{big_endian_ ? std::uint8_t{'M'} : std::uint8_t{'I'}});
    Append(out, Of(42, 2));
    return out;
  }

 private:
  bool big_endian_;
};

// One directory; tags are added in ascending order.
class Directory {
 public:
  explicit Directory(const Numbers& numbers) : numbers_(numbers) {}
  void Shorts(std::uint32_t tag, const std::vector<std::uint32_t>& values) { Add(tag, 3, 2, values); }
  void Longs(std::uint32_t tag, const std::vector<std::uint32_t>& values) { Add(tag, 4, 4, values); }
  void Rational(std::uint32_t tag, std::uint32_t above, std::uint32_t below) {
    Add(tag, 5, 4, {above, below});
    entries_.back().count = 1;
  }
  void Raw(std::uint32_t tag, std::uint32_t type, const Bytes& data) {
    entries_.push_back({tag, type, static_cast<std::uint32_t>(data.size()), data});
  }
  void Text(std::uint32_t tag, std::string_view text) {
    Bytes data;
    for (const char c : text) data.push_back(static_cast<std::byte>(c));
    data.push_back(std::byte{0});
    Raw(tag, 2, data);
  }
  std::uint32_t Size() const { return static_cast<std::uint32_t>(At(0, 0).size()); }
  // As it stands at the offset `at`; `next`: the offset of the directory that follows.
  Bytes At(std::uint32_t at, std::uint32_t next = 0) const {
    Bytes out = numbers_.Of(static_cast<std::uint32_t>(entries_.size()), 2), outside;
    const std::uint32_t outside_at = at + 2 + 12 * static_cast<std::uint32_t>(entries_.size()) + 4;
    for (const Entry& e : entries_) {
      Append(out, numbers_.Of(e.tag, 2));
      Append(out, numbers_.Of(e.type, 2));
      Append(out, numbers_.Of(e.count, 4));
      if (e.data.size() <= 4) {
        Append(out, e.data);
        out.resize(out.size() + 4 - e.data.size());
        continue;
      }
      Append(out, numbers_.Of(outside_at + static_cast<std::uint32_t>(outside.size()), 4));
      Append(outside, e.data);
      outside.resize(outside.size() + outside.size() % 2);
    }
    Append(out, numbers_.Of(next, 4));
    Append(out, outside);
    return out;
  }

 private:
  struct Entry {
    std::uint32_t tag, type, count;
    Bytes data;
  };
  void Add(std::uint32_t tag, std::uint32_t type, int size, const std::vector<std::uint32_t>& values) {
    Bytes data;
    for (const std::uint32_t v : values) Append(data, numbers_.Of(v, size));
    entries_.push_back({tag, type, static_cast<std::uint32_t>(values.size()), data});
  }
  Numbers numbers_;
  std::vector<Entry> entries_;
};

// Most significant bit first; in a JPEG stream a zero follows every byte of ones.
class BitWriter {
 public:
  explicit BitWriter(bool jpeg) : jpeg_(jpeg) {}
  void Put(std::uint32_t value, int count) {
    for (int i = count - 1; i >= 0; --i) {
      byte_ = byte_ << 1 | (value >> i & 1);
      if (++filled_ == 8) Flush();
    }
  }
  Bytes Finish() {
    while (filled_ > 0) Put(1, 1);
    return std::move(out_);
  }

 private:
  void Flush() {
    out_.push_back(static_cast<std::byte>(byte_));
    if (jpeg_ && byte_ == 0xFF) out_.push_back(std::byte{0});
    byte_ = 0, filled_ = 0;
  }
  bool jpeg_;
  Bytes out_;
  std::uint32_t byte_ = 0;
  int filled_ = 0;
};

// 12.5 ms at ISO 320.
inline Directory Exif(const Numbers& numbers, const Bytes& maker_note) {
  Directory exif(numbers);
  exif.Rational(33434, 1, 80);  // ExposureTime, s
  exif.Shorts(34855, {320});
  if (!maker_note.empty()) exif.Raw(37500, 7, maker_note);
  return exif;
}

}  // namespace dermap
