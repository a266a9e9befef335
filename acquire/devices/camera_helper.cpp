// SPDX-License-Identifier: Apache-2.0
// Which of libgphoto2's results is which fault; their numbers are libgphoto2's.
#include "acquire/devices/camera_helper.h"

#include <cctype>
#include <nlohmann/json.hpp>

#include "acquire/devices/device_fault.h"
#include "acquire/devices/private_home.h"
#include "acquire/devices/worker_process.h"

namespace dermap {
namespace {

using nlohmann::json;

enum GphotoResult {
  kCameraBusy = -110,
  kNoSpace = -115,
  kModelNotFound = -105,
  kNoMemory = -3,
  kClaim = -53,
  kFind = -52,
  kUnknownPort = -5,
  kOurSettings = -1000
};

FaultKind KindOf(int code) {
  switch (code) {
    case kCameraBusy:
      return FaultKind::kBusy;
    case kNoSpace:
    case kNoMemory:
      return FaultKind::kFull;
    case kClaim:
      return FaultKind::kInUse;
    case kFind:
    case kModelNotFound:
    case kUnknownPort:
      return FaultKind::kGone;
    case kOurSettings:
      return FaultKind::kSettings;
    default:
      return FaultKind::kNoAnswer;
  }
}

std::string RemedyFor(FaultKind kind) {
  switch (kind) {
    case FaultKind::kBusy:
      return "wait until its lamp is off; switch off mirror lock-up and live view";
    case FaultKind::kFull:
      return "put an empty card into it";
    case FaultKind::kInUse:
      return "end the program that holds it ('dermap devices' names it)";
    case FaultKind::kGone:
      return "switch it on, check its cable and its battery, and switch off its sleep";
    case FaultKind::kSettings:
      return "turn its dial to M, or correct the plan";
    default:
      return "switch it off and on";
  }
}

json Parsed(const std::string& line) {
  json object = json::parse(line, nullptr, false);
  return object.is_object() ? object : json::object();
}

}  // namespace

// Of another type than expected counts as missing: the helper may talk nonsense.
std::string CameraAnswer::Text(const char* key) const {
  const json object = Parsed(line);
  return object.contains(key) && object[key].is_string() ? object[key].get<std::string>() : "";
}

int CameraAnswer::Number(const char* key, int otherwise) const {
  const json object = Parsed(line);
  return object.contains(key) && object[key].is_number_integer() ? object[key].get<int>() : otherwise;
}

bool CameraAnswer::Says(const char* key) const {
  const json object = Parsed(line);
  return object.contains(key) && object[key] == true;
}

std::string FrameExtension(const std::string& name) {
  constexpr std::size_t kMostLetters = 4;
  const auto dot = name.rfind('.');
  if (dot == std::string::npos || dot + 1 == name.size() || name.size() - dot - 1 > kMostLetters)
    return ".raw";
  std::string extension = ".";
  for (const unsigned char c : name.substr(dot + 1)) {
    if (c > 127 || std::isalnum(c) == 0) return ".raw";
    extension += static_cast<char>(std::tolower(c));
  }
  return extension;
}

struct CameraHelper::Impl {
  PrivateHome home;
  WorkerProcess process{FindHelperProgram("dermap-camera"), home.path()};
};

CameraHelper::CameraHelper() : impl_(std::make_unique<Impl>()) {}
CameraHelper::~CameraHelper() = default;

CameraAnswer CameraHelper::Tell(const json& request, std::chrono::milliseconds limit) {
  WorkerAnswer answer = impl_->process.Ask(request.dump(), limit);
  return {std::move(answer.line), std::move(answer.bytes)};
}

CameraAnswer CameraHelper::Ask(const json& request, std::chrono::milliseconds limit,
                               const std::string& name) {
  CameraAnswer answer = Tell(request, limit);
  if (answer.Says("ok")) return answer;
  const FaultKind kind = KindOf(answer.Number("code", 0));
  const std::string what = answer.Text("what");
  throw DeviceFault(kind, name + ": " + (what.empty() ? "unknown" : what) + "; remedy: " + RemedyFor(kind));
}

void CameraHelper::Kill() noexcept {
  impl_->process.Kill();
}

bool CameraHelper::running() const {
  return impl_->process.running();
}

int CameraHelper::pid() const {
  return impl_->process.pid();
}

}  // namespace dermap
