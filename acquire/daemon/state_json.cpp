// SPDX-License-Identifier: Apache-2.0
// Key by key.
#include "acquire/daemon/state_json.h"

#include <nlohmann/json.hpp>

namespace dermap {

using nlohmann::json;

json PlannedFrameToJson(const FrameRecord& f) {
  return {{"number", f.number},
          {"role", RoleName(f.role)},
          {"slot", f.slot},
          {"wavelength_nm", f.wavelength_nm},
          {"exposure_ms", f.exposure_ms},
          {"iso", f.iso}};
}

json ScheduleToJson(const std::vector<FrameRecord>& schedule) {
  json list = json::array();
  for (const FrameRecord& f : schedule) list.push_back(PlannedFrameToJson(f));
  return list;
}

json TakenFrameToJson(const FrameEvent& event, const FrameView& view, std::uint64_t version) {
  json f = PlannedFrameToJson(event.frame);
  f["saturated_share"] = event.check.saturated_share;
  f["level"] = event.check.level;
  f["drift"] = event.drift;
  f["histogram"] = event.check.histogram;
  f["sharpness"] = view.sharpness;
  f["window_found"] = view.window_found;
  f["warning"] = event.warning;
  f["version"] = version;
  return f;
}

json RequestToJson(const OperatorRequest& request) {
  constexpr const char* kKinds[]{"place", "turn", "fault"};
  return {{"kind", kKinds[static_cast<int>(request.kind)]},
          {"role", RoleName(request.role)},
          {"slot", request.slot},
          {"sentence", request.sentence}};
}

}  // namespace dermap
