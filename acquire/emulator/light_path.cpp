// SPDX-License-Identifier: Apache-2.0
// Which slot of the rig the light passes.
#include "acquire/emulator/light_path.h"

#include "acquire/simulated/dng_writer.h"
#include "acquire/simulated/scene.h"
#include "acquire/simulated/simulated_station.h"
#include "common/core/error.h"

namespace dermap::emulator {
namespace {

RigConfig WithOpaqueSlot(RigConfig rig) {
  if (FindOpaqueSlot(rig) == nullptr) {
    throw InputError("rig '" + rig.name +
                     "' has no opaque slot, which the emulated wheel needs; remedy: mark one with "
                     "opaque = true");
  }
  if (rig.simulated_scene.empty()) {
    throw InputError("rig '" + rig.name + "' names no scene; remedy: set scene in its [simulated] table");
  }
  return rig;
}

}  // namespace

LightPath::LightPath(const RigConfig& rig, const WheelMotion& wheel, const ProgressFunction& progress)
    : wheel_(wheel), bench_(WithOpaqueSlot(rig), ReadScene(rig.simulated_scene, rig.window_mm), progress) {}

std::function<Bytes()> LightPath::Expose(double exposure_ms, int iso) {
  const int in_the_light = wheel_.InTheLight();
  const bool lit = in_the_light != 0 && FindSlot(bench_.rig(), in_the_light) != nullptr;
  const int slot = lit ? in_the_light : FindOpaqueSlot(bench_.rig())->slot;
  return [this, shot = Shot{target, slot, exposure_ms, iso, ++shots_}] {
    const std::vector<std::byte> file = EncodeDng(bench_.Expose(shot), MetadataOfShot(bench_, shot));
    const auto* begin = reinterpret_cast<const std::uint8_t*>(file.data());
    return Bytes(begin, begin + file.size());
  };
}

}  // namespace dermap::emulator
