// SPDX-License-Identifier: Apache-2.0
// A wheel that is one slot off stays so until it is homed. Between the opaque slot and Spectralon nothing
// tells, until a filter's frame is dark because the opaque slot is in its place.
#include "acquire/frame_doubts.h"

#include <utility>

namespace dermap {

int FrameDoubts::CountRejection(int number) {
  Tries& tries = tries_[number];
  tries.exposed_before_homing = false;
  return ++tries.rejected;
}

void FrameDoubts::TryAnew(int number) {
  Tries& tries = tries_[number];
  tries.exposed_before_homing = false;
  tries.rejected = 0;
}

bool FrameDoubts::IsLastTry(int number) const {
  const auto tries = tries_.find(number);
  return tries != tries_.end() && tries->second.rejected == kFrameTries - 1;
}

bool FrameDoubts::LooksUnderexposedAgain(int number) {
  return std::exchange(tries_[number].looked_underexposed, true);
}

bool FrameDoubts::IsOfAnotherSlot(int number, LightProblem light) {
  if (light == LightProblem::kOtherSlot || light == LightProblem::kNotBlack) return true;
  // Dark once is a flash that did not fire; dark twice may be the opaque slot.
  return light == LightProblem::kDark && std::exchange(tries_[number].looked_dark, true);
}

void FrameDoubts::NoteHoming(int number, bool finds_slots, int under_way) {
  tries_[number].homed = finds_slots;
  if (under_way != 0) tries_[under_way].exposed_before_homing = true;
  in_doubt_.insert(in_doubt_.end(), since_home_.begin(), since_home_.end());
  since_home_.clear();
}

void FrameDoubts::StartOver(int number, bool wheel_was_seen_to) {
  for (auto& [other, tries] : tries_) tries.rejected = 0;
  if (!wheel_was_seen_to) return;
  tries_[number].homed = tries_[number].seen_to = true;
}

bool FrameDoubts::WheelIsRight(int number) const {
  const auto tries = tries_.find(number);
  return tries != tries_.end() && tries->second.homed;
}

bool FrameDoubts::WasSeenTo(int number) const {
  const auto tries = tries_.find(number);
  return tries != tries_.end() && tries->second.seen_to;
}

std::vector<int> FrameDoubts::Vouch(const FrameRecord& kept) {
  const Tries tries = std::exchange(tries_[kept.number], {});
  tries_.erase(kept.number);
  if (kept.role != FrameRole::kSpectralon) return {};
  (tries.exposed_before_homing ? in_doubt_ : since_home_).push_back(kept.number);
  if (!tries.homed) return {};
  std::vector<int> of_another_filter = std::exchange(in_doubt_, {});
  // Spectralon that was dark until the wheel was homed: it stood one slot off, for nobody knows how long.
  if (!tries.looked_dark) of_another_filter.clear();
  return of_another_filter;
}

}  // namespace dermap
