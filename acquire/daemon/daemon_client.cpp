// SPDX-License-Identifier: Apache-2.0
// One thread listens to the daemon's events, one keeps the helm, the caller's asks the operator.
#include "acquire/daemon/daemon_client.h"

#include <httplib.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/core/error.h"

namespace dermap {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

constexpr auto kKeepHelmEvery = 4s;  // the daemon keeps it for 15 s
constexpr auto kLookEvery = 100ms;
constexpr std::size_t kLongestEvent = 4 << 20;

class Connection {
 public:
  explicit Connection(const ServerOptions& daemon)
      : where_(daemon.address + ":" + std::to_string(daemon.port)), http_(daemon.address, daemon.port) {
    http_.set_connection_timeout(5, 0);
    http_.set_read_timeout(10, 0);
    if (!daemon.token.empty()) token_ = "Bearer " + daemon.token;
  }

  json Post(const std::string& what, const json& body) {
    httplib::Headers headers = Headers();
    headers.emplace("X-Dermap-Key", key_);
    const auto answer = http_.Post("/api/" + what, headers, body.dump(), "application/json");
    if (!answer)
      throw DeviceError("no daemon answers at " + where_ +
                        "; remedy: start one by 'dermap serve', or correct --daemon");
    const json object = json::parse(answer->body, nullptr, false);
    if (answer->status == 200 && object.is_object()) return object;
    throw InputError("the daemon at " + where_ + " refuses: " +
                     (object.is_object() ? object.value("error", "") : std::to_string(answer->status)));
  }
  void TakeHelm() { key_ = Post("steer", {{"key", key_}}).value("key", ""); }

  // Until `on_state` returns false or the connection ends.
  void Listen(const std::function<bool(const json&)>& on_state) {
    std::string text;
    http_.Get("/api/events", Headers(), [&](const char* data, std::size_t size) {
      text.append(data, size);
      if (text.size() > kLongestEvent) return false;
      for (auto end = text.find("\n\n"); end != std::string::npos; end = text.find("\n\n")) {
        const json state =
            text.rfind("data: ", 0) == 0 ? json::parse(text.substr(6, end - 6), nullptr, false) : json();
        text.erase(0, end + 2);
        if (state.is_object() ? !on_state(state) : !on_state(json())) return false;
      }
      return true;
    });
  }
  void SetKey(const std::string& key) { key_ = key; }
  const std::string& key() const { return key_; }
  void Stop() { http_.stop(); }

 private:
  httplib::Headers Headers() const {
    return token_.empty() ? httplib::Headers{} : httplib::Headers{{"Authorization", token_}};
  }
  std::string where_, token_, key_;
  httplib::Client http_;
};

// The newest state, as the listening thread hears it.
class Heard {
 public:
  void Set(json state) {
    const std::lock_guard lock(mutex_);
    state_ = std::move(state);
    news_.notify_all();
  }
  void End() {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    news_.notify_all();
  }
  json Wait() {
    std::unique_lock lock(mutex_);
    news_.wait_for(lock, kLookEvery);
    return state_;
  }
  json Now() const {
    const std::lock_guard lock(mutex_);
    return state_;
  }
  bool ended() const {
    const std::lock_guard lock(mutex_);
    return ended_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable news_;
  json state_;
  bool ended_ = false;
};

OperatorRequest RequestOf(const json& request) {
  OperatorRequest r;
  const std::string kind = request.value("kind", "");
  r.kind = kind == "turn"    ? OperatorRequest::Kind::kTurnWheel
           : kind == "fault" ? OperatorRequest::Kind::kFault
                             : OperatorRequest::Kind::kPlace;
  r.role = RoleFromName(request.value("role", "")).value_or(FrameRole::kBlack);
  r.slot = request.value("slot", 0);
  r.sentence = request.value("sentence", "");
  return r;
}

bool IsUnderWay(const json& state) {
  const std::string name = state.value("state", "");
  return name == "running" || name == "waiting" || name == "paused";
}

RemoteSummary SummaryOf(const json& state) {
  if (state.value("state", "") == "failed") throw DeviceError(state.value("problem", ""));
  RemoteSummary summary;
  summary.complete = state.value("state", "") == "complete";
  summary.done = state.value("done", 0);
  summary.total = static_cast<int>(state.value("schedule", json::array()).size());
  summary.warnings = state.value("warnings", std::vector<std::string>{});
  return summary;
}

void Start(const SessionForm& form, Connection& connection) {
  try {
    connection.Post("start", {{"session", form.session},
                              {"subject", form.subject},
                              {"site", form.site},
                              {"notes", form.notes},
                              {"reference", form.reference},
                              {"resume", form.resume}});
  } catch (const Error&) {
    connection.Post("release", json::object());
    throw;
  }
}

// What is to be done about one state, in the caller's thread.
void Serve(const RemoteSession& session, Connection& connection, const Heard& heard, const json& state) {
  if (session.progress && !state.value("schedule", json::array()).empty())
    session.progress(state.value("done", 0.0) / static_cast<double>(state["schedule"].size()));
  if (!state.contains("request") || !state["request"].is_object() || !session.ask) return;
  const json request = state["request"];
  const auto over = [&] {
    const json now = heard.Now();
    return session.stop() || heard.ended() || !now.is_object() || now.value("request", json()) != request;
  };
  if (!over() && session.ask(RequestOf(request), over)) connection.Post("answer", json::object());
}

}  // namespace

RemoteSummary RunOnDaemon(const RemoteSession& session) {
  Connection connection(session.daemon);
  connection.TakeHelm();
  Start(session.form, connection);
  Heard heard;
  std::atomic<bool> done{false};
  Connection events(session.daemon);
  std::thread listener([&] {
    events.Listen([&](const json& state) {
      if (state.is_object()) heard.Set(state);
      return !done && (!state.is_object() || IsUnderWay(state));
    });
    heard.End();
  });
  Connection helm(session.daemon);
  helm.SetKey(connection.key());
  std::thread keeper([&] {
    for (auto next = std::chrono::steady_clock::now(); !done; std::this_thread::sleep_for(kLookEvery)) {
      if (std::chrono::steady_clock::now() < next) continue;
      next = std::chrono::steady_clock::now() + kKeepHelmEvery;
      try {
        helm.TakeHelm();
      } catch (const Error&) {  // the listener notices a daemon that has gone
      }
    }
  });
  const auto finish = [&] {
    done = true;
    events.Stop();
    listener.join();
    keeper.join();
    try {
      connection.Post("release", json::object());
    } catch (const Error&) {  // it is given up by itself after a while
    }
  };
  try {
    bool aborted = false;
    while (!heard.ended()) {
      const json state = heard.Wait();
      if (session.stop() && !aborted) {
        aborted = true;
        connection.Post("abort", json::object());
      }
      if (state.is_object() && IsUnderWay(state) && !aborted) Serve(session, connection, heard, state);
    }
  } catch (...) {
    finish();
    throw;
  }
  finish();
  const json last = heard.Now();
  if (!last.is_object() || IsUnderWay(last))
    throw DeviceError("the daemon has gone; remedy: start it again, then go on with --resume");
  return SummaryOf(last);
}

}  // namespace dermap
