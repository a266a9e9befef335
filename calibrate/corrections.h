// SPDX-License-Identifier: Apache-2.0
// The steps from sensor values to reflectance, by name: each can be left out, and each tells what it did to a
// band's reflectance and how well it is known.
#pragma once

#include <array>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/files/rig_optics.h"

namespace dermap {

enum class Step {
  kBlack,
  kHotPhotosites,
  kLinearity,
  kStrayLight,
  kFlashDrift,
  kCertificate,
  kPolarization,
  kLeak,
  kGel,
  kEffectiveWavelength,
  kAlignment,
};
inline constexpr std::array<std::string_view, 11> kStepNames{
    "black",        "hot-photosites", "linearity", "stray-light",          "flash-drift", "certificate",
    "polarization", "leak",           "gel",       "effective-wavelength", "alignment"};
inline std::string_view NameOf(Step step) {
  return kStepNames[static_cast<std::size_t>(step)];
}
std::optional<Step> StepFromName(std::string_view name);
std::string AllStepNames();  // "black, hot-photosites, ..."

struct StepRecord {
  Step step = Step::kBlack;
  bool applied = false;
  double effect = 0.0;  // relative change of the band's reflectance by this step
  double sigma = 0.0;   // one standard deviation that the step leaves, relative, common to all pixels
  std::string note;     // why not applied, or what was found
};

using StepSet = std::set<Step>;

// R = R_spectralon (S_skin / S_spectralon) (1 -+ a_spectralon) / (1 -+ a_skin) [D08 6.4]: the last factor.
// Signals of both targets were taken at one position of the camera's polarizer, where each is (1 + sign a)
// times its mean.
Known PolarizationFactor(const PolarizationConfig& config, double wavelength_nm);

// Spectralon's signal relative to its mean of both positions.
double SpectralonSignal(const PolarizationConfig& config, double wavelength_nm);

// What a leak of 1 adds to the reflectance, where the polarization step was done or left out. The leak is a
// signal, as a share of what a perfect white diffuser's mean signal is: the factor above, which is for light
// that skin has scattered, is not its own.
double LeakInReflectance(const PolarizationConfig& config, double wavelength_nm, bool polarization_done);

// What the measured reflectance is multiplied by to become that of bare skin in air, which the model means:
// gel between air and skin lets more light in and out, and returns less of what comes from below. Faces let
// through what Fresnel's formulas say at the rig's own angles, s and p alike: the polarization step has made
// the signal the mean of both positions. `reflectance`: the band's, for the light that goes back and forth.
// A fifth of that last share is counted as uncertainty, as is what n leaves open.
struct RigAngles {
  double light_deg = 0.0;  // in air, from the skin's normal, both
  double view_deg = 30.0;
};
Known GelFactor(const Known& n_gel, double n_skin, const RigAngles& angles, double reflectance);

// What a rig's angles make of the reflectance factor of bare skin, against that of 0/30, which the stack
// states and the model means: quotient of the faces' transmittances. The same with light and camera
// exchanged.
double AnglesFactor(const RigAngles& angles, double n_skin);

// Reflectance of skin's face from within for diffuse light, with a film of n_film under air.
double DiffuseReflectanceUnderFilm(double n_skin, double n_film);

}  // namespace dermap
