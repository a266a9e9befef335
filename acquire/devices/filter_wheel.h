// SPDX-License-Identifier: Apache-2.0
// A filter wheel. Slots count from 1, as on the wheel's face.
#pragma once

#include <string>

namespace dermap {

class FilterWheel {
 public:
  virtual ~FilterWheel() = default;
  virtual std::string Name() const = 0;
  virtual int SlotCount() const = 0;
  virtual void MoveTo(int slot) = 0;  // returns once settled; throws DeviceError
};

}  // namespace dermap
