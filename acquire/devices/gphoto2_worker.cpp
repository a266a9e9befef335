// SPDX-License-Identifier: Apache-2.0
// The program dermap-camera: libgphoto2 behind a pipe. Requests come as JSON lines on standard input, answers
// go out the same way, a frame's bytes after its line. Whoever started it kills it when it hangs. Its HOME is
// its own, so settings of libgphoto2 (capture target, time limits) are ours alone.
#include <fcntl.h>
#include <gphoto2/gphoto2.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
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

namespace dermap {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;
using SteadyClock = std::chrono::steady_clock;

constexpr int kSettingsFault = -1000;   // of ours: the camera cannot be set so
constexpr double kNearestRatio = 1.13;  // of exposure times: a sixth of a stop

struct Failure {
  int code;
  std::string what;
};

void Require(int result, const std::string& doing) {
  if (result < GP_OK) throw Failure{result, doing + ": " + gp_result_as_string(result)};
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
    Require(gp_camera_new(&camera_), "new camera");
    Choose(request.value("port", "usb:"), request.value("model", ""));
    Require(gp_camera_init(camera_, context_), "open the camera");
    CameraAbilities abilities{};
    Require(gp_camera_get_abilities(camera_, &abilities), "ask what the camera can");
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
    ChooseFormat();
    SetTo("iso", std::to_string(request.at("iso").get<int>()));
    SetExposure(request.at("exposure_ms").get<double>());
    RequireRoom();
    return json::object();
  }

  json TellRoom() {
    RequireOpen();
    return {{"room", Room()}};
  }

  json Expose(const json& request) {
    RequireOpen();
    Drain(milliseconds(request.value("quiet_ms", 0)));
    if (!can_trigger_) {  // older drivers expose and store in one call
      CameraFilePath path{};
      Require(gp_camera_capture(camera_, GP_CAPTURE_IMAGE, &path, context_), "take a frame");
      added_ = path;
      return json::object();
    }
    Require(gp_camera_trigger_capture(camera_, context_), "press the shutter");
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
    Require(gp_file_new(&file), "new file");
    const std::unique_ptr<CameraFile, int (*)(CameraFile*)> owner(file, gp_file_free);
    Require(gp_camera_file_get(camera_, added_->folder, added_->name, GP_FILE_TYPE_NORMAL, file, context_),
            "fetch the frame");
    const char* data = nullptr;
    unsigned long size = 0;
    Require(gp_file_get_data_and_size(file, &data, &size), "read the frame");
    bytes.assign(data, size);
    const std::string name = added_->name;
    added_.reset();
    return {{"name", name}, {"bytes", size}};
  }

  // Models and ports of what is attached.
  json List() {
    CameraList* found = nullptr;
    Require(gp_list_new(&found), "new list");
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
    if (camera_ == nullptr) throw Failure{GP_ERROR_IO, "the camera is not open"};
  }

  void LoadLists() {
    if (abilities_ != nullptr) return;
    Require(gp_abilities_list_new(&abilities_), "new list of drivers");
    Require(gp_abilities_list_load(abilities_, context_), "load the drivers");
  }
  GPPortInfoList* Ports() {  // anew each time: addresses change with every plug
    if (ports_ != nullptr) gp_port_info_list_free(ports_);
    ports_ = nullptr;
    Require(gp_port_info_list_new(&ports_), "new list of ports");
    Require(gp_port_info_list_load(ports_), "load the ports");
    return ports_;
  }
  void Detect(CameraList* found) {
    LoadLists();
    Require(gp_abilities_list_detect(abilities_, Ports(), found, context_), "look for cameras");
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
      if (chosen_port == "usb:") throw Failure{GP_ERROR_MODEL_NOT_FOUND, "no camera on USB"};
    } else if (model.empty()) {
      chosen_model = port.rfind("ptpip:", 0) == 0 ? "PTP/IP Camera" : "USB PTP Class Camera";
    }
    const int index = gp_abilities_list_lookup_model(abilities_, chosen_model.c_str());
    Require(index, "find a driver for '" + chosen_model + "'");
    CameraAbilities abilities{};
    Require(gp_abilities_list_get_abilities(abilities_, index, &abilities), "find a driver");
    Require(gp_camera_set_abilities(camera_, abilities), "choose the driver");
    GPPortInfoList* ports = Ports();
    const int at = gp_port_info_list_lookup_path(ports, chosen_port.c_str());
    Require(at, "find the port " + chosen_port);
    GPPortInfo info = nullptr;
    Require(gp_port_info_list_get_info(ports, at, &info), "find the port");
    Require(gp_camera_set_port_info(camera_, info), "choose the port");
  }

  std::unique_ptr<CameraWidget, int (*)(CameraWidget*)> Widget(const char* name) {
    CameraWidget* widget = nullptr;
    Require(gp_camera_get_single_config(camera_, name, &widget, context_), std::string("ask for ") + name);
    return {widget, gp_widget_free};
  }
  static std::string ValueOf(CameraWidget* widget) {
    const char* value = nullptr;
    Require(gp_widget_get_value(widget, &value), "read a setting");
    return value == nullptr ? "" : value;
  }

  void SetTo(const char* name, const std::string& value) {
    auto widget = Widget(name);
    if (ValueOf(widget.get()) == value) return;
    if (gp_widget_set_value(widget.get(), value.c_str()) < GP_OK)
      RefuseSetting(name, value, ValueOf(widget.get()));
    const int result = gp_camera_set_single_config(camera_, name, widget.get(), context_);
    if (result == GP_ERROR_BAD_PARAMETERS || result == GP_ERROR)
      RefuseSetting(name, value, ValueOf(widget.get()));
    Require(result, std::string("set ") + name);
    const std::string now = ValueOf(Widget(name).get());
    if (now != value) RefuseSetting(name, value, now);
  }
  [[noreturn]] static void RefuseSetting(const std::string& name, const std::string& asked,
                                         const std::string& now) {
    throw Failure{kSettingsFault, name + " cannot be set to " + asked + ", it stays at " + now};
  }

  void SetExposure(double exposure_ms) {
    auto widget = Widget("shutterspeed");
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
      RefuseSetting("shutterspeed", std::to_string(exposure_ms) + " ms", ValueOf(widget.get()));
    SetTo("shutterspeed", best);
  }

  // Raw alone: a JPEG beside it costs time and could be taken for the frame.
  void ChooseFormat() {
    auto widget = Widget("imageformat");
    if (ValueOf(widget.get()) != "RAW") SetTo("imageformat", "RAW");
  }

  // How many frames the card takes; -1 where the camera does not tell.
  int Room() {
    CameraWidget* widget = nullptr;
    if (gp_camera_get_single_config(camera_, "availableshots", &widget, context_) < GP_OK) return -1;
    const std::unique_ptr<CameraWidget, int (*)(CameraWidget*)> owner(widget, gp_widget_free);
    const std::string value = ValueOf(widget);
    return value.empty() ? -1 : std::atoi(value.c_str());
  }
  void RequireRoom() {
    if (Room() == 0) throw Failure{GP_ERROR_NO_SPACE, "the card is full"};
  }

  // What was stored before is not ours: nothing that comes of it may be taken for the next frame.
  void Drain(milliseconds quiet) {
    added_.reset();
    const auto until = SteadyClock::now() + quiet;
    do {
      CameraEventType kind = GP_EVENT_UNKNOWN;
      void* data = nullptr;
      const auto left = std::chrono::duration_cast<milliseconds>(until - SteadyClock::now());
      Require(gp_camera_wait_for_event(camera_, static_cast<int>(std::max<long>(1, left.count())), &kind,
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
      Require(gp_camera_wait_for_event(camera_, static_cast<int>(std::max<long>(1, left.count())), &kind,
                                       &data, context_),
              "wait for the frame");
      const std::unique_ptr<void, void (*)(void*)> owner(data, std::free);
      if (kind != GP_EVENT_FILE_ADDED) continue;
      added_ = *static_cast<CameraFilePath*>(data);
      return {{"folder", added_->folder}, {"name", added_->name}, {"added", true}};
    }
    throw Failure{GP_ERROR_TIMEOUT, "the camera has stored no frame"};
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
  throw Failure{GP_ERROR_BAD_PARAMETERS, "unknown request '" + what + "'"};
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
    } catch (const Failure& failure) {
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
