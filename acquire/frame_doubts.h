// SPDX-License-Identifier: Apache-2.0
// What frames that are still to be taken have been rejected for, and which of those that are there a wheel
// that has lost its slots puts in doubt.
#pragma once

#include <map>
#include <vector>

#include "acquire/light_memory.h"
#include "common/files/session.h"

namespace dermap {

inline constexpr int kFrameTries = 3;  // to get a good frame

class FrameDoubts {
 public:
  int CountRejection(int number);  // how many there are now
  bool IsLastTry(int number) const;
  // Whether it looked underexposed before; notes that it does.
  bool LooksUnderexposedAgain(int number);
  // Its exposure was changed.
  void TryAnew(int number);
  // Notes how a frame that is rejected looks; true where the wheel may stand at another slot than it says.
  bool IsOfAnotherSlot(int number, LightProblem light);
  // The wheel was homed for it; `finds_slots`: and knows its slots again for sure. `under_way`: another frame
  // that was exposed before and is not settled yet, or 0.
  void NoteHoming(int number, bool finds_slots, int under_way);
  // The operator has seen to what was wrong with this frame; perhaps to the wheel, which knows its slots
  // again.
  void StartOver(int number, bool wheel_was_seen_to);
  bool WheelIsRight(int number) const;  // the wheel has found its slots since the frame was first rejected
  bool WasSeenTo(int number) const;     // by the operator
  // A frame is good. Returns the numbers of frames that it shows to be of another filter.
  std::vector<int> Vouch(const FrameRecord& kept);

 private:
  struct Tries {
    int rejected = 0;
    bool looked_underexposed = false;
    bool looked_dark = false;
    bool homed = false;
    bool seen_to = false;
    bool exposed_before_homing = false;
  };
  std::map<int, Tries> tries_;  // by number
  // Numbers of Spectralon frames taken since the wheel was last homed, and of those before, while in doubt.
  std::vector<int> since_home_, in_doubt_;
};

}  // namespace dermap
