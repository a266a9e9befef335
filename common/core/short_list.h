// SPDX-License-Identifier: Apache-2.0
// A list of a few values that needs no memory of its own, for what is rebuilt in every iteration.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>

namespace dermap {

template <class T, std::size_t kMost>
class ShortList {
 public:
  void push_back(const T& value) {
    assert(size_ < kMost);
    values_[size_++] = value;
  }
  void clear() noexcept { size_ = 0; }
  std::size_t size() const noexcept { return size_; }
  bool empty() const noexcept { return size_ == 0; }
  T& operator[](std::size_t i) noexcept { return values_[i]; }
  const T& operator[](std::size_t i) const noexcept { return values_[i]; }
  const T* data() const noexcept { return values_.data(); }
  const T* begin() const noexcept { return data(); }
  const T* end() const noexcept { return data() + size_; }

 private:
  std::array<T, kMost> values_{};
  std::size_t size_ = 0;
};

}  // namespace dermap
