// SPDX-License-Identifier: Apache-2.0
// How the sensor answers to light, from the session's own Spectralon frames. A narrow filter shows one
// wavelength to all colours of photosites, to each at a level of its own: panel over gray card is one number
// whatever the level, as far as signals are proportional to light. How it follows the level is the
// nonlinearity. Also where values stop, whatever the file states.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibrate/frames.h"
#include "calibrate/gray_card.h"

namespace dermap {

// What one kind of photosite shows of panel and card in one frame: sums over the same cells of all kinds.
struct LinearityPoint {
  int frame = 0;              // points of one frame share their ratio of panel to card
  double panel = 0.0;         // mean signal, DN
  double panel_square = 0.0;  // mean of its square, DN^2
  double card = 0.0;
  double card_square = 0.0;
  double variance = 0.0;  // of ln(panel / card)
};

struct LinearityEstimate {
  Known nonlinearity;  // light = signal (1 + nonlinearity signal / full scale)
  int points = 0;
  double chi2 = 0.0;  // per degree of freedom: beyond 1 it widens sigma
};

// The kinds of photosites of one Spectralon frame that are lit and not saturated; empty where the filters
// repeat after more than two photosites, so that a kind holds several colours.
std::vector<LinearityPoint> LinearityPointsOf(const SignalFrame& spectralon, const PixelRegion& card,
                                              int frame);

// nullopt where levels differ too little to tell (a sensor without filters).
std::optional<LinearityEstimate> FitNonlinearity(const std::vector<LinearityPoint>& points,
                                                 double full_scale);

// What signals are put right by, and where that is from.
struct Linearity {
  std::optional<Known> used;
  std::optional<LinearityEstimate> measured;
  std::string note;     // for the step's record
  std::string warning;  // where the rig's number and the frames disagree; else empty
};

// From the first Spectralon frame of every band. What the rig states is used as it is, and compared; where it
// states nothing the frames' own answer is used, drawn towards none as far as they leave it open: sensors are
// expected to be proportional to light within 1 %.
Linearity FindLinearity(const Session& session, const FrameReader& read, const BlackFrames& blacks,
                        const PixelRegion& card);

}  // namespace dermap
