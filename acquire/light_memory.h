// SPDX-License-Identifier: Apache-2.0
// What the frames so far were like: their size, and the light that each slot gave, by the gray card that
// stays in view. A frame whose card does not look as its slot's did was taken through another filter, or by a
// flash that did not fire.
#pragma once

#include <map>
#include <string>

#include "acquire/frame_check.h"
#include "common/files/session.h"

namespace dermap {

enum class LightProblem { kNone, kDark, kBright, kOtherSlot, kNotBlack };

struct LightJudgement {
  LightProblem problem = LightProblem::kNone;
  int looks_like_slot = 0;  // kOtherSlot; 0: like none of those seen
  double drift = 0.0;  // of the card against the slot's first frame: 0.05 is 5 % brighter; 0 where unknown
};

class LightMemory {
 public:
  // `planned` says what the frame should be.
  LightJudgement Judge(const FrameRecord& planned, const FrameCheck& check) const;
  void Learn(const FrameRecord& frame, const FrameCheck& check);
  void LearnFrom(const Session& session);  // from its first frame, and the Spectralon frames that are there
  int SourceOf(int slot) const;  // the number of the frame that taught this slot's light; 0: none has
  const FrameSize& size() const { return size_; }  // of the first frame; 0 x 0: there was none
  void Forget(int slot) { by_slot_.erase(slot); }

 private:
  struct Light {
    CardLevel per_iso{};  // level of each channel at ISO 100
    int frame = 0;
  };
  std::map<int, Light> by_slot_;
  FrameSize size_;
};

// A sentence's end: "was taken through another filter: it looks like slot 3".
std::string DescribeLight(const LightJudgement& judgement);

}  // namespace dermap
