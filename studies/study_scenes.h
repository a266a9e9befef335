// SPDX-License-Identifier: Apache-2.0
// Scenes of skin with known truth that the studies share: the shipped ones, patches with one feature each,
// and a scene whose light a Monte Carlo made.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/files/stack.h"
#include "common/tissue/tissue.h"
#include "common/transport/forward_model.h"

namespace dermap {

inline constexpr double kStudyPatch_mm = 7.5;

// The eight lines of config/rigs/simulated_8lines.toml, monochromatic.
std::vector<Band> StudyBands();

// Patches of 7.5 mm at any size in pixels; `junction_absorbance` is filled where the scene has a tattoo.
//   "light", "medium", "dark"      freckles on C_m 0.025, 0.06 and 0.3
//   "vein", "step", "tattoo"       a line of blood; C_m 0.05 | 0.3; a line of ink of P 0.6
//   "light_freckles", "medium_vein", "monte_carlo_skin"   the shipped ones, from config/scenes
// Throws InputError for any other name.
ParameterMaps StudySkin(const std::string& name, int size);

// One round freckle field whose edges rise (10 to 90 %) over `edge_mm` on skin of the melanin `base`,
// `contrast` times as much inside.
ParameterMaps FreckledSkin(int size, double base, double contrast, double edge_mm);

// The profile of an edge: 1 inside, 0 outside; an error function that rises from 10 to 90 % over `edge_mm`.
double Rise(double inside_mm, double edge_mm);

// What a Monte Carlo says of monte_carlo_skin, in cells of 0.23 mm, with its standard error as sigma.
ReflectanceStack MonteCarloStack();

// Planes as a stack with Gaussian noise of `relative` of the reflectance; sigma states it.
ReflectanceStack NoisyStack(const ForwardModel& model, const std::vector<PlaneF>& reflectance,
                            double relative, std::uint64_t seed);

// Area averages of maps and planes whose size is a multiple of `size`.
PlaneF AverageTo(const PlaneF& plane, int size);
ParameterMaps AverageTo(const ParameterMaps& maps, int size);

}  // namespace dermap
