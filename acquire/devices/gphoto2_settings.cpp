// SPDX-License-Identifier: Apache-2.0
// Widgets, one at a time: read, set, and read again, since a camera may keep what it had.
#include "acquire/devices/gphoto2_settings.h"

#include <gphoto2/gphoto2.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <optional>

namespace dermap {
namespace {

constexpr int kSettingsFault = -1000;   // of ours: the camera cannot be set so
constexpr double kNearestRatio = 1.13;  // of exposure times: a sixth of a stop

using WidgetOwner = std::unique_ptr<CameraWidget, int (*)(CameraWidget*)>;

WidgetOwner WidgetOf(Camera* camera, GPContext* context, const char* name) {
  CameraWidget* widget = nullptr;
  RequireOk(gp_camera_get_single_config(camera, name, &widget, context), std::string("ask for ") + name);
  return {widget, gp_widget_free};
}

std::string ValueOf(const WidgetOwner& widget) {
  const char* value = nullptr;
  RequireOk(gp_widget_get_value(widget.get(), &value), "read a setting");
  return value == nullptr ? "" : value;
}

[[noreturn]] void Refuse(const std::string& name, const std::string& asked, const std::string& now) {
  throw Gphoto2Failure{kSettingsFault, name + " cannot be set to " + asked + ", it stays at " + now};
}

// Milliseconds of "1/100", "0.3" or "30"; nothing for "bulb" and "auto".
std::optional<double> Milliseconds(const std::string& choice) {
  if (choice.empty() || choice[0] < '0' || choice[0] > '9') return std::nullopt;
  const double upper = std::atof(choice.c_str());
  const auto slash = choice.find('/');
  const double lower = slash == std::string::npos ? 1.0 : std::atof(choice.c_str() + slash + 1);
  if (upper <= 0.0 || lower <= 0.0) return std::nullopt;
  return 1000.0 * upper / lower;
}

}  // namespace

void RequireOk(int result, const std::string& doing) {
  if (result < GP_OK) throw Gphoto2Failure{result, doing + ": " + gp_result_as_string(result)};
}

void Gphoto2Settings::SetTo(const char* name, const std::string& value) {
  const WidgetOwner widget = WidgetOf(camera_, context_, name);
  if (ValueOf(widget) == value) return;
  if (gp_widget_set_value(widget.get(), value.c_str()) < GP_OK) Refuse(name, value, ValueOf(widget));
  const int result = gp_camera_set_single_config(camera_, name, widget.get(), context_);
  if (result == GP_ERROR_BAD_PARAMETERS || result == GP_ERROR) Refuse(name, value, ValueOf(widget));
  RequireOk(result, std::string("set ") + name);
  const std::string now = ValueOf(WidgetOf(camera_, context_, name));
  if (now != value) Refuse(name, value, now);
}

void Gphoto2Settings::SetExposure(double exposure_ms) {
  const WidgetOwner widget = WidgetOf(camera_, context_, "shutterspeed");
  std::string best;
  double best_ratio = 1e9;
  for (int i = 0; i < gp_widget_count_choices(widget.get()); ++i) {
    const char* choice = nullptr;
    gp_widget_get_choice(widget.get(), i, &choice);
    const auto ms = Milliseconds(choice == nullptr ? "" : choice);
    if (!ms) continue;
    const double ratio = std::max(*ms / exposure_ms, exposure_ms / *ms);
    if (ratio >= best_ratio) continue;
    best_ratio = ratio;
    best = choice;
  }
  if (best_ratio > kNearestRatio)
    Refuse("shutterspeed", std::to_string(exposure_ms) + " ms", ValueOf(widget));
  SetTo("shutterspeed", best);
}

void Gphoto2Settings::ChooseRaw() {
  const WidgetOwner widget = WidgetOf(camera_, context_, "imageformat");
  if (ValueOf(widget) != "RAW") SetTo("imageformat", "RAW");
}

int Gphoto2Settings::Room() {
  CameraWidget* widget = nullptr;
  if (gp_camera_get_single_config(camera_, "availableshots", &widget, context_) < GP_OK) return -1;
  const std::string value = ValueOf(WidgetOwner(widget, gp_widget_free));
  return value.empty() ? -1 : std::atoi(value.c_str());
}

}  // namespace dermap
