// SPDX-License-Identifier: Apache-2.0
// A frame that cannot be what the session says it is: named, with a picture of what was found.
#pragma once

#include <string>

#include "common/core/error.h"
#include "common/core/image.h"
#include "common/files/picture.h"

namespace dermap {

class CaptureFailure : public InputError {
 public:
  CaptureFailure(const std::string& message, Plane<Rgb8> picture)
      : InputError(message), picture_(std::move(picture)) {}
  const Plane<Rgb8>& picture() const noexcept { return picture_; }

 private:
  Plane<Rgb8> picture_;
};

}  // namespace dermap
