// SPDX-License-Identifier: Apache-2.0
// Parts of the daemon's state as JSON; their keys stand in docs/daemon.md and in api_schema.json.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "acquire/daemon/frame_view.h"
#include "acquire/sequence.h"

namespace dermap {

nlohmann::json PlannedFrameToJson(const FrameRecord& frame);
nlohmann::json ScheduleToJson(const std::vector<FrameRecord>& schedule);
// `version`: another one is another picture.
nlohmann::json TakenFrameToJson(const FrameEvent& event, const FrameView& view, std::uint64_t version);
nlohmann::json RequestToJson(const OperatorRequest& request);

}  // namespace dermap
