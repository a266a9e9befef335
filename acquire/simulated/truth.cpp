// SPDX-License-Identifier: Apache-2.0
// Writing truth/.
#include "acquire/simulated/truth.h"

#include <nlohmann/json.hpp>

#include "common/files/atomic_file.h"
#include "common/files/maps.h"
#include "common/files/stack.h"

namespace dermap {
namespace {

using Json = nlohmann::ordered_json;

Json DescribeBench(const BenchConfig& c) {
  return {{"width_px", c.width_px},
          {"height_px", c.height_px},
          {"window_center_px", c.window_center_px},
          {"scale_px_per_mm", c.scale_px_per_mm},
          {"camera_distance_mm", c.camera_distance_mm},
          {"psf_sigma_px", c.psf_sigma_px},
          {"white_electrons", c.white_electrons},
          {"vignetting", c.vignetting},
          {"flash_unevenness", c.flash_unevenness},
          {"flash_drift", c.flash_drift},
          {"misfired_shots", c.misfired_shots},
          {"motion_shift_mm", c.motion_shift_mm},
          {"motion_rotation_deg", c.motion_rotation_deg},
          {"tape_reflectance", c.tape_reflectance},
          {"tape_texture", c.tape_texture},
          {"shot_noise", c.shot_noise},
          {"full_well_electrons", c.full_well_electrons},
          {"read_noise_electrons", c.read_noise_electrons},
          {"read_noise_dn", c.read_noise_dn},
          {"black_level_dn", c.black_level_dn},
          {"black_pattern_dn", c.black_pattern_dn},
          {"response_pattern", c.response_pattern},
          {"dark_current_electrons_per_s", c.dark_current_electrons_per_s},
          {"hot_photosites", c.hot_photosites},
          {"dead_photosites", c.dead_photosites}};
}

Json DescribeShot(const OpticalBench& bench, const FrameRecord& frame) {
  const Shot shot{frame.role, frame.slot, frame.exposure_ms, frame.iso, frame.number};
  Json j{{"number", frame.number}, {"role", RoleName(frame.role)}, {"wavelength_nm", frame.wavelength_nm}};
  if (frame.role == FrameRole::kBlack) return j;
  j["flash"] = bench.FlashFactor(frame.number);
  if (frame.role != FrameRole::kSkin) return j;
  const Pose pose = bench.PoseOfShot(shot);
  j["shift_mm"] = {pose.shift_x_mm, pose.shift_y_mm};
  j["rotation_deg"] = pose.rotation_deg;
  Json corners = Json::array();
  for (const Point2& p : bench.CornersOfShot(shot)) corners.push_back({p.x, p.y});
  j["window_corners_px"] = corners;  // the centre of the first photosite is (0, 0)
  return j;
}

MapsFile TruthMaps(const OpticalBench& bench) {
  const ImagingConditions& conditions = bench.patch().conditions;
  MapsFile file;
  file.maps = bench.scene().maps;
  file.bands = bench.patch().bands;
  file.pixel_size_mm = conditions.pixel_size_mm;
  file.illumination = conditions.illumination;
  file.tape = conditions.tape;
  file.geometry = conditions.geometry;
  return file;
}

ReflectanceStack TruthStack(const OpticalBench& bench) {
  const ImagingConditions& conditions = bench.patch().conditions;
  ReflectanceStack stack;
  stack.bands = bench.patch().bands;
  stack.reflectance = bench.patch().Mean();
  stack.pixel_size_mm = conditions.pixel_size_mm;
  stack.illumination = conditions.illumination;
  stack.tape = conditions.tape;
  stack.geometry = conditions.geometry;
  stack.notes["source"] = "simulated truth";
  stack.notes["seed"] = std::to_string(bench.scene().seed);
  return stack;
}

}  // namespace

void WriteTruth(const std::filesystem::path& directory, const OpticalBench& bench,
                std::span<const FrameRecord> schedule) {
  const Scene& scene = bench.scene();
  Json j{{"scene", scene.name}, {"seed", scene.seed}, {"profiles", scene.profiles}};
  j["bench"] = DescribeBench(scene.bench);
  Json shots = Json::array();
  for (const FrameRecord& frame : schedule) shots.push_back(DescribeShot(bench, frame));
  j["shots"] = shots;
  WriteFileAtomically(directory / "bench.json", j.dump(1) + "\n");
  WriteReflectanceStack(directory / "reflectance.exr", TruthStack(bench));
  if (!scene.pattern) WriteMaps(directory / "maps.exr", TruthMaps(bench));
}

}  // namespace dermap
