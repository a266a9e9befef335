// SPDX-License-Identifier: Apache-2.0
// The program dermap-camera: libgphoto2 behind a pipe. Requests come as JSON lines on standard input, answers
// go out the same way, a frame's bytes after its line. Whoever started it kills it when it hangs. Its HOME is
// its own, so settings of libgphoto2 (capture target, time limits) are ours alone.
#include <fcntl.h>
#include <gphoto2/gphoto2.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>

#include "acquire/devices/end_with_parent.h"
#include "acquire/devices/gphoto2_settings.h"

namespace dermap {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;
using SteadyClock = std::chrono::steady_clock;

constexpr milliseconds kLastWord{2000};  // to end a call and close the camera once nobody asks any more

class Session {
 public:
  Session() : context_(gp_context_new()) {}
  ~Session() {
    Close();
    gp_context_unref(context_);
  }

  json Open(const json& request) {
    Close();
    const std::string limit = std::to_string(request.value("answer_ms", 5000));
    gp_setting_set(Ptp2(), Text("normal_timeout"), Text(limit));
    gp_setting_set(Ptp2(), Text("capture_timeout"), Text(limit));
    gp_setting_set(Ptp2(), Text("capturetarget"), Text("card"));
    RequireOk(gp_camera_new(&camera_), "new camera");
    Choose(request.value("port", "usb:"), request.value("model", ""));
    RequireOk(gp_camera_init(camera_, context_), "open the camera");
    CameraAbilities abilities{};
    RequireOk(gp_camera_get_abilities(camera_, &abilities), "ask what the camera can");
    // "PTP/IP Camera" does not say what it can: the driver decides.
    can_trigger_ = std::strstr(abilities.library, "ptp2") != nullptr ||
                   (abilities.operations & GP_OPERATION_TRIGGER_CAPTURE) != 0;
    added_.reset();
    return {{"model", abilities.model}, {"driver", abilities.library}, {"old_driver", !can_trigger_}};
  }

  void Close() {
    if (camera_ == nullptr) return;
    gp_camera_exit(camera_, context_);
    gp_camera_free(camera_);
    camera_ = nullptr;
  }

  json Set(const json& request) {
    RequireOpen();
    Gphoto2Settings settings(camera_, context_);
    settings.ChooseRaw();
    settings.SetTo("iso", std::to_string(request.at("iso").get<int>()));
    settings.SetExposure(request.at("exposure_ms").get<double>());
    if (settings.Room() == 0) throw Gphoto2Failure{GP_ERROR_NO_SPACE, "the card is full"};
    return json::object();
  }

  json TellRoom() {
    RequireOpen();
    return {{"room", Gphoto2Settings(camera_, context_).Room()}};
  }

  json Expose(const json& request) {
    RequireOpen();
    Drain(milliseconds(request.value("quiet_ms", 0)));
    if (!can_trigger_) {  // older drivers expose and store in one call
      CameraFilePath path{};
      RequireOk(gp_camera_capture(camera_, GP_CAPTURE_IMAGE, &path, context_), "take a frame");
      added_ = path;
      return json::object();
    }
    RequireOk(gp_camera_trigger_capture(camera_, context_), "press the shutter");
    std::this_thread::sleep_for(milliseconds(request.value("open_ms", 0)));
    return json::object();
  }

  json Fetch(const json& request, std::string& bytes) {
    RequireOpen();
    if (request.contains("name")) {
      CameraFilePath path{};
      std::snprintf(path.folder, sizeof path.folder, "%s", request.at("folder").get<std::string>().c_str());
      std::snprintf(path.name, sizeof path.name, "%s", request.at("name").get<std::string>().c_str());
      added_ = path;
    }
    if (request.value("again", false)) added_.reset();  // the last one was not what was looked for
    if (!added_) return Await(milliseconds(request.value("limit_ms", 20000)));
    CameraFile* file = nullptr;
    RequireOk(gp_file_new(&file), "new file");
    const std::unique_ptr<CameraFile, int (*)(CameraFile*)> owner(file, gp_file_free);
    RequireOk(gp_camera_file_get(camera_, added_->folder, added_->name, GP_FILE_TYPE_NORMAL, file, context_),
              "fetch the frame");
    const char* data = nullptr;
    unsigned long size = 0;
    RequireOk(gp_file_get_data_and_size(file, &data, &size), "read the frame");
    bytes.assign(data, size);
    const std::string name = added_->name;
    added_.reset();
    return {{"name", name}, {"bytes", size}};
  }

  // Models and ports of what is attached.
  json List() {
    CameraList* found = nullptr;
    RequireOk(gp_list_new(&found), "new list");
    const std::unique_ptr<CameraList, int (*)(CameraList*)> owner(found, gp_list_free);
    Detect(found);
    json list = json::array();
    for (int i = 0; i < gp_list_count(found); ++i) {
      const char *model = nullptr, *port = nullptr;
      gp_list_get_name(found, i, &model);
      gp_list_get_value(found, i, &port);
      list.push_back({{"model", model}, {"port", port}, {"driver", DriverOf(model)}});
    }
    return {{"cameras", list}};
  }

 private:
  // libgphoto2 only reads names; its interface lacks the const.
  static char* Text(const std::string& text) { return const_cast<char*>(text.c_str()); }
  static char* Ptp2() {
    static std::string name = "ptp2";
    return name.data();
  }

  void RequireOpen() const {
    if (camera_ == nullptr) throw Gphoto2Failure{GP_ERROR_IO, "the camera is not open"};
  }

  void LoadLists() {
    if (abilities_ != nullptr) return;
    RequireOk(gp_abilities_list_new(&abilities_), "new list of drivers");
    RequireOk(gp_abilities_list_load(abilities_, context_), "load the drivers");
  }
  GPPortInfoList* Ports() {  // anew each time: addresses change with every plug
    if (ports_ != nullptr) gp_port_info_list_free(ports_);
    ports_ = nullptr;
    RequireOk(gp_port_info_list_new(&ports_), "new list of ports");
    RequireOk(gp_port_info_list_load(ports_), "load the ports");
    return ports_;
  }
  void Detect(CameraList* found) {
    LoadLists();
    RequireOk(gp_abilities_list_detect(abilities_, Ports(), found, context_), "look for cameras");
  }
  std::string DriverOf(const char* model) {
    CameraAbilities abilities{};
    const int index = gp_abilities_list_lookup_model(abilities_, model);
    if (index < 0 || gp_abilities_list_get_abilities(abilities_, index, &abilities) < GP_OK) return "";
    return std::strrchr(abilities.library, '/') != nullptr ? std::strrchr(abilities.library, '/') + 1
                                                           : abilities.library;
  }

  void Choose(const std::string& port, const std::string& model) {
    LoadLists();
    std::string chosen_model = model, chosen_port = port;
    if (port == "usb:") {
      const json list = List().at("cameras");
      for (const json& c : list) {
        const std::string at = c.at("port");
        if (at.rfind("usb:", 0) != 0 || (!model.empty() && c.at("model") != model)) continue;
        chosen_model = c.at("model");
        chosen_port = at;
        break;
      }
      if (chosen_port == "usb:") throw Gphoto2Failure{GP_ERROR_MODEL_NOT_FOUND, "no camera on USB"};
    } else if (model.empty()) {
      chosen_model = port.rfind("ptpip:", 0) == 0 ? "PTP/IP Camera" : "USB PTP Class Camera";
    }
    const int index = gp_abilities_list_lookup_model(abilities_, chosen_model.c_str());
    RequireOk(index, "find a driver for '" + chosen_model + "'");
    CameraAbilities abilities{};
    RequireOk(gp_abilities_list_get_abilities(abilities_, index, &abilities), "find a driver");
    RequireOk(gp_camera_set_abilities(camera_, abilities), "choose the driver");
    GPPortInfoList* ports = Ports();
    const int at = gp_port_info_list_lookup_path(ports, chosen_port.c_str());
    RequireOk(at, "find the port " + chosen_port);
    GPPortInfo info = nullptr;
    RequireOk(gp_port_info_list_get_info(ports, at, &info), "find the port");
    RequireOk(gp_camera_set_port_info(camera_, info), "choose the port");
  }

  // What was stored before is not ours: nothing that comes of it may be taken for the next frame.
  void Drain(milliseconds quiet) {
    added_.reset();
    const auto until = SteadyClock::now() + quiet;
    do {
      CameraEventType kind = GP_EVENT_UNKNOWN;
      void* data = nullptr;
      const auto left = std::chrono::duration_cast<milliseconds>(until - SteadyClock::now());
      RequireOk(gp_camera_wait_for_event(camera_, static_cast<int>(std::max<long>(1, left.count())), &kind,
                                         &data, context_),
                "empty the camera's queue");
      std::free(data);
      if (kind == GP_EVENT_TIMEOUT) return;
    } while (true);
  }

  // Waits for the file of the last exposure; answers with its place before it is fetched, so that it can be
  // fetched by another worker should this one be lost over it.
  json Await(milliseconds limit) {
    const auto until = SteadyClock::now() + limit;
    while (SteadyClock::now() < until) {
      CameraEventType kind = GP_EVENT_UNKNOWN;
      void* data = nullptr;
      const auto left = std::chrono::duration_cast<milliseconds>(until - SteadyClock::now());
      RequireOk(gp_camera_wait_for_event(camera_, static_cast<int>(std::max<long>(1, left.count())), &kind,
                                         &data, context_),
                "wait for the frame");
      const std::unique_ptr<void, void (*)(void*)> owner(data, std::free);
      if (kind != GP_EVENT_FILE_ADDED) continue;
      added_ = *static_cast<CameraFilePath*>(data);
      return {{"folder", added_->folder}, {"name", added_->name}, {"added", true}};
    }
    throw Gphoto2Failure{GP_ERROR_TIMEOUT, "the camera has stored no frame"};
  }

  GPContext* context_;
  Camera* camera_ = nullptr;
  CameraAbilitiesList* abilities_ = nullptr;
  GPPortInfoList* ports_ = nullptr;
  bool can_trigger_ = false;
  std::optional<CameraFilePath> added_;  // the frame that is to be fetched
};

json Obey(Session& session, const json& request, std::string& bytes) {
  const std::string what = request.value("do", "");
  if (what == "open") return session.Open(request);
  if (what == "set") return session.Set(request);
  if (what == "expose") return session.Expose(request);
  if (what == "fetch") return session.Fetch(request, bytes);
  if (what == "room") return session.TellRoom();
  if (what == "list") return session.List();
  if (what == "close") {
    session.Close();
    return json::object();
  }
  throw Gphoto2Failure{GP_ERROR_BAD_PARAMETERS, "unknown request '" + what + "'"};
}

bool WriteAll(int file, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t size = ::write(file, text.data() + done, text.size() - done);
    if (size <= 0) return false;
    done += static_cast<std::size_t>(size);
  }
  return true;
}

int Main() {
  EndWithWhoeverAsks(kLastWord);
  // Answers have a descriptor of their own: whatever a library prints goes to standard error.
  const int answers = ::fcntl(1, F_DUPFD_CLOEXEC, 3);
  ::dup2(2, 1);
  ::signal(SIGPIPE, SIG_IGN);  // a camera on the network may hang up at any time
  Session session;
  std::string line;
  while (std::getline(std::cin, line)) {
    json answer;
    std::string bytes;
    try {
      answer = Obey(session, json::parse(line), bytes);
      answer["ok"] = true;
    } catch (const Gphoto2Failure& failure) {
      answer = {{"ok", false}, {"code", failure.code}, {"what", failure.what}};
    } catch (const json::exception& e) {
      answer = {{"ok", false}, {"code", GP_ERROR_BAD_PARAMETERS}, {"what", e.what()}};
    }
    const std::string text = answer.dump(-1, ' ', false, json::error_handler_t::replace);
    if (!WriteAll(answers, text + "\n" + bytes)) return 1;
  }
  return 0;
}

}  // namespace
}  // namespace dermap

int main() {
  return dermap::Main();
}
