// SPDX-License-Identifier: Apache-2.0
// The flash's energy does not depend on the shutter: a level is judged by ISO alone. The card reflects all
// wavelengths alike, so the shares of red, green and blue tell the filter, whatever lies beside the card.
#include "acquire/light_memory.h"

#include <algorithm>
#include <cmath>

#include "common/files/atomic_file.h"

namespace dermap {
namespace {

constexpr double kBrightBlackLevel = 0.05;        // of the range: light in a black frame
constexpr double kDarkLevel = 0.02;               // below it a lit frame is dark
constexpr double kSaturatedCard = 0.95;           // from here on its colour means nothing
constexpr double kDarker = 0.6, kBrighter = 1.6;  // than the slot's first frame: more than a flash drifts
constexpr double kNearerBy = 0.5;                 // another slot's colour must be nearer by this factor
constexpr double kOtherColour = 0.15;  // from its own colour: no lamp or skin changes a narrow band so

double Sum(const CardLevel& c) {
  return c[0] + c[1] + c[2];
}

bool TellsColour(const CardLevel& card) {
  const double top = *std::max_element(card.begin(), card.end());
  return top > kDarkLevel && top < kSaturatedCard;
}

// Between two colours, each as shares of its sum.
double Distance(const CardLevel& a, const CardLevel& b) {
  double sum = 0.0;
  for (std::size_t c = 0; c < a.size(); ++c) sum += std::pow(a[c] / Sum(a) - b[c] / Sum(b), 2);
  return std::sqrt(sum);
}

CardLevel PerIso(const CardLevel& card, int iso) {
  CardLevel light = card;
  for (double& level : light) level *= 100.0 / iso;
  return light;
}

}  // namespace

LightJudgement LightMemory::Judge(const FrameRecord& planned, const FrameCheck& check) const {
  LightJudgement judgement;
  if (planned.role == FrameRole::kBlack) {
    if (check.level > kBrightBlackLevel) judgement.problem = LightProblem::kNotBlack;
    return judgement;
  }
  if (check.level < kDarkLevel) {
    judgement.problem = LightProblem::kDark;
    return judgement;
  }
  const auto own = by_slot_.find(planned.slot);
  if (own == by_slot_.end() || !TellsColour(check.card)) return judgement;
  const CardLevel light = PerIso(check.card, planned.iso);
  const double own_distance = Distance(light, own->second.per_iso);
  for (const auto& [slot, other] : by_slot_) {
    if (slot == planned.slot || Distance(light, other.per_iso) > kNearerBy * own_distance) continue;
    judgement.problem = LightProblem::kOtherSlot;
    judgement.looks_like_slot = slot;
    return judgement;
  }
  if (own_distance > kOtherColour) {
    judgement.problem = LightProblem::kOtherSlot;
    return judgement;
  }
  const double ratio = Sum(light) / Sum(own->second.per_iso);
  judgement.drift = ratio - 1.0;
  if (ratio < kDarker) judgement.problem = LightProblem::kDark;
  if (ratio > kBrighter) judgement.problem = LightProblem::kBright;
  return judgement;
}

void LightMemory::Learn(const FrameRecord& frame, const FrameCheck& check) {
  if (size_ == FrameSize{}) size_ = check.size;
  if (frame.role == FrameRole::kBlack || !TellsColour(check.card)) return;
  by_slot_.try_emplace(frame.slot, Light{PerIso(check.card, frame.iso), frame.number});
}

void LightMemory::LearnFrom(const Session& session) {
  for (const FrameRecord& f : session.frames) {
    if (f.role != FrameRole::kSpectralon && size_ != FrameSize{}) continue;
    const RawFrame raw{ReadBinaryFile(session.directory / f.file),
                       std::filesystem::path(f.file).extension().string()};
    const FrameCheck check = CheckFrame(raw, session.rig.gray_card_region);
    if (check.decodes) Learn(f, check);
  }
}

int LightMemory::SourceOf(int slot) const {
  const auto found = by_slot_.find(slot);
  return found == by_slot_.end() ? 0 : found->second.frame;
}

std::string DescribeLight(const LightJudgement& judgement) {
  switch (judgement.problem) {
    case LightProblem::kNone:
      return "";
    case LightProblem::kDark:
      return "is dark: the flash did not fire, or the ISO is far too low";
    case LightProblem::kBright:
      return "is far brighter than this filter's first frame";
    case LightProblem::kOtherSlot:
      if (judgement.looks_like_slot == 0)
        return "was taken through another filter: its gray card has not the colour of this one";
      return "was taken through another filter: its gray card looks like slot " +
             std::to_string(judgement.looks_like_slot);
    case LightProblem::kNotBlack:
      return "is not dark: the wheel does not stand at its opaque slot, or light leaks past it";
  }
  return "";
}

}  // namespace dermap
