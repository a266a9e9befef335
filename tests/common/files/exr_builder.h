// SPDX-License-Identifier: Apache-2.0
// For tests: OpenEXR files put together byte by byte after "OpenEXR File Layout" (openexr.com), uncompressed,
// with no library in between: an independent source of good files, and of files that no library would write.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace dermap {

enum class ExrType : std::int32_t { kUint = 0, kHalf = 1, kFloat = 2 };

class ExrBuilder {
 public:
  ExrBuilder(int width, int height) : width_(width), height_(height) {}

  ExrBuilder& Channel(const std::string& name, ExrType type, std::function<double(int x, int y)> value) {
    channels_[name] = {type, std::move(value)};
    return *this;
  }
  ExrBuilder& Text(const std::string& name, const std::string& text) { return Raw(name, "string", text); }
  ExrBuilder& Float(const std::string& name, float value) { return Raw(name, "float", Bytes(value)); }
  ExrBuilder& Floats(const std::string& name, const std::vector<float>& values) {
    std::string bytes;
    for (const float value : values) bytes += Bytes(value);
    return Raw(name, "floatvector", bytes);
  }
  ExrBuilder& Raw(const std::string& name, const std::string& type, const std::string& bytes) {
    attributes_ += Attribute(name, type, bytes);
    return *this;
  }
  ExrBuilder& Origin(int x, int y) {
    x0_ = x;
    y0_ = y;
    return *this;
  }
  ExrBuilder& Flags(std::uint32_t flags) {
    flags_ = flags;
    return *this;
  }
  // What the header says the data window is, whatever pixels follow.
  ExrBuilder& ClaimSize(int width, int height) {
    claimed_width_ = width;
    claimed_height_ = height;
    return *this;
  }

  std::string Build() const {
    std::string file = Bytes(std::uint32_t{20000630}) + Bytes(std::uint32_t{2} | flags_) + Header();
    const std::size_t table = file.size();
    std::string chunks;
    std::string offsets;
    for (int y = 0; y < height_; ++y) {
      offsets +=
          Bytes(static_cast<std::uint64_t>(table + 8u * static_cast<unsigned>(height_) + chunks.size()));
      const std::string line = Line(y);
      chunks += Bytes(std::int32_t{y + y0_}) + Bytes(static_cast<std::int32_t>(line.size())) + line;
    }
    return file + offsets + chunks;
  }

 private:
  struct ChannelSpec {
    ExrType type;
    std::function<double(int, int)> value;
  };

  template <class T>
  static std::string Bytes(T value) {
    std::string bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    return bytes;
  }

  // The last pixel of an axis; wraps as a writer's int would.
  static std::string Last(int first, int count) {
    return Bytes(static_cast<std::uint32_t>(first) + static_cast<std::uint32_t>(count) - 1u);
  }

  static std::string Attribute(const std::string& name, const std::string& type, const std::string& bytes) {
    return name + '\0' + type + '\0' + Bytes(static_cast<std::int32_t>(bytes.size())) + bytes;
  }

  std::string Header() const {
    std::string list;
    for (const auto& [name, channel] : channels_) {
      list += name + '\0' + Bytes(static_cast<std::int32_t>(channel.type)) + std::string(4, '\0') +
              Bytes(std::int32_t{1}) + Bytes(std::int32_t{1});
    }
    list += '\0';
    const int width = claimed_width_ ? claimed_width_ : width_;
    const int height = claimed_height_ ? claimed_height_ : height_;
    const std::string box = Bytes(x0_) + Bytes(y0_) + Last(x0_, width) + Last(y0_, height);
    return Attribute("channels", "chlist", list) +
           Attribute("compression", "compression", std::string(1, '\0')) +
           Attribute("dataWindow", "box2i", box) + Attribute("displayWindow", "box2i", box) +
           Attribute("lineOrder", "lineOrder", std::string(1, '\0')) +
           Attribute("pixelAspectRatio", "float", Bytes(1.0f)) +
           Attribute("screenWindowCenter", "v2f", Bytes(0.0f) + Bytes(0.0f)) +
           Attribute("screenWindowWidth", "float", Bytes(1.0f)) + attributes_ + '\0';
  }

  // Half floats that are exact: numbers 2^-14 and up with at most 10 bits after the leading one.
  static std::uint16_t Half(double value) {
    if (value == 0.0) return 0;
    int exponent = 0;
    const double mantissa = std::frexp(value, &exponent);  // [0.5, 1)
    return static_cast<std::uint16_t>(((exponent + 14) << 10) +
                                      static_cast<int>((mantissa * 2.0 - 1.0) * 1024.0));
  }

  std::string Line(int y) const {
    std::string line;
    for (const auto& [name, channel] : channels_) {
      for (int x = 0; x < width_; ++x) {
        const double value = channel.value(x, y);
        if (channel.type == ExrType::kUint) line += Bytes(static_cast<std::uint32_t>(value));
        if (channel.type == ExrType::kHalf) line += Bytes(Half(value));
        if (channel.type == ExrType::kFloat) line += Bytes(static_cast<float>(value));
      }
    }
    return line;
  }

  int width_, height_;
  int x0_ = 0, y0_ = 0;
  int claimed_width_ = 0, claimed_height_ = 0;
  std::uint32_t flags_ = 0;
  std::map<std::string, ChannelSpec> channels_;  // the layout wants them in alphabetical order
  std::string attributes_;
};

}  // namespace dermap
