// SPDX-License-Identifier: Apache-2.0
// Setting a camera by libgphoto2, and a failure of libgphoto2's.
#pragma once

#include <string>

struct _Camera;  // libgphoto2's, whose headers stay out of ours
struct _GPContext;

namespace dermap {

struct Gphoto2Failure {
  int code;
  std::string what;
};
// Throws Gphoto2Failure for a result below 0.
void RequireOk(int result, const std::string& doing);

class Gphoto2Settings {
 public:
  Gphoto2Settings(_Camera* camera, _GPContext* context) : camera_(camera), context_(context) {}
  // Each throws Gphoto2Failure; where the camera does not take the value, with code -1000.
  void SetTo(const char* name, const std::string& value);
  void SetExposure(double exposure_ms);  // the nearest of the camera's, within a sixth of a stop
  void ChooseRaw();  // alone: a JPEG beside it costs time and could be taken for the frame
  int Room();        // how many frames the card takes; -1 where the camera does not tell

 private:
  _Camera* camera_;
  _GPContext* context_;
};

}  // namespace dermap
