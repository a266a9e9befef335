// SPDX-License-Identifier: Apache-2.0
// Huffman-coded differences of lossless JPEG, ITU-T T.81: a table of codes (annex C) whose symbols say how
// many bits of difference follow (annex H.1.2.2), and the bits themselves.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace dermap {

inline constexpr int kLongestCode = 16;      // bits [T.81 B.2.4.2]
inline constexpr int kLargestCategory = 16;  // bits of a difference [T.81 table H.2]

// The bytes of a scan, from behind its header to the first marker, without those that were stuffed behind
// 0xFF, and kReadAtOnce zeros at the end.
inline constexpr std::size_t kReadAtOnce = 8;
std::vector<std::uint8_t> WithoutStuffing(std::span<const std::uint8_t> scan);

// Bits of such bytes, the first one highest. Beyond the end there are zeros, and Broken() says so. A plain
// value, so that loops keep it in registers; the bytes are borrowed.
class JpegBits {
 public:
  JpegBits() = default;
  explicit JpegBits(std::span<const std::uint8_t> bytes)
      : bytes_(bytes.data()), size_(bytes.size() - kReadAtOnce) {}

  // At least kFilled bits can be peeked at and skipped after it.
  void Fill() {
    std::uint64_t next = 0;
    for (std::size_t i = 0; i < kReadAtOnce; ++i) next = next << 8U | bytes_[at_ + i];
    window_ |= next >> filled_;
    at_ += (63U - filled_) >> 3U;
    filled_ |= 56U;
    if (at_ > size_) [[unlikely]] {
      beyond_ += at_ - size_;
      at_ = size_;
    }
  }
  static constexpr int kFilled = 56;
  // 1 to 32 bits.
  std::uint32_t Peek(int count) const { return static_cast<std::uint32_t>(window_ >> (64 - count)); }
  void Skip(int count) {
    window_ <<= count;
    filled_ -= static_cast<unsigned>(count);
  }
  // More bits were taken than there were, or some that are no code.
  bool Broken() const { return 8 * (at_ + beyond_) > 8 * size_ + filled_; }
  void Break() { beyond_ = size_ + kFilled; }

 private:
  const std::uint8_t* bytes_ = nullptr;
  std::size_t size_ = 0;
  std::size_t at_ = 0;      // first byte that is not in the window yet
  std::size_t beyond_ = 0;  // bytes of nothing in the window
  std::uint64_t window_ = 0;
  unsigned filled_ = 0;  // bits of the window that were read
};

class HuffmanTable {
 public:
  // `counts[i]`: codes of i + 1 bits; `categories`: what they mean, shortest first. None where codes do not
  // fit their lengths or a category is no number of bits.
  static std::optional<HuffmanTable> FromCounts(std::span<const std::uint8_t, kLongestCode> counts,
                                                std::span<const std::uint8_t> categories);

  // The next difference, modulo 2^16. Needs kQuickBits bits in the window; where the code and its difference
  // are longer, fills the window before and after it.
  std::uint16_t Difference(JpegBits& bits) const {
    const Entry& entry = quick_[bits.Peek(kQuickBits)];
    if (entry.length == 0) [[unlikely]]
      return LongDifference(bits);
    bits.Skip(entry.length);
    return entry.difference;
  }
  static constexpr int kQuickBits = 12;

 private:
  struct Entry {
    std::uint16_t difference = 0;
    std::uint8_t length = 0;  // of code and difference together; 0: longer than kQuickBits, or no code
  };
  struct Code {
    int length = 0;
    int category = 0;
  };

  Code CodeOf(std::uint32_t next_16_bits) const;
  std::uint16_t LongDifference(JpegBits& bits) const {
    bits.Fill();
    const Code code = CodeOf(bits.Peek(kLongestCode));
    if (code.length == 0) bits.Break();
    bits.Skip(code.length);
    const int count = BitsOf(code.category);
    const std::uint32_t difference = count == 0 ? 0 : bits.Peek(count);
    bits.Skip(count);
    bits.Fill();
    return Extended(difference, code.category);
  }
  // A difference of t bits below 2^(t-1) is negative [T.81 F.2.2.1, EXTEND].
  static std::uint16_t Extended(std::uint32_t bits, int category) {
    if (category == kLargestCategory) return 0x8000;  // no bits follow [T.81 H.1.2.2]
    const bool negative = category > 0 && bits >> (category - 1) == 0;
    return static_cast<std::uint16_t>(negative ? bits + 1U - (1U << category) : bits);
  }
  static int BitsOf(int category) { return category == kLargestCategory ? 0 : category; }
  void FillQuick();

  std::vector<std::uint8_t> categories_;
  // Of the codes of each length: the first one and one behind the last, with zeros up to 16 bits, and the
  // place of the first one in categories_.
  std::array<std::uint32_t, kLongestCode + 1> first_{}, end_{};
  std::array<std::size_t, kLongestCode + 1> place_{};
  std::vector<Entry> quick_;
};

}  // namespace dermap
