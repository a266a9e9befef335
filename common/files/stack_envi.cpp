// SPDX-License-Identifier: Apache-2.0
// Stacks as ENVI: NAME.hdr + NAME.img, and NAME_sigma, NAME_valid beside them where the stack has these.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/envi_data.h"
#include "common/files/envi_header.h"
#include "common/files/spectral_attributes.h"
#include "common/files/stack_parts.h"
#include "common/files/text.h"

namespace dermap {
namespace {

constexpr const char* kNotePrefix = "dermap note ";
constexpr const char* kSharedError = "dermap shared error";
constexpr const char* kCorrelationX = "dermap noise correlation x";
constexpr const char* kCorrelationY = "dermap noise correlation y";

// What one unit of the header's wavelengths is in nm.
double NanometresPerUnit(const EnviHeader& header, const std::vector<double>& wavelengths) {
  const std::string units = LowerCase(header.Text("wavelength units").value_or("unknown"));
  if (units == "nanometers" || units == "nanometres" || units == "nm") return 1.0;
  if (units == "micrometers" || units == "micrometres" || units == "um" || units == "microns") return 1000.0;
  if (units == "unknown") {  // ENVI's default: the number itself tells, the two ranges of light are far apart
    const auto [least, most] = std::minmax_element(wavelengths.begin(), wavelengths.end());
    if (*least >= 100.0) return 1.0;
    if (*most <= 100.0) return 1000.0;
  }
  throw InputError(header.file() + ": 'wavelength units' is \"" + Shorten(units, 40) +
                   "\"; expected Nanometers or Micrometers");
}

std::vector<Band> ReadEnviBands(const EnviHeader& header, const EnviLayout& layout) {
  const auto wavelengths = header.Numbers("wavelength");
  const auto bands = static_cast<std::size_t>(layout.bands);
  if (!wavelengths || wavelengths->size() != bands) {
    throw InputError(header.file() + ": 'wavelength' has " +
                     std::to_string(wavelengths ? wavelengths->size() : 0) +
                     " values; expected one for each of its " + std::to_string(bands) + " bands");
  }
  const double nm = NanometresPerUnit(header, *wavelengths);
  const auto widths = header.Numbers("fwhm");
  if (widths && widths->size() != bands) {
    throw InputError(header.file() + ": 'fwhm' has " + std::to_string(widths->size()) +
                     " values; expected one for each of its " + std::to_string(bands) + " bands");
  }
  std::vector<Band> result;
  for (std::size_t i = 0; i < bands; ++i) {
    result.push_back({(*wavelengths)[i] * nm, widths ? (*widths)[i] * nm : 0.0});
  }
  return result;
}

std::vector<float> ReadCorrelation(const EnviHeader& header, const char* key) {
  const std::vector<double> numbers = header.Numbers(key).value_or(std::vector<double>{});
  const std::vector<float> lags(numbers.begin(), numbers.end());
  CheckNoiseCorrelation(header.file() + ": '" + key + "'", lags);
  return lags;
}

// 'reflectance scale factor' and 'data ignore value', both ENVI's own keys.
void ToReflectance(const EnviHeader& header, const EnviLayout& layout, std::vector<PlaneF>& planes) {
  const auto scale = header.Number("reflectance scale factor");
  const auto ignored = header.Number("data ignore value");
  if (layout.IsInteger() && !scale) {
    throw InputError(header.file() +
                     ": integers without 'reflectance scale factor'; remedy: add it (10000 where 10000 " +
                     "means a reflectance of 1)");
  }
  if (scale && *scale <= 0.0) {
    throw InputError(header.file() + ": 'reflectance scale factor' is " + FormatNumber(*scale) +
                     "; expected a number above 0");
  }
  const float divisor = static_cast<float>(scale.value_or(1.0));
  const float missing = static_cast<float>(ignored.value_or(0.0));
  for (PlaneF& plane : planes) {
    for (float& value : plane.values()) {
      value = ignored && value == missing ? std::numeric_limits<float>::quiet_NaN() : value / divisor;
    }
  }
}

// ENVI's bad bands list: 0 marks a band that is not to be used.
std::vector<bool> ReadGoodBands(const EnviHeader& header, const EnviLayout& layout) {
  std::vector<bool> good(static_cast<std::size_t>(layout.bands), true);
  const auto list = header.Numbers("bbl");
  if (!list) return good;
  if (list->size() != good.size()) {
    throw InputError(header.file() + ": 'bbl' has " + std::to_string(list->size()) +
                     " values; expected one for each of its " + std::to_string(good.size()) + " bands");
  }
  std::transform(list->begin(), list->end(), good.begin(), [](double value) { return value != 0.0; });
  if (std::none_of(good.begin(), good.end(), [](bool is_good) { return is_good; })) {
    throw InputError(header.file() + ": 'bbl' marks every band as bad; expected at least one good band");
  }
  return good;
}

FileConditions ReadEnviConditions(const EnviHeader& header) {
  const std::string prefix = header.file() + ": ";
  FileConditions conditions;
  if (const auto size = header.Number("dermap pixel size mm")) {
    conditions.pixel_size_mm = CheckedPixelSize(prefix + "'dermap pixel size mm'", *size);
  }
  if (const auto name = header.Text("dermap illumination")) {
    conditions.illumination = IlluminationFromName(prefix + "'dermap illumination'", *name);
  }
  if (const auto name = header.Text("dermap tape"))
    conditions.tape = TapeFromName(prefix + "'dermap tape'", *name);
  if (const auto name = header.Text("dermap geometry")) {
    conditions.geometry = GeometryFromName(prefix + "'dermap geometry'", *name);
  }
  return conditions;
}

// The planes of a companion image (NAME_sigma, NAME_valid) that the header's `key` names; empty where it
// names none.
std::vector<PlaneF> ReadCompanion(const std::filesystem::path& path, const EnviHeader& header,
                                  const std::string& key, const EnviLayout& shape) {
  const auto name = header.Text(key);
  if (!name) return {};
  if (name->empty() || std::filesystem::path(*name).filename() != *name) {
    throw InputError(header.file() + ": '" + key + "' is \"" + Shorten(*name, 60) +
                     "\"; expected the name of a header beside it");
  }
  const std::filesystem::path companion = path.parent_path() / *name;
  const EnviHeader companion_header = EnviHeader::Read(companion);
  const EnviLayout layout = ReadEnviLayout(companion_header);
  if (layout.samples != shape.samples || layout.lines != shape.lines || layout.bands != shape.bands) {
    throw InputError(fmt::format("{} is {} x {} pixels in {} bands; expected {} x {} in {}, as {} says",
                                 companion.string(), layout.samples, layout.lines, layout.bands,
                                 shape.samples, shape.lines, shape.bands, header.file()));
  }
  return ReadEnviPlanes(FindEnviData(companion), layout);
}

std::string BracedList(const std::vector<Band>& bands, double Band::*member) {
  std::vector<std::string> numbers;
  for (const Band& band : bands) numbers.push_back(FormatNumber(band.*member));
  return fmt::format("{{{}}}", Join(numbers, ", "));
}

// A header's values are lines, and a brace would open a list.
std::string OneLine(std::string text) {
  for (char& c : text) {
    if (c == '\n' || c == '\r') c = ' ';
    if (c == '{') c = '(';
    if (c == '}') c = ')';
  }
  return text;
}

std::string CommonHeader(const char* description, int samples, int lines, std::size_t bands) {
  return fmt::format(
      "ENVI\ndescription = {{{}}}\nsamples = {}\nlines = {}\nbands = {}\nheader offset = 0\n"
      "file type = ENVI Standard\ndata type = 4\ninterleave = bsq\nbyte order = 0\n",
      description, samples, lines, bands);
}

std::string SpectralKeys(const ReflectanceStack& stack) {
  std::string text =
      "wavelength units = Nanometers\nwavelength = " + BracedList(stack.bands, &Band::wavelength_nm);
  const bool widths =
      std::any_of(stack.bands.begin(), stack.bands.end(), [](const Band& b) { return b.fwhm_nm > 0; });
  if (widths) text += "\nfwhm = " + BracedList(stack.bands, &Band::fwhm_nm);
  for (const auto& [key, lags] : {std::pair(kCorrelationX, &stack.noise_correlation_x),
                                  std::pair(kCorrelationY, &stack.noise_correlation_y)}) {
    if (lags->empty()) continue;
    std::vector<std::string> numbers;
    for (float correlation : *lags) numbers.push_back(FormatNumber(DecimalOf(correlation)));
    text += fmt::format("\n{} = {{{}}}", key, Join(numbers, ", "));
  }
  return text + "\n";
}

}  // namespace

ReflectanceStack ReadEnviStack(const std::filesystem::path& path) {
  const EnviHeader header = EnviHeader::Read(path);
  const EnviLayout layout = ReadEnviLayout(header);
  const std::vector<Band> bands = ReadEnviBands(header, layout);
  const std::vector<bool> good = ReadGoodBands(header, layout);
  std::vector<PlaneF> reflectance = ReadEnviPlanes(FindEnviData(path), layout);
  ToReflectance(header, layout, reflectance);
  std::vector<PlaneF> sigma = ReadCompanion(path, header, "dermap sigma header", layout);
  EnviLayout one_band = layout;
  one_band.bands = 1;
  std::vector<PlaneF> valid = ReadCompanion(path, header, "dermap valid header", one_band);
  std::vector<BandPlanes> planes;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    if (!good[i]) continue;
    planes.push_back({bands[i], std::move(reflectance[i]), sigma.empty() ? PlaneF() : std::move(sigma[i])});
  }
  ReflectanceStack stack =
      AssembleStack(header.file(), std::move(planes), valid.empty() ? PlaneF() : std::move(valid[0]),
                    ReadEnviConditions(header));
  stack.noise_correlation_x = ReadCorrelation(header, kCorrelationX);
  stack.noise_correlation_y = ReadCorrelation(header, kCorrelationY);
  if (const auto error = header.Number(kSharedError))
    stack.shared_error = CheckedSharedError(fmt::format("{}: '{}'", header.file(), kSharedError), *error);
  stack.notes = header.WithPrefix(kNotePrefix);
  return stack;
}

void WriteEnviStack(const std::filesystem::path& path, const ReflectanceStack& stack) {
  const auto beside = [&](const std::string& ending) {
    return path.parent_path() / (path.stem().string() + ending);
  };
  std::string header =
      CommonHeader("Reflectance, fraction", stack.width(), stack.height(), stack.bands.size()) +
      SpectralKeys(stack);
  if (stack.pixel_size_mm) header += "dermap pixel size mm = " + FormatNumber(*stack.pixel_size_mm) + "\n";
  if (stack.shared_error) header += fmt::format("{} = {}\n", kSharedError, FormatNumber(*stack.shared_error));
  header += "dermap illumination = " + IlluminationName(stack.illumination) + "\n";
  header += "dermap tape = " + TapeName(stack.tape) + "\n";
  header += "dermap geometry = " + GeometryName(stack.geometry) + "\n";
  FileBatch batch;
  const auto write_companion = [&](const std::string& what, const std::string& companion_header,
                                   const std::vector<PlaneF>& planes) {
    WriteFileAtomically(beside("_" + what + ".img"), EncodeEnviPlanes(planes));
    WriteFileAtomically(beside("_" + what + ".hdr"), companion_header);
    header += fmt::format("dermap {} header = {}\n", what, beside("_" + what + ".hdr").filename().string());
  };
  if (!stack.sigma.empty()) {
    const std::string common = CommonHeader("Reflectance, one standard deviation", stack.width(),
                                            stack.height(), stack.bands.size());
    write_companion("sigma", common + SpectralKeys(stack), stack.sigma);
  }
  if (!stack.valid.empty()) {
    write_companion("valid", CommonHeader("1 where the pixel is valid", stack.width(), stack.height(), 1),
                    {stack.valid});
  }
  for (const auto& [name, text] : stack.notes) header += kNotePrefix + name + " = " + OneLine(text) + "\n";
  WriteFileAtomically(beside(".img"), EncodeEnviPlanes(stack.reflectance));
  WriteFileAtomically(path, header);  // last: it names the others
  batch.Commit();
}

}  // namespace dermap
