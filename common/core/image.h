// SPDX-License-Identifier: Apache-2.0
// Image planes: one channel, row by row from the top left, no padding.
#pragma once

#include <cassert>
#include <cstddef>
#include <span>
#include <vector>

namespace dermap {

template <class T>
class Plane {
 public:
  Plane() = default;
  Plane(int width, int height, T value = T{})
      : width_(width), height_(height), values_(static_cast<std::size_t>(width) * height, value) {
    assert(width >= 0 && height >= 0);
  }

  int width() const noexcept { return width_; }
  int height() const noexcept { return height_; }
  bool empty() const noexcept { return values_.empty(); }
  std::size_t size() const noexcept { return values_.size(); }
  bool SameShape(int width, int height) const noexcept { return width_ == width && height_ == height; }
  template <class U>
  bool SameShape(const Plane<U>& other) const noexcept {
    return SameShape(other.width(), other.height());
  }

  T& operator()(int x, int y) noexcept { return values_[static_cast<std::size_t>(y) * width_ + x]; }
  const T& operator()(int x, int y) const noexcept {
    return values_[static_cast<std::size_t>(y) * width_ + x];
  }
  T* Row(int y) noexcept { return values_.data() + static_cast<std::size_t>(y) * width_; }
  const T* Row(int y) const noexcept { return values_.data() + static_cast<std::size_t>(y) * width_; }
  std::span<T> values() noexcept { return values_; }
  std::span<const T> values() const noexcept { return values_; }
  T* data() noexcept { return values_.data(); }
  const T* data() const noexcept { return values_.data(); }

 private:
  int width_ = 0;
  int height_ = 0;
  std::vector<T> values_;
};

using PlaneF = Plane<float>;

}  // namespace dermap
