// SPDX-License-Identifier: Apache-2.0
// A filter wheel. Slots count from 1, as on the wheel's face.
#pragma once

#include <string>

namespace dermap {

class FilterWheel {
 public:
  virtual ~FilterWheel() = default;
  virtual std::string Name() const = 0;
  virtual void Connect() {}  // finds it and brings it to a known slot; throws DeviceError
  virtual void Home() {}     // begins anew with it, where it may have lost its slots; throws DeviceError
  virtual bool HomingFindsSlots() const { return true; }  // else only switching it off and on does
  // Whether it can move while the operator and the camera are busy.
  virtual bool MovesByItself() const { return true; }
  virtual int SlotCount() const = 0;  // once connected
  virtual void MoveTo(int slot) = 0;  // returns once settled; throws DeviceError
};

}  // namespace dermap
