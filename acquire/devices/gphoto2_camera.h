// SPDX-License-Identifier: Apache-2.0
// The driver "gphoto2": any camera of libgphoto2's that can be triggered, foremost Canon's EOS PTP extension
// over USB and PTP/IP. libgphoto2 runs in a child process (gphoto2_worker.cpp), which is killed and started
// anew when it hangs.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "acquire/devices/camera.h"
#include "acquire/devices/device_fault.h"

namespace dermap {

class CameraHelper;

// How long to wait, and how often to try, before a fault counts; tests shorten them.
struct CameraPatience {
  std::chrono::milliseconds plug_in{30000};  // how long it may be off the bus
  std::chrono::milliseconds answer{5000};    // to one request of the protocol
  std::chrono::milliseconds call{30000};     // beyond it the helper process counts as hanging
  std::chrono::milliseconds file{20000};     // from the closed shutter to the file on the card
  std::chrono::milliseconds quiet{2000};     // to let a late file arrive before the next shot
  std::chrono::milliseconds shutter{
      150};  // from the trigger's answer to the closed shutter, beside the exposure
  std::chrono::milliseconds first_pause{200};  // doubles with every retry
  int attempts = 6;
};

struct CameraChoice {
  std::string port = "usb:";  // or "usb:BUS,ADDRESS", "ptpip:ADDRESS:PORT:PORT"
  std::string model;          // libgphoto2's name; empty: the first camera found
};

class Gphoto2Camera : public Camera {
 public:
  Gphoto2Camera(CameraChoice choice, const CameraPatience& patience = {});
  ~Gphoto2Camera() override;

  std::string Name() const override { return name_; }
  void Connect() override;
  std::uintmax_t FrameBytes() const override { return frame_bytes_; }
  void Reconnect() override;
  void Check(const CaptureSettings& settings) override;
  std::optional<int> RoomForFrames() override;
  void MakeReady(const CaptureSettings& settings) override { Check(settings); }
  std::chrono::steady_clock::time_point Expose(const CaptureSettings& settings) override;
  RawFrame Fetch() override;

  int helper_pid() const;  // for tests, which kill it
  // Told of every fault that was overcome.
  std::function<void(const DeviceFault&)> on_retry;

 private:
  void Open();
  void CloseConnection();
  void Set(const CaptureSettings& settings);
  std::chrono::steady_clock::time_point ExposeOnce(const CaptureSettings& settings);
  RawFrame FetchOnce();
  void FindFile();
  bool IsOfAnEarlierShot(const std::string& folder, const std::string& file) const;
  // Runs `step` until it succeeds, with a new connection where that helps.
  void Insist(const std::string& doing, const std::function<void()>& step);
  void Recover(const DeviceFault& fault, int attempt);

  CameraChoice choice_;
  CameraPatience patience_;
  std::unique_ptr<CameraHelper> helper_;
  std::string name_ = "camera";
  std::uintmax_t frame_bytes_ = 30'000'000;
  bool open_ = false;
  std::optional<CaptureSettings> set_;   // of this connection
  int files_owed_ = 0;                   // of shots that were pressed; one that was given up may come later
  std::string last_folder_, last_file_;  // of the last frame that was fetched: cameras count upwards
  std::string folder_, file_;            // where the last frame lies on the card, once known
};

struct AttachedCamera {
  std::string model, port, driver;
};
// What libgphoto2 finds.
std::vector<AttachedCamera> ListCameras();

}  // namespace dermap
