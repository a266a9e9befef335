// SPDX-License-Identifier: Apache-2.0
// Within this folder: one flat OpenEXR image, float32 planes by channel name with the attributes that we use.
//
// OpenEXR itself rather than OpenImageIO: the latter writes a list of floats under a type that depends on its
// length (and some lengths not at all), stamps every file with the time, scales integer channels to 0-1 and
// hands planes out interleaved. Files are encoded in memory, so that no failed write can hide in a library's
// destructor.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/core/image.h"

namespace dermap {

// Larger images are refused before anything is allocated for them.
inline constexpr int kLargestImageSide = 16384;
inline constexpr int kMostChannels = 4096;
inline constexpr double kMostSamples = 1e9;  // width * height * channels that are read: 4 GB

struct ExrImage {
  int width = 0;
  int height = 0;
  std::vector<std::pair<std::string, PlaneF>> planes;  // as read: in the order of the file, by name
  std::vector<std::string> channels;  // all names in the file, those that were not wanted as well
  std::map<std::string, std::string> texts;
  std::map<std::string, double> numbers;
  std::map<std::string, std::vector<float>> lists;

  // The plane of that name, or nullptr.
  const PlaneF* Find(const std::string& name) const;
  bool HasAttribute(const std::string& name) const;
};

// Reads the channels that `wanted` says yes to. Half, float and integer channels, any compression, scan lines
// or tiles, any data window; the display window is not looked at. Throws InputError for everything else.
ExrImage ReadExr(const std::filesystem::path& path, const std::function<bool(const std::string&)>& wanted);

// Zip-compressed scan lines; the same image always gives the same bytes. Throws StorageError.
void WriteExr(const std::filesystem::path& path, const ExrImage& image);
std::string EncodeExr(const ExrImage& image);

// Sizes that this program refuses: throws InputError naming file, size and limit.
void CheckImageSize(const std::string& file, long long width, long long height, long long channels);

}  // namespace dermap
