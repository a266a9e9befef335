// SPDX-License-Identifier: Apache-2.0
// Flat OpenEXR images on the OpenEXR library.
#include "common/files/exr_file.h"

#include <ImfChannelList.h>
#include <ImfDoubleAttribute.h>
#include <ImfFloatAttribute.h>
#include <ImfFloatVectorAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfIntAttribute.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <ImfVecAttribute.h>

#include <cassert>
#include <cstring>
#include <set>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/exr_header.h"
#include "common/files/text.h"

namespace dermap {
namespace {

// A list of two or three floats is a vector to some writers.
template <class Attribute>
bool ReadVector(const Imf::Attribute& attribute, std::vector<float>& list) {
  const auto* typed = dynamic_cast<const Attribute*>(&attribute);
  if (!typed) return false;
  const auto& value = typed->value();
  for (unsigned int i = 0; i < value.dimensions(); ++i) list.push_back(static_cast<float>(value[i]));
  return true;
}

void ReadAttribute(const std::string& name, const Imf::Attribute& attribute, ExrImage& image) {
  std::vector<float> list;
  if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&attribute)) {
    image.texts[name] = text->value();
  } else if (const auto* number = dynamic_cast<const Imf::FloatAttribute*>(&attribute)) {
    image.numbers[name] = DecimalOf(number->value());
    image.lists[name] = {number->value()};  // to some writers a list of one float is a float
  } else if (const auto* wide = dynamic_cast<const Imf::DoubleAttribute*>(&attribute)) {
    image.numbers[name] = wide->value();
  } else if (const auto* integer = dynamic_cast<const Imf::IntAttribute*>(&attribute)) {
    image.numbers[name] = integer->value();
  } else if (const auto* floats = dynamic_cast<const Imf::FloatVectorAttribute*>(&attribute)) {
    image.lists[name] = floats->value();
  } else if (ReadVector<Imf::V2fAttribute>(attribute, list) ||
             ReadVector<Imf::V3fAttribute>(attribute, list)) {
    image.lists[name] = list;
  }
}

// The channels to read, in the order of the file.
std::vector<std::string> ChooseChannels(const std::string& file, const Imf::ChannelList& channels,
                                        const std::function<bool(const std::string&)>& wanted) {
  std::vector<std::string> chosen;
  for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
    if (!wanted(channel.name())) continue;
    if (channel.channel().xSampling != 1 || channel.channel().ySampling != 1) {
      throw InputError(file + ": channel '" + Shorten(channel.name(), 60) +
                       "' is subsampled; expected a value for every pixel; remedy: convert the file");
    }
    chosen.push_back(channel.name());
  }
  return chosen;
}

ExrImage ReadPixels(Imf::InputFile& input, const std::filesystem::path& path,
                    const std::function<bool(const std::string&)>& wanted) {
  const std::string file = path.string();
  const Imf::Header& header = input.header();
  const Imath::Box2i window = header.dataWindow();
  ExrImage image;
  const std::vector<std::string> chosen = ChooseChannels(file, header.channels(), wanted);
  const long long width = static_cast<long long>(window.max.x) - window.min.x + 1;
  const long long height = static_cast<long long>(window.max.y) - window.min.y + 1;
  CheckImageSize(file, width, height, static_cast<long long>(chosen.size()));
  image.width = static_cast<int>(width);
  image.height = static_cast<int>(height);
  for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) {
    image.channels.emplace_back(channel.name());
  }
  for (auto it = header.begin(); it != header.end(); ++it) ReadAttribute(it.name(), it.attribute(), image);

  Imf::FrameBuffer frame;
  for (const std::string& name : chosen) {
    PlaneF& plane = image.planes.emplace_back(name, PlaneF(image.width, image.height)).second;
    frame.insert(name, Imf::Slice::Make(Imf::FLOAT, plane.data(), window));
  }
  if (!chosen.empty()) {
    input.setFrameBuffer(frame);
    input.readPixels(window.min.y, window.max.y);
  }
  return image;
}

// Imf::OutputFile writes its table of lines in a destructor that swallows errors; memory has none.
class MemoryStream : public Imf::OStream {
 public:
  MemoryStream() : Imf::OStream("memory") {}
  void write(const char c[], int n) override {
    const std::size_t end = position_ + static_cast<std::size_t>(n);
    if (end > bytes_.size()) bytes_.resize(end);
    std::memcpy(bytes_.data() + position_, c, static_cast<std::size_t>(n));
    position_ = end;
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = static_cast<std::size_t>(position); }
  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
  std::size_t position_ = 0;
};

}  // namespace

const PlaneF* ExrImage::Find(const std::string& name) const {
  for (const auto& [known, plane] : planes) {
    if (known == name) return &plane;
  }
  return nullptr;
}

bool ExrImage::HasAttribute(const std::string& name) const {
  return texts.contains(name) || numbers.contains(name) || lists.contains(name);
}

void CheckImageSize(const std::string& file, long long width, long long height, long long channels) {
  const std::string found = std::to_string(width) + " x " + std::to_string(height) + " pixels in " +
                            std::to_string(channels) + " channels";
  if (width < 1 || height < 1 || width > kLargestImageSide || height > kLargestImageSide ||
      channels > kMostChannels) {
    throw InputError(file + " holds " + found + "; expected 1 to " + std::to_string(kLargestImageSide) +
                     " pixels a side and at most " + std::to_string(kMostChannels) + " channels");
  }
  if (static_cast<double>(width) * static_cast<double>(height) * static_cast<double>(channels) >
      kMostSamples) {
    throw InputError(file + " holds " + found + ", which is more than 1e9 values; remedy: crop or reduce it");
  }
}

ExrImage ReadExr(const std::filesystem::path& path, const std::function<bool(const std::string&)>& wanted) {
  CheckExrHeader(path);
  try {
    Imf::InputFile input(path.c_str());
    return ReadPixels(input, path, wanted);
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw InputError(path.string() + " needs more memory than there is; remedy: crop or reduce it");
  } catch (const std::exception& error) {  // OpenEXR's
    throw InputError(path.string() + " is damaged or incomplete (" + Shorten(error.what(), 160) +
                     "); remedy: restore it from a copy or make it again");
  }
}

std::string EncodeExr(const ExrImage& image) {
  assert(image.width > 0 && image.height > 0 && !image.planes.empty());
  Imf::Header header(image.width, image.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const auto& [name, text] : image.texts) header.insert(name, Imf::StringAttribute(text));
  for (const auto& [name, number] : image.numbers) {
    header.insert(name, Imf::FloatAttribute(static_cast<float>(number)));
  }
  for (const auto& [name, list] : image.lists) header.insert(name, Imf::FloatVectorAttribute(list));
  Imf::FrameBuffer frame;
  for (const auto& [name, plane] : image.planes) {
    assert(plane.SameShape(image.width, image.height));
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    frame.insert(name, Imf::Slice::Make(Imf::FLOAT, plane.data(), header.dataWindow()));
  }
  MemoryStream stream;
  {
    Imf::OutputFile output(stream, header);
    output.setFrameBuffer(frame);
    output.writePixels(image.height);
  }
  return stream.Take();
}

void WriteExr(const std::filesystem::path& path, const ExrImage& image) {
  WriteFileAtomically(path, EncodeExr(image));
}

}  // namespace dermap
