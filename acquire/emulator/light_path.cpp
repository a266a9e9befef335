// SPDX-License-Identifier: Apache-2.0
// Which slot of the rig the light passes.
#include "acquire/emulator/light_path.h"

#include "acquire/simulated/dng_writer.h"
#include "acquire/simulated/scene.h"
#include "acquire/simulated/simulated_station.h"
#include "common/core/error.h"

namespace dermap::emulator {
namespace {

constexpr double kReadyLampShare = 0.9;  // of the time to full charge

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

LightPath::LightPath(const RigConfig& rig, const WheelMotion& wheel, double flash_recycle_s,
                     const ProgressFunction& progress)
    : wheel_(wheel),
      bench_(WithOpaqueSlot(rig), ReadScene(rig.simulated_scene, rig.window_mm), progress),
      flash_recycle_s_(flash_recycle_s) {}

bool LightPath::FlashFires() {
  const auto now = Clock::now();
  if (now < flash_ready_) return false;
  flash_ready_ = now + std::chrono::duration_cast<Clock::duration>(
                           std::chrono::duration<double>(kReadyLampShare * flash_recycle_s_));
  return true;
}

std::function<Bytes()> LightPath::Expose(double exposure_ms, int iso) {
  const int in_the_light = wheel_.InTheLight();
  const bool lit = FlashFires() && in_the_light != 0 && FindSlot(bench_.rig(), in_the_light) != nullptr;
  const int slot = lit ? in_the_light : FindOpaqueSlot(bench_.rig())->slot;
  return [this, shot = Shot{target, slot, exposure_ms, iso, ++shots_}] {
    const std::vector<std::byte> file = EncodeDng(bench_.Expose(shot), MetadataOfShot(bench_, shot));
    const auto* begin = reinterpret_cast<const std::uint8_t*>(file.data());
    return Bytes(begin, begin + file.size());
  };
}

}  // namespace dermap::emulator
