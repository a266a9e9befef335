// SPDX-License-Identifier: Apache-2.0
// Raw decoding by LibRaw: exact values of the active area, the filter pattern, black and white level.
#include "calibrate/raw_frame.h"

#include <libraw/libraw.h>

#include <algorithm>
#include <climits>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>
#include <vector>

#include "calibrate/lossless_jpeg.h"
#include "calibrate/strips.h"
#include "calibrate/unpack_bits.h"
#include "common/core/error.h"
#include "common/files/atomic_file.h"
#include "common/files/raw_guard.h"

namespace dermap {
namespace {

[[noreturn]] void Fail(const std::filesystem::path& path, const std::string& found) {
  throw InputError(path.string() + ": " + found +
                   "; expected a complete raw file (DNG, CR2, CR3, NEF, ARW, ...) with one value a "
                   "photosite; capture this frame again or copy "
                   "it from the camera again");
}

// LibRaw with quick ways through DNG files whose values are packed without compression (12 bits, mostly), and
// through Canon's lossless JPEG: LibRaw's own ask their stream for one byte after another, which takes 25 and
// 8 times as long. All else (levels, covered margins, sizes) stays LibRaw's.
class QuickRaw : public LibRaw {
 public:
  explicit QuickRaw(std::span<const std::byte> file)
      : file_(reinterpret_cast<const std::uint8_t*>(file.data()), file.size()) {}
  // Between open_*() and unpack(): puts a quick decoder in the place of LibRaw's where it reads the file
  // alike.
  void DecodeQuickly();

 private:
  using Decoder = void (LibRaw::*)();
  bool Packed() const;
  void OpenJpeg();
  void LoadPacked();
  void LoadJpeg();

  std::span<const std::uint8_t> file_;
  std::optional<LosslessJpeg> jpeg_;
  StripLayout strips_;
  Decoder slow_ = nullptr;
};

bool IsIdentity(const std::uint16_t* curve, int bits) {
  for (int v = 0; v < 1 << bits; ++v) {
    if (curve[v] != v) return false;
  }
  return true;
}

void QuickRaw::DecodeQuickly() {
  libraw_decoder_info_t decoder{};
  if (get_decoder_info(&decoder) != LIBRAW_SUCCESS || decoder.decoder_name == nullptr) return;
  const std::string_view name = decoder.decoder_name;
  slow_ = load_raw;
  if (name == "packed_dng_load_raw()" && Packed()) load_raw = static_cast<Decoder>(&QuickRaw::LoadPacked);
  if (name == "lossless_jpeg_load_raw()") OpenJpeg();
  if (jpeg_) load_raw = static_cast<Decoder>(&QuickRaw::LoadJpeg);
}

bool QuickRaw::Packed() const {
  const auto& data = libraw_internal_data.unpacker_data;
  const auto bits = static_cast<int>(data.tiff_bps);
  return data.tiff_samples == 1 && data.tile_length >= static_cast<unsigned>(INT_MAX) &&
         bits >= kFewestPackedBits && bits <= kMostPackedBits;
}

// What LibRaw places otherwise than in strips that fill the sensor is left to it: interlaced rows, and the
// EOS-1D Mark III, whose rows begin two photosites off.
void QuickRaw::OpenJpeg() {
  constexpr int kShiftedRows = 3984;
  const auto& data = libraw_internal_data.unpacker_data;
  const auto& sizes = imgdata.sizes;
  if (data.load_flags != 0 || sizes.raw_width == kShiftedRows || data.data_offset < 0 ||
      static_cast<std::uint64_t>(data.data_offset) >= file_.size())
    return;
  const int before = data.cr2_slice[0];
  strips_ = before == 0 ? StripLayout{1, 0, sizes.raw_width, sizes.raw_height}
                        : StripLayout{before + 1, data.cr2_slice[1], data.cr2_slice[2], sizes.raw_height};
  if ((strips_.strips - 1) * strips_.width + strips_.last_width != sizes.raw_width) return;
  jpeg_ = LosslessJpeg::Open(file_.subspan(static_cast<std::size_t>(data.data_offset)));
  if (jpeg_ && !Fills(*jpeg_, strips_)) jpeg_.reset();
}

// Called by unpack(), which has allocated the values, and goes by load_raw when it looks for covered margins.
void QuickRaw::LoadJpeg() {
  load_raw = slow_;
  std::uint16_t* values = imgdata.rawdata.raw_image;
  if (values == nullptr) return (this->*slow_)();
  const std::size_t pitch = imgdata.sizes.raw_pitch / sizeof(*values);
  if (!DecodeStrips(*jpeg_, strips_, pitch, values))
    return derror();  // as LibRaw does where data are damaged
  const std::uint16_t* curve = imgdata.color.curve;
  if (IsIdentity(curve, jpeg_->shape().bits)) return;
  for (int y = 0; y < imgdata.sizes.raw_height; ++y) {
    std::uint16_t* row = values + static_cast<std::size_t>(y) * pitch;
    for (int x = 0; x < imgdata.sizes.raw_width; ++x) row[x] = curve[row[x]];
  }
}

// Called by unpack(), which has allocated the values and stands at their place in the file.
void QuickRaw::LoadPacked() {
  load_raw = slow_;
  std::uint16_t* values = imgdata.rawdata.raw_image;
  if (values == nullptr) return (this->*slow_)();
  const auto& sizes = imgdata.sizes;
  const auto bits = static_cast<int>(libraw_internal_data.unpacker_data.tiff_bps);
  const std::size_t row_bytes = (std::size_t{sizes.raw_width} * static_cast<std::size_t>(bits) + 7) / 8;
  const std::size_t pitch = sizes.raw_pitch / sizeof(*values);
  const std::uint16_t* curve = imgdata.color.curve;
  const bool straight = IsIdentity(curve, bits);
  std::vector<std::uint8_t> bytes(row_bytes + kBytesBeyondPacked);
  for (int y = 0; y < sizes.raw_height; ++y) {
    if (libraw_internal_data.internal_data.input->read(bytes.data(), 1, row_bytes) !=
        static_cast<int>(row_bytes)) {
      derror();  // as LibRaw does where a file ends early
      return;
    }
    const std::span row(values + static_cast<std::size_t>(y) * pitch, sizes.raw_width);
    UnpackBits(bytes, bits, row);
    for (std::size_t x = straight ? row.size() : 0; x < row.size(); ++x) row[x] = curve[row[x]];
  }
}

// LibRaw calls this where data ends early or makes no sense, and then goes on with what it has.
void CountDataError(void* data, const char*, int) {
  ++*static_cast<int*>(data);
}

void CheckSizes(const libraw_image_sizes_t& s, const std::filesystem::path& path) {
  const std::string problem =
      RawSizeProblem({s.width, s.height, s.raw_width, s.raw_height, s.left_margin, s.top_margin});
  if (!problem.empty()) Fail(path, problem);
}

constexpr unsigned kXTrans = 9;  // LibRaw's code in `filters`

void ReadPattern(LibRaw& raw, const std::filesystem::path& path, BayerFrame& frame) {
  const unsigned filters = raw.imgdata.idata.filters;
  if (filters == 0 && raw.imgdata.idata.colors == 1) {
    frame.colours.fill('W');
    return;
  }
  if (filters == kXTrans) {
    frame.colours.fill('X');
    frame.period = 6;
    return;
  }
  // Below 1000 LibRaw's other codes mean a pattern of a scanning back, or none.
  if (filters < 1000) Fail(path, "a filter pattern that is neither 2x2 nor X-Trans");
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) {
      const int colour = raw.COLOR(y, x);
      const char letter = colour >= 0 && colour < 4 ? raw.imgdata.idata.cdesc[colour] : '?';
      char& known = frame.colours[LatticeOf(x, y)];
      if (known == 0) known = letter;
      if (known != letter || letter < 'A' || letter > 'Z')
        Fail(path, "a filter pattern that does not repeat after 2");
    }
  }
}

double BlackLevel(const libraw_colordata_t& color) {
  double level = color.black;
  for (int i = 0; i < 4; ++i) level += color.cblack[i] / 4.0;
  const unsigned cells = color.cblack[4] * color.cblack[5];
  for (unsigned i = 0; i < cells && 6 + i < LIBRAW_CBLACK_SIZE; ++i)
    level += color.cblack[6 + i] / double(cells);
  return level;
}

BayerFrame Extract(LibRaw& raw, const std::filesystem::path& path) {
  const auto& sizes = raw.imgdata.sizes;
  const auto* values = raw.imgdata.rawdata.raw_image;
  if (values == nullptr) Fail(path, "no plain sensor values (already demosaiced, or floating point)");
  BayerFrame frame;
  frame.values = Plane<std::uint16_t>(sizes.width, sizes.height);
  const std::size_t pitch = sizes.raw_pitch / sizeof(*values);
  for (int y = 0; y < sizes.height; ++y) {
    const auto* row = values + (y + sizes.top_margin) * pitch + sizes.left_margin;
    std::copy_n(row, sizes.width, frame.values.Row(y));
  }
  ReadPattern(raw, path, frame);
  frame.black_level = BlackLevel(raw.imgdata.color);
  frame.white_level = raw.imgdata.color.maximum;
  frame.exposure_ms = 1000.0 * raw.imgdata.other.shutter;
  frame.iso = static_cast<int>(std::lround(raw.imgdata.other.iso_speed));
  if (!(frame.white_level > frame.black_level)) Fail(path, "a white level that is not above the black level");
  return frame;
}

}  // namespace

BayerFrame ReadBayerFrame(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) Fail(path, "there is no such file");
  // From memory: by name LibRaw asks a stream for every byte, which takes longer than decoding.
  std::vector<std::byte> bytes = ReadBinaryFile(path);
  if (!SurvivesLibRaw(bytes)) Fail(path, "damaged where it names its camera");
  const auto raw =
      std::make_unique<QuickRaw>(bytes);  // some hundred kilobytes: too large for a thread's stack
  int data_errors = 0;
  raw->set_dataerror_handler(CountDataError, &data_errors);
  raw->imgdata.params.max_raw_memory_mb = kMostRawMemory_mb;
  if (const int code = raw->open_buffer(bytes.data(), bytes.size()); code != LIBRAW_SUCCESS) {
    Fail(path, std::string("not a raw file that can be read (") + libraw_strerror(code) + ")");
  }
  CheckSizes(raw->imgdata.sizes, path);
  raw->DecodeQuickly();
  if (const int code = raw->unpack(); code != LIBRAW_SUCCESS) {
    Fail(path, std::string("damaged or cut short (") + libraw_strerror(code) + ")");
  }
  if (data_errors > 0 || raw->error_count() > 0) Fail(path, "damaged or cut short");
  return Extract(*raw, path);
}

RawExposure ReadRawExposure(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) Fail(path, "there is no such file");
  if (!SurvivesLibRaw(path)) Fail(path, "damaged where it names its camera");
  const auto raw = std::make_unique<LibRaw>();
  if (const int code = raw->open_file(path.c_str()); code != LIBRAW_SUCCESS) {
    Fail(path, std::string("not a raw file that can be read (") + libraw_strerror(code) + ")");
  }
  return {1000.0 * raw->imgdata.other.shutter, static_cast<int>(std::lround(raw->imgdata.other.iso_speed))};
}

}  // namespace dermap
