// SPDX-License-Identifier: Apache-2.0
// A station of real devices: a camera, a wheel, and an operator for the rest.
#pragma once

#include <memory>

#include "acquire/devices/operator.h"
#include "acquire/devices/station.h"

namespace dermap {

class DeviceStation : public Station {
 public:
  DeviceStation(std::unique_ptr<Camera> camera, std::unique_ptr<FilterWheel> wheel)
      : camera_(std::move(camera)), wheel_(std::move(wheel)) {}
  Camera& camera() override { return *camera_; }
  FilterWheel& wheel() override { return *wheel_; }
  void Prepare(const ProgressFunction& progress) override;
  bool NeedsOperator() const override { return true; }
  void Place(FrameRole) override {}  // the operator has

 private:
  std::unique_ptr<Camera> camera_;
  std::unique_ptr<FilterWheel> wheel_;
};

}  // namespace dermap
