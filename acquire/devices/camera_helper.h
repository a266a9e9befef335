// SPDX-License-Identifier: Apache-2.0
// The process that libgphoto2 runs in (gphoto2_worker.cpp), with a HOME of its own, and what its answers
// mean.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace dermap {

struct CameraAnswer {
  std::string line;  // a JSON object
  std::vector<std::byte> bytes;
  std::string Text(const char* key) const;  // empty where it has none
  int Number(const char* key, int otherwise) const;
  bool Says(const char* key) const;
};

// What the frame's file is called by in the session, of the camera's name for it: ".cr2" for IMG_0001.CR2;
// ".raw" where the name ends in none of one to four ASCII letters and digits.
std::string FrameExtension(const std::string& name);

class CameraHelper {
 public:
  CameraHelper();
  ~CameraHelper();  // kills it
  CameraHelper(const CameraHelper&) = delete;
  CameraHelper& operator=(const CameraHelper&) = delete;

  // Throws DeviceFault where it says that something failed (`name`: of the camera), hangs or dies.
  CameraAnswer Ask(const nlohmann::json& request, std::chrono::milliseconds limit, const std::string& name);
  // The same, whatever it says.
  CameraAnswer Tell(const nlohmann::json& request, std::chrono::milliseconds limit);
  void Kill() noexcept;
  bool running() const;
  int pid() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dermap
