// SPDX-License-Identifier: Apache-2.0
// Stacks as spectral OpenEXR [Fichet, Pacanowski, Wilkie, "An OpenEXR Layout for Spectral Images", JCGT
// 2021].
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/core/error.h"
#include "common/files/stack_parts.h"
#include "common/files/text.h"

namespace dermap {
namespace {

constexpr const char* kLayoutVersion = "spectralLayoutVersion";
constexpr const char* kValid = "valid";
constexpr std::string_view kOurs = "dermap:";
constexpr std::array<std::string_view, 3> kNotNotes{"illumination", "tape", "geometry"};

bool IsReflectance(const std::string& name) {
  return name.starts_with("T.");
}
bool IsSigma(const std::string& name) {
  return name.starts_with("sigma.");
}
bool IsEmissive(const std::string& name) {  // Stokes components S0 to S3
  return name.size() > 3 && name[0] == 'S' && name[1] >= '0' && name[1] <= '3' && name[2] == '.';
}

double RequireWavelength(const std::string& file, const std::string& name, const std::string& prefix) {
  if (const auto wavelength_nm = WavelengthOfChannel(name, prefix)) return *wavelength_nm;
  throw InputError(file + ": the channel '" + Shorten(name, 60) +
                   "' names no wavelength; expected a name such as " + SpectralChannelName(prefix, 450.0));
}

[[noreturn]] void ThrowNoReflectance(const std::string& file, const ExrImage& image) {
  if (std::any_of(image.channels.begin(), image.channels.end(), IsEmissive)) {
    throw InputError(file + " holds emissive channels (S0.…), not reflectance; expected channels such as " +
                     SpectralChannelName("T", 450.0) + "; remedy: divide by the light of the scene first");
  }
  throw InputError(file +
                   " has no reflectance channel (its channels: " + Shorten(Join(image.channels, ", "), 100) +
                   "); expected channels such as " + SpectralChannelName("T", 450.0));
}

void CheckLayoutVersion(const std::string& file, const ExrImage& image) {
  const auto version = image.texts.find(kLayoutVersion);
  if (version != image.texts.end() && version->second != "1.0") {
    throw InputError(file + ": " + kLayoutVersion + " is \"" + Shorten(version->second, 40) +
                     "\"; expected 1.0");
  }
}

// Each sigma plane goes to the band of its wavelength.
void GiveSigma(const std::string& file, double wavelength_nm, PlaneF& sigma, std::vector<BandPlanes>& bands) {
  for (BandPlanes& band : bands) {
    if (std::abs(band.band.wavelength_nm - wavelength_nm) >= 1e-3) continue;
    band.sigma = std::move(sigma);
    return;
  }
  throw InputError(file + " has sigma at " + FormatNumber(wavelength_nm) +
                   " nm, where it has no reflectance; remedy: remove that channel");
}

void ReadNotes(const ExrImage& image, ReflectanceStack& stack) {
  for (const auto& [name, text] : image.texts) {
    if (!name.starts_with(kOurs)) continue;
    const std::string note = name.substr(kOurs.size());
    if (std::find(kNotNotes.begin(), kNotNotes.end(), note) == kNotNotes.end()) stack.notes[note] = text;
  }
}

}  // namespace

ReflectanceStack ReadExrStack(const std::filesystem::path& path) {
  const std::string file = path.string();
  ExrImage image = ReadExr(
      path, [](const std::string& name) { return IsReflectance(name) || IsSigma(name) || name == kValid; });
  if (std::none_of(image.channels.begin(), image.channels.end(), IsReflectance))
    ThrowNoReflectance(file, image);
  CheckLayoutVersion(file, image);
  std::vector<BandPlanes> planes;
  for (auto& [name, plane] : image.planes) {
    if (IsReflectance(name))
      planes.push_back({{RequireWavelength(file, name, "T"), 0.0}, std::move(plane), {}});
  }
  std::sort(planes.begin(), planes.end(), [](const BandPlanes& a, const BandPlanes& b) {
    return a.band.wavelength_nm < b.band.wavelength_nm;
  });
  PlaneF valid;
  for (auto& [name, plane] : image.planes) {
    if (IsSigma(name)) GiveSigma(file, RequireWavelength(file, name, "sigma"), plane, planes);
    if (name == kValid) valid = std::move(plane);
  }
  std::vector<Band> bands;
  for (const BandPlanes& band : planes) bands.push_back(band.band);
  ReadWidths(file, image, bands);
  for (std::size_t i = 0; i < planes.size(); ++i) planes[i].band = bands[i];
  ReflectanceStack stack =
      AssembleStack(file, std::move(planes), std::move(valid), ReadConditions(file, image));
  ReadNoiseCorrelation(file, image, stack);
  ReadSharedError(file, image, stack);
  ReadNotes(image, stack);
  return stack;
}

void WriteExrStack(const std::filesystem::path& path, const ReflectanceStack& stack) {
  ExrImage image;
  image.width = stack.width();
  image.height = stack.height();
  image.texts[kLayoutVersion] = "1.0";
  for (const auto& [name, text] : stack.notes) image.texts[std::string(kOurs) + name] = text;
  WriteConditions(ConditionsOf(stack), image);  // after the notes: no note can pass for one of these
  WriteWidths(stack.bands, image);
  WriteNoiseCorrelation(stack, image);
  WriteSharedError(stack, image);
  for (std::size_t i = 0; i < stack.bands.size(); ++i) {
    const double wavelength_nm = stack.bands[i].wavelength_nm;
    image.planes.emplace_back(SpectralChannelName("T", wavelength_nm), stack.reflectance[i]);
    if (!stack.sigma.empty()) {
      image.planes.emplace_back(SpectralChannelName("sigma", wavelength_nm), stack.sigma[i]);
    }
  }
  if (!stack.valid.empty()) image.planes.emplace_back(kValid, stack.valid);
  WriteExr(path, image);
}

}  // namespace dermap
