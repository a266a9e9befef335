// SPDX-License-Identifier: Apache-2.0
// Light through the bench. Crossed polarizers are ideal unless a scene says otherwise: no surface reflection,
// and diffuse light of the skin and of the Spectralon depolarized alike ([D08 6.4] measures that it is not).
#include "acquire/simulated/optical_bench.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "acquire/simulated/random_field.h"
#include "acquire/simulated/window_dirt.h"
#include "common/core/error.h"
#include "common/core/parallel.h"
#include "common/transport/band_optics.h"

namespace dermap {
namespace {

constexpr int kSubsamples = 4;             // a photosite's area is sampled by 4 x 4
constexpr double kTapeTileSide_mm = 24.0;  // around the window's centre
constexpr int kTapeTileSize_px = 480;
constexpr double kTapeGrain_px = 1.7;  // of the tile: 0.085 mm
constexpr double kUnevennessRadius_mm = 5.0;
constexpr double kCardMargin_px = 6.0;  // the card is larger than the region in which it is read

// Red, green or blue of a photosite. X-Trans as Fujifilm's cameras have it, from the top left.
int ChannelOf(BenchConfig::Filters filters, int x, int y) {
  constexpr const char* kXTrans[6] = {"GBGGRG", "RGRBGB", "GBGGRG", "GRGGBG", "BGBRGR", "GRGGBG"};
  if (filters == BenchConfig::Filters::kNone) return 1;
  if (filters == BenchConfig::Filters::kRggb) return (y % 2) + (x % 2);
  const char letter = kXTrans[y % 6][x % 6];
  return letter == 'R' ? 0 : letter == 'G' ? 1 : 2;
}

std::filesystem::path ConfigFile(const std::filesystem::path& relative) {
  return ConfigDirectory() / relative;
}

PlaneF MakeShading(const BenchConfig& config, const PinholeView& view) {
  PlaneF shading(config.width_px, config.height_px);
  const double cx = 0.5 * (config.width_px - 1), cy = 0.5 * (config.height_px - 1);
  // cos^4 of the field angle, with the focal length that loses `vignetting` in the corner.
  const double corner_cos2 = std::sqrt(1.0 - config.vignetting);
  const double tan2_at_corner = 1.0 / corner_cos2 - 1.0;
  for (int y = 0; y < config.height_px; ++y) {
    for (int x = 0; x < config.width_px; ++x) {
      const double r2 = ((x - cx) * (x - cx) + (y - cy) * (y - cy)) / (cx * cx + cy * cy);
      const double cos2 = 1.0 / (1.0 + r2 * tan2_at_corner);
      // The flash: a Gaussian falloff around a point a little off the window's centre.
      const Point2 p = view.BenchFromPixel({static_cast<double>(x), static_cast<double>(y)});
      const double d2 = ((p.x - 0.8) * (p.x - 0.8) + (p.y + 0.5) * (p.y + 0.5)) /
                        (kUnevennessRadius_mm * kUnevennessRadius_mm);
      shading(x, y) = static_cast<float>(cos2 * cos2 * std::pow(1.0 - config.flash_unevenness, d2));
    }
  }
  return shading;
}

void Blur(PlaneF& plane, double sigma_px) {
  if (sigma_px <= 0.0) return;
  cv::Mat view(plane.height(), plane.width(), CV_32F, plane.data());
  cv::GaussianBlur(view, view, cv::Size(0, 0), sigma_px, sigma_px, cv::BORDER_REPLICATE);
}

PlaneF MakeTape(const BenchConfig& config, std::uint64_t seed) {
  PlaneF tape(kTapeTileSize_px, kTapeTileSize_px, static_cast<float>(config.tape_reflectance));
  if (config.tape_texture == 0.0) return tape;
  auto random = RandomStream(seed, "tape");
  PlaneF noise(kTapeTileSize_px, kTapeTileSize_px);
  for (float& v : noise.values()) v = static_cast<float>(Normal(random));
  Blur(noise, kTapeGrain_px);
  // What a Gaussian filter of this width leaves of white noise of variance 1: 1 / (4 pi sigma^2).
  const double to_unit = 2.0 * std::sqrt(std::numbers::pi) * kTapeGrain_px;
  for (std::size_t i = 0; i < tape.size(); ++i) {
    const double wave = std::clamp(to_unit * noise.values()[i], -3.0, 3.0);
    tape.values()[i] =
        static_cast<float>(config.tape_reflectance * std::max(0.0, 1.0 + config.tape_texture * wave));
  }
  return tape;
}

// Position of a sample between four pixels whose centres are whole numbers; clamped at the border.
struct Bilinear {
  std::size_t i00, i10, i01, i11;
  float u, v;
  Bilinear(double x, double y, int width, int height) {
    const double cx = std::clamp(x, 0.0, width - 1.0), cy = std::clamp(y, 0.0, height - 1.0);
    const int x0 = std::min(static_cast<int>(cx), width - 2), y0 = std::min(static_cast<int>(cy), height - 2);
    u = static_cast<float>(cx - x0);
    v = static_cast<float>(cy - y0);
    i00 = static_cast<std::size_t>(y0) * width + x0;
    i10 = i00 + 1;
    i01 = i00 + width;
    i11 = i01 + 1;
  }
  float At(const PlaneF& p) const {
    const float* d = p.data();
    return (1 - v) * ((1 - u) * d[i00] + u * d[i10]) + v * ((1 - u) * d[i01] + u * d[i11]);
  }
};

// The lens spreads a share of each colour's light evenly over the frame.
void AddStrayLight(BenchConfig::Filters filters, double share, PlaneF& electrons) {
  std::array<double, 3> sum{}, count{};
  for (int y = 0; y < electrons.height(); ++y) {
    for (int x = 0; x < electrons.width(); ++x) {
      const auto c = static_cast<std::size_t>(ChannelOf(filters, x, y));
      sum[c] += electrons(x, y);
      count[c] += 1.0;
    }
  }
  for (int y = 0; y < electrons.height(); ++y) {
    for (int x = 0; x < electrons.width(); ++x) {
      const auto c = static_cast<std::size_t>(ChannelOf(filters, x, y));
      electrons(x, y) = static_cast<float>((1.0 - share) * electrons(x, y) + share * sum[c] / count[c]);
    }
  }
}

// Share of [i - 0.5, i + 0.5] that lies in [low, high].
double Overlap(int i, double low, double high) {
  return std::clamp(std::min(i + 0.5, high) - std::max(i - 0.5, low), 0.0, 1.0);
}

}  // namespace

OpticalBench::OpticalBench(const RigConfig& rig, Scene scene, const ProgressFunction& progress)
    : OpticalBench(rig, scene, RenderPatch(scene, rig, progress)) {}

OpticalBench::OpticalBench(const RigConfig& rig, Scene scene, PatchReflectance patch)
    : rig_(rig),
      scene_(std::move(scene)),
      patch_(std::move(patch)),
      view_(scene_.bench, rig_.view_angle_deg),
      sensor_(scene_.bench, scene_.seed),
      flash_(ReadSpectrumCsv(ConfigFile("spectra/xenon_flash.csv"), "relative_power")),
      spectralon_(ReadSpectrumCsv(ConfigFile(rig_.spectralon_csv), "reflectance")),
      camera_{ReadSpectrumCsv(ConfigFile("spectra/camera_rgb.csv"), "red"),
              ReadSpectrumCsv(ConfigFile("spectra/camera_rgb.csv"), "green"),
              ReadSpectrumCsv(ConfigFile("spectra/camera_rgb.csv"), "blue")},
      shading_(MakeShading(scene_.bench, view_)),
      tape_(MakeTape(scene_.bench, scene_.seed)) {}

const WheelSlot& OpticalBench::SlotOf(const Shot& shot) const {
  if (const WheelSlot* slot = FindSlot(rig_, shot.slot)) return *slot;
  throw DeviceError("Simulated wheel: slot " + std::to_string(shot.slot) + " is not in rig \"" + rig_.name +
                    "\".");
}

double OpticalBench::FlashFactor(int shot_number) const {
  const auto& misfired = scene_.bench.misfired_shots;
  if (std::find(misfired.begin(), misfired.end(), shot_number) != misfired.end()) return 0.0;
  auto random = RandomStream(scene_.seed, "flash drift", static_cast<std::uint64_t>(shot_number));
  return 1.0 + scene_.bench.flash_drift * std::clamp(Normal(random), -2.5, 2.5);
}

Pose OpticalBench::PoseOfShot(const Shot& shot) const {
  if (shot.target != FrameRole::kSkin) return {};
  auto random = RandomStream(scene_.seed, "motion", static_cast<std::uint64_t>(shot.number));
  const double direction = 2.0 * std::numbers::pi * Uniform(random);
  const double length_mm = scene_.bench.motion_shift_mm * std::sqrt(Uniform(random));  // even over the disc
  const double rotation_deg = scene_.bench.motion_rotation_deg * (2.0 * Uniform(random) - 1.0);
  Pose pose{length_mm * std::cos(direction), length_mm * std::sin(direction), rotation_deg, 0, 0, 0, 0};
  auto stretch = RandomStream(scene_.seed, "stretch", static_cast<std::uint64_t>(shot.number));
  pose.strain_x = scene_.bench.stretch * (2.0 * Uniform(stretch) - 1.0);
  pose.strain_y = scene_.bench.stretch * (2.0 * Uniform(stretch) - 1.0);
  pose.bulge_x_mm = scene_.bench.stretch_mm * (2.0 * Uniform(stretch) - 1.0);
  pose.bulge_y_mm = scene_.bench.stretch_mm * (2.0 * Uniform(stretch) - 1.0);
  return pose;
}

std::array<Point2, 4> OpticalBench::CornersOfShot(const Shot& shot) const {
  return WindowCorners(view_, PoseOfShot(shot), rig_.window_mm);
}

OpticalBench::BandLight OpticalBench::LightOfBand(const WheelSlot& slot) const {
  BandLight light;
  const Band band{slot.wavelength_nm, slot.fwhm_nm};
  while (patch_.bands[static_cast<std::size_t>(light.band)].wavelength_nm != band.wavelength_nm) ++light.band;
  const std::vector<FilterNode> nodes = FilterNodes(band);
  light.electrons.resize(nodes.size());
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const double nm = nodes[n].wavelength_nm;
    // A filter of ideal peak transmission passes light in proportion to its width.
    const double power = scene_.bench.white_electrons * nodes[n].weight * flash_.At(nm) * band.fwhm_nm / 10.0;
    for (std::size_t c = 0; c < 3; ++c) {
      light.electrons[n][c] = power * camera_[c].At(nm);
      light.white[c] += light.electrons[n][c];
      light.spectralon[c] += light.electrons[n][c] * spectralon_.At(nm);
    }
  }
  return light;
}

void OpticalBench::DrawSkin(const Shot& shot, const BandLight& light, std::array<PlaneF, 3>& content) const {
  const auto& nodes = patch_.nodes[static_cast<std::size_t>(light.band)];
  std::array<PlaneF, 3> patch;  // electrons of each channel
  for (std::size_t c = 0; c < 3; ++c) {
    patch[c] = PlaneF(kPatchSize_px, kPatchSize_px);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const auto weight = static_cast<float>(light.electrons[n][c]);
      for (std::size_t i = 0; i < patch[c].size(); ++i) patch[c].values()[i] += weight * nodes[n].values()[i];
    }
  }
  const Pose pose = PoseOfShot(shot);
  const double w = rig_.window_mm;
  const WindowDirt dirt(scene_.bench, w, scene_.seed);
  const double depolarized = 1.0 + scene_.bench.polarizer_sign * scene_.bench.polarizer_skin;
  const double patch_px_per_mm = kPatchSize_px / w, tape_px_per_mm = kTapeTileSize_px / kTapeTileSide_mm;
  ParallelFor(content[0].height(), [&](int y) {
    for (int x = 0; x < content[0].width(); ++x) {
      std::array<float, 3> sum{};
      for (int s = 0; s < kSubsamples * kSubsamples; ++s) {
        const Point2 pixel{x + (s % kSubsamples + 0.5) / kSubsamples - 0.5,
                           y + (s / kSubsamples + 0.5) / kSubsamples - 0.5};
        const Point2 p = PatchFromBench(pose, w, view_.BenchFromPixel(pixel));
        const double light_left = dirt.Clear(p) * dirt.Lit(p);
        if (dirt.InWindow(p)) {
          const Bilinear at(p.x * patch_px_per_mm - 0.5, p.y * patch_px_per_mm - 0.5, kPatchSize_px,
                            kPatchSize_px);
          for (std::size_t c = 0; c < 3; ++c) {
            const double seen = depolarized * at.At(patch[c]) + scene_.bench.polarizer_leak * light.white[c];
            sum[c] += static_cast<float>(light_left * seen);
          }
        } else {
          const Bilinear at((p.x - 0.5 * w + 0.5 * kTapeTileSide_mm) * tape_px_per_mm,
                            (p.y - 0.5 * w + 0.5 * kTapeTileSide_mm) * tape_px_per_mm, kTapeTileSize_px,
                            kTapeTileSize_px);
          const float tape = static_cast<float>(light_left) * at.At(tape_);
          for (std::size_t c = 0; c < 3; ++c) sum[c] += tape * static_cast<float>(light.white[c]);
        }
      }
      for (std::size_t c = 0; c < 3; ++c) content[c](x, y) = sum[c] / (kSubsamples * kSubsamples);
    }
  });
}

void OpticalBench::DrawGrayCard(const BandLight& light, std::array<PlaneF, 3>& content) const {
  const int width = content[0].width(), height = content[0].height();
  const auto& region = rig_.gray_card_region;
  const double left = region[0] * width - 0.5 - kCardMargin_px,
               right = (region[0] + region[2]) * width - 0.5 + kCardMargin_px;
  const double top = region[1] * height - 0.5 - kCardMargin_px,
               bottom = (region[1] + region[3]) * height - 0.5 + kCardMargin_px;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double share = Overlap(x, left, right) * Overlap(y, top, bottom);
      if (share == 0.0) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        const double card = rig_.gray_card_reflectance * light.white[c];
        content[c](x, y) = static_cast<float>((1.0 - share) * content[c](x, y) + share * card);
      }
    }
  }
}

std::array<PlaneF, 3> OpticalBench::Content(const Shot& shot, const BandLight& light) const {
  std::array<PlaneF, 3> content;
  for (std::size_t c = 0; c < 3; ++c) {
    content[c] =
        PlaneF(scene_.bench.width_px, scene_.bench.height_px,
               static_cast<float>(light.spectralon[c] *
                                  (1.0 + scene_.bench.polarizer_sign * scene_.bench.polarizer_spectralon)));
  }
  if (shot.target == FrameRole::kSkin) DrawSkin(shot, light, content);
  DrawGrayCard(light, content);
  for (PlaneF& plane : content) Blur(plane, scene_.bench.psf_sigma_px);
  return content;
}

PlaneF OpticalBench::ExpectedElectrons(const Shot& shot) const {
  PlaneF electrons(scene_.bench.width_px, scene_.bench.height_px);
  const WheelSlot& slot = SlotOf(shot);
  const double flash = FlashFactor(shot.number);
  if (slot.opaque || flash == 0.0) return electrons;
  const auto content = Content(shot, LightOfBand(slot));
  const BenchConfig::Filters filters = scene_.bench.filters;
  for (int y = 0; y < electrons.height(); ++y) {
    for (int x = 0; x < electrons.width(); ++x) {
      const float here = content[static_cast<std::size_t>(ChannelOf(filters, x, y))](x, y);
      electrons(x, y) = static_cast<float>(flash) * shading_(x, y) * here;
    }
  }
  if (scene_.bench.stray_light > 0.0) AddStrayLight(filters, scene_.bench.stray_light, electrons);
  return electrons;
}

Plane<std::uint16_t> OpticalBench::Expose(const Shot& shot) const {
  auto random = RandomStream(scene_.seed, "noise", static_cast<std::uint64_t>(shot.number));
  return sensor_.Read(ExpectedElectrons(shot), shot.exposure_ms, shot.iso, std::move(random));
}

}  // namespace dermap
