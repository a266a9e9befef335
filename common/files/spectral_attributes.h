// SPDX-License-Identifier: Apache-2.0
// Within this folder: what stacks and maps say about how they were taken, as attributes, with every value
// checked.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/files/exr_file.h"
#include "common/files/stack.h"
#include "common/transport/conditions.h"

namespace dermap {

struct FileConditions {
  std::optional<double> pixel_size_mm;
  Illumination illumination = Illumination::kWindow;
  Tape tape = Tape::kFree;
  Geometry geometry = Geometry::kHemispherical;
};

std::string IlluminationName(Illumination illumination);
std::string TapeName(Tape tape);
std::string GeometryName(Geometry geometry);

// `where` begins the sentence of the InputError: the file and the key.
Illumination IlluminationFromName(const std::string& where, const std::string& name);
Tape TapeFromName(const std::string& where, const std::string& name);
Geometry GeometryFromName(const std::string& where, const std::string& name);
double CheckedPixelSize(const std::string& where, double pixel_size_mm);
// Wavelengths in 350-1000 nm, widths 0-200 nm, no two bands alike.
void CheckBands(const std::string& file, const std::vector<Band>& bands);

// The attributes dermap:pixelSizeMm, dermap:illumination, dermap:tape, dermap:geometry.
FileConditions ReadConditions(const std::string& file, const ExrImage& image);
void WriteConditions(const FileConditions& conditions, ExrImage& image);

// dermap:fwhmNm into bands that stand in order of wavelength; absent: all 0.
void ReadWidths(const std::string& file, const ExrImage& image, std::vector<Band>& bands);
void WriteWidths(const std::vector<Band>& bands, ExrImage& image);

// dermap:noiseCorrelationX and ...Y, lags 1, 2, ...; absent: independent noise.
void ReadNoiseCorrelation(const std::string& file, const ExrImage& image, ReflectanceStack& stack);
void WriteNoiseCorrelation(const ReflectanceStack& stack, ExrImage& image);
// Between -1 and 1, at most kMaxCorrelationLags; throws InputError.
inline constexpr std::size_t kMaxCorrelationLags = 16;
void CheckNoiseCorrelation(const std::string& where, const std::vector<float>& lags);

// dermap:sharedError; absent: not known. 0 to 0.1, else InputError.
void ReadSharedError(const std::string& file, const ExrImage& image, ReflectanceStack& stack);
void WriteSharedError(const ReflectanceStack& stack, ExrImage& image);
double CheckedSharedError(const std::string& where, double shared_error);

}  // namespace dermap
