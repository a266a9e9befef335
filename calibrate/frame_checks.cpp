// SPDX-License-Identifier: Apache-2.0
// Limits were set on the simulated bench: what is normal there stays well inside, each failure well outside.
#include "calibrate/frame_checks.h"

#include <algorithm>
#include <cmath>

#include "calibrate/failure.h"
#include "calibrate/frame_picture.h"
#include "calibrate/statistics.h"

namespace dermap {
namespace {

constexpr double kDarkCard = 0.005;       // of full scale: no flash at all
constexpr double kRoomLight = 4.0;        // standard errors of a frame's mean above black: some light came in
constexpr double kDarkAgainst = 0.2;      // of the Spectralon frame's card: the flash did not fire
constexpr double kWeakFlash = 0.7;        // outside of this and its inverse the flash had not recycled
constexpr double kUnevenCard = 0.03;      // of the card's ratio: something shades it
constexpr double kMovedCard = 0.15;       // the same: it moved, or something lies on it
constexpr double kOtherFilter = 0.08;     // of the colours' ratios: another filter
constexpr double kDarkCell = 0.3;         // of the bright ones: tape
constexpr double kTapedShare = 0.1;       // of the middle's cells
constexpr double kMiddle = 0.6;           // of the frame, each way
constexpr double kSaturatedColour = 0.1;  // of a frame's photosites: one colour of four, in half of the frame
constexpr double kSaturatedShare = 0.9;   // of the panel's cells: nothing left to measure with

[[noreturn]] void FlashFailed(const SignalFrame& frame, const PixelRegion& card, const std::string& found) {
  throw CaptureFailure(frame.record.file + ": the flash did not fire (" + found +
                           "); expected a gray card as bright as in the other frames: wait for the flash to "
                           "recycle, check its "
                           "batteries and cable, and capture this frame again",
                       FailurePicture(frame.signal, card));
}

bool InCard(int x, int y, const PixelRegion& card) {
  return x >= card.x - 8 && x < card.x + card.width + 8 && y >= card.y - 8 && y < card.y + card.height + 8;
}

// Signal sums of 2x2 cells in the frame's middle, the card left out.
std::vector<float> MiddleCells(const PlaneF& signal, const PixelRegion& card) {
  std::vector<float> cells;
  const auto first = [](int size) { return static_cast<int>((1.0 - kMiddle) / 2 * size) & ~1; };
  const int step = std::max(2, signal.width() / 400 * 2);
  for (int y = first(signal.height()); y + 1 < signal.height() - first(signal.height()); y += step) {
    for (int x = first(signal.width()); x + 1 < signal.width() - first(signal.width()); x += step) {
      if (InCard(x, y, card)) continue;
      cells.push_back(signal(x, y) + signal(x + 1, y) + signal(x, y + 1) + signal(x + 1, y + 1));
    }
  }
  return cells;
}

}  // namespace

void CheckLit(const SignalFrame& frame, const PixelRegion& card, double full_scale) {
  const double share = GrayCardSignal(frame, card) / full_scale;
  if (share >= kDarkCard) return;
  const RobustScatter all = MedianAndScatter(frame.signal.values());
  const double error = 1.25 * all.sigma / std::sqrt(double(frame.signal.size()));
  const bool room_light = all.median > kRoomLight * error + 0.25;
  FlashFailed(frame, card,
              "the gray card is at " + Short(100 * share) + " % of full scale" +
                  (room_light ? "" : ", and not even the room's light is seen: or the lens cap is on"));
}

bool EvenlyBright(const PlaneF& signal, const PixelRegion& card) {
  std::vector<float> cells = MiddleCells(signal, card);
  if (cells.empty()) return true;
  const auto bright = cells.begin() + static_cast<std::ptrdiff_t>(cells.size() * 9 / 10);
  std::nth_element(cells.begin(), bright, cells.end());
  const float limit = static_cast<float>(kDarkCell) * *bright;
  const auto dark = std::count_if(cells.begin(), cells.end(), [&](float v) { return v < limit; });
  return static_cast<double>(dark) < kTapedShare * static_cast<double>(cells.size());
}

void CheckSpectralon(const SignalFrame& frame, const PixelRegion& card) {
  if (!EvenlyBright(frame.signal, card)) {
    throw CaptureFailure(
        frame.record.file +
            ": this Spectralon frame shows dark tape in its middle, as a skin frame does; expected "
            "an evenly bright panel: were two frames swapped? Restore them or capture this "
            "frame again",
        FailurePicture(frame.signal, card));
  }
  std::size_t saturated = 0;
  std::size_t cells = 0;
  for (int y = frame.mask.height() / 4 & ~1; y < frame.mask.height() * 3 / 4; y += 2) {
    for (int x = frame.mask.width() / 4 & ~1; x < frame.mask.width() * 3 / 4; x += 2) {
      ++cells;
      const bool all = (frame.mask(x, y) & frame.mask(x + 1, y) & frame.mask(x, y + 1) &
                        frame.mask(x + 1, y + 1) & kPhotositeSaturated) != 0;
      if (all) ++saturated;
    }
  }
  const double share = double(saturated) / double(std::max<std::size_t>(1, cells));
  if (share < kSaturatedShare) return;
  throw CaptureFailure(
      frame.record.file + ": the Spectralon is saturated (" + Short(100 * share) +
          " % of the frame's middle, in all colours); expected at most 90 % of full scale: lower the "
          "ISO for this filter and capture its Spectralon and skin frames again",
      FailurePicture(frame.signal, card));
}

std::vector<std::string> CheckCard(const SignalFrame& skin, const SignalFrame& spectralon,
                                   const GrayCardRatio& ratio, double drift, const PixelRegion& card) {
  if (!(ratio.ratio > 0.0)) {
    throw CaptureFailure(skin.record.file +
                             ": the gray card is saturated or dark throughout; expected a card that can be "
                             "read in this frame and in "
                             "the Spectralon frame: lower the ISO for this filter and capture again",
                         FailurePicture(skin.signal, card));
  }
  // A colour that the filter hardly passes is not saturated and goes on telling a ratio.
  if (drift < kDarkAgainst && spectralon.saturated_share > kSaturatedColour) {
    throw CaptureFailure(
        spectralon.record.file + ": the Spectralon is saturated (" + Short(100 * spectralon.saturated_share) +
            " % of the photosites), and its gray card is " + Short(1.0 / drift) + " times as bright as in " +
            skin.record.file +
            "; expected at most 90 % of full scale: lower the ISO for this filter and capture its Spectralon "
            "and skin frames again",
        FailurePicture(spectralon.signal, card));
  }
  if (drift < kDarkAgainst) {
    FlashFailed(skin, card,
                "the gray card has " + Short(100 * drift) + " % of its brightness in the Spectralon frame");
  }
  if (ratio.colour_difference > kOtherFilter) {
    throw CaptureFailure(skin.record.file + ": the gray card's colours differ by " +
                             Short(100 * ratio.colour_difference) + " % from those in " +
                             spectralon.record.file +
                             "; expected both frames through one filter: a filter was out of order, or two "
                             "frames were swapped. "
                             "Restore them or capture this filter again",
                         FailurePicture(skin.signal, card));
  }
  if (ratio.unevenness > kMovedCard) {
    throw CaptureFailure(
        skin.record.file +
            ": the gray card moved, or something covers part of it (its ratio to the Spectralon "
            "frame varies by " +
            Short(100 * ratio.unevenness) +
            " % over the card); expected the same card at the same place in every frame: fix it and capture "
            "this "
            "filter again",
        FailurePicture(skin.signal, card));
  }
  std::vector<std::string> notes;
  if (drift < kWeakFlash || drift > 1.0 / kWeakFlash) {
    notes.push_back(skin.record.file + ": the flash was at " + Short(100 * drift) +
                    " % of that of the Spectralon frame; corrected, but noisier");
  }
  if (ratio.unevenness > kUnevenCard) {
    notes.push_back(skin.record.file + ": the gray card's ratio to the Spectralon frame varies by " +
                    Short(100 * ratio.unevenness) +
                    " % over the card: something shades it, or it moved a little");
  }
  return notes;
}

}  // namespace dermap
