// SPDX-License-Identifier: Apache-2.0
// Who may ask what. A page of another site can make a browser send requests here: the Host header must be
// ours (DNS rebinding), an Origin must be ours, and what changes anything must be JSON, which no form of
// another site can send.
#include "acquire/daemon/http_server.h"

#include <httplib.h>
#include <sys/socket.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <nlohmann/json.hpp>

#include "acquire/daemon/bounded_server.h"
#include "acquire/daemon/page.h"
#include "acquire/daemon/request_guard.h"
#include "acquire/daemon/state_text.h"
#include "acquire/daemon/thread_per_task.h"
#include "common/core/error.h"

namespace dermap {
namespace {

using nlohmann::json;
using SteadyClock = std::chrono::steady_clock;

constexpr std::size_t kLargestBody = 65536, kLargestHead = 32768;
constexpr int kLargestFrameNumber = 99999;
constexpr std::size_t kConnections = 80;  // served at once; each event stream is one
constexpr std::size_t kRequestsOfAConnection = 100000;
constexpr std::chrono::seconds kHelmKept{15};
constexpr std::chrono::milliseconds kHeartbeat{2000};

void Refuse(httplib::Response& response, int status, const std::string& why) {
  response.status = status;
  response.set_content(json{{"error", why}}.dump(-1, ' ', false, json::error_handler_t::replace),
                       "application/json");
}

class Connections : public httplib::TaskQueue {
 public:
  void enqueue(std::function<void()> serve) override { threads_.Run(std::move(serve)); }
  void shutdown() override { threads_.Join(); }

 private:
  ThreadPerTask threads_{kConnections};
};

}  // namespace

struct HttpServer::Impl {
  CaptureDaemon& daemon;
  ServerOptions options;
  std::unique_ptr<httplib::Server> server =
      MakeBoundedServer({kLargestHead + kLargestBody, options.request_time});
  int listener = -1;
  std::atomic<bool> stopping{false};
  std::mutex helm_mutex;
  std::string helm_key;
  SteadyClock::time_point helm_seen{};
  StateText state{daemon};

  Impl(CaptureDaemon& d, ServerOptions o) : daemon(d), options(std::move(o)) {}

  bool Allowed(const httplib::Request& request, httplib::Response& response) {
    const std::string host = request.get_header_value("Host");
    if (options.token.empty() && !HostIsOurs(host, options.address, options.port)) {
      Refuse(response, 403, "this is not the Host that the daemon listens at");
      return false;
    }
    if (!OriginIsOurs(request.get_header_value("Origin"), host)) {
      Refuse(response, 403, "pages of other sites may not talk to the daemon");
      return false;
    }
    if (!options.token.empty()) {
      std::string given = request.get_header_value("Authorization");
      const std::string bearer = "Bearer ";
      given = given.rfind(bearer, 0) == 0 ? given.substr(bearer.size()) : request.get_param_value("token");
      if (!SameToken(given, options.token)) {
        Refuse(response, 401, "the token is missing or wrong");
        return false;
      }
    }
    if (request.method == "POST" &&
        request.get_header_value("Content-Type").rfind("application/json", 0) != 0) {
      Refuse(response, 415, "expected application/json");
      return false;
    }
    if (request.has_header("Content-Encoding")) {  // a few bytes could stand for many
      Refuse(response, 415, "the body must not be compressed");
      return false;
    }
    if (request.method == "POST" &&
        (!request.has_header("Content-Length") || request.has_header("Transfer-Encoding"))) {
      Refuse(response, 411, "expected a Content-Length, not chunks");
      return false;
    }
    return true;
  }

  // {"key": ...} of whoever has the helm, or an error where that is another.
  void Steer(const json& body, httplib::Response& response) {
    const std::lock_guard lock(helm_mutex);
    const bool free = helm_key.empty() || SteadyClock::now() - helm_seen > kHelmKept;
    if (body.value("key", "") != helm_key || helm_key.empty()) {
      if (!free) return Refuse(response, 409, "another window has the helm");
      helm_key = RandomKey();
    }
    helm_seen = SteadyClock::now();
    response.set_content(json{{"key", helm_key}}.dump(), "application/json");
  }

  bool HasHelm(const httplib::Request& request) {
    const std::lock_guard lock(helm_mutex);
    if (helm_key.empty() || request.get_header_value("X-Dermap-Key") != helm_key) return false;
    helm_seen = SteadyClock::now();
    return true;
  }

  void Post(const std::string& path, const std::function<void(const json&)>& act) {
    server->Post(path, [this, act](const httplib::Request& request, httplib::Response& response) {
      if (!HasHelm(request))
        return Refuse(response, 409, "another window has the helm: this one can only watch");
      const json body = json::parse(request.body.empty() ? "{}" : request.body, nullptr, false);
      if (!body.is_object()) return Refuse(response, 400, "expected a JSON object");
      try {
        act(body);
        response.set_content("{}", "application/json");
      } catch (const json::exception& error) {
        const std::string what = error.what();  // "[json.exception.type_error.302] type must be ..."
        const auto words = what.find("] ");
        Refuse(response, 400,
               "the body is not as /api/schema has it: " +
                   (words == std::string::npos ? what : what.substr(words + 2)));
      } catch (const Error& error) {
        Refuse(response, 400, error.what());
      }
    });
  }

  void Events(httplib::Response& response) {
    response.set_header("Cache-Control", "no-store");
    response.set_header("Connection", "close");
    response.set_content_provider("text/event-stream", [this, seen = std::uint64_t{0}, text = std::string()](
                                                           std::size_t, httplib::DataSink& sink) mutable {
      const std::uint64_t now = daemon.WaitBeyond(seen, kHeartbeat);
      if (stopping) return false;
      if (now == seen) {
        text = ": still here\n\n";
      } else {
        text = "data: ";
        state.AppendTo(text, now);
        text += "\n\n";
      }
      seen = now;
      return sink.write(text.data(), text.size());
    });
  }

  void Route() {
    server->set_payload_max_length(kLargestBody);
    server->set_keep_alive_max_count(kRequestsOfAConnection);
    server->set_socket_options([this](int socket) {
      listener = socket;
      httplib::default_socket_options(socket);
    });
    server->new_task_queue = [] { return new Connections; };
    server->set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      response.set_header("X-Content-Type-Options", "nosniff");
      response.set_header("Referrer-Policy", "no-referrer");
      response.set_header(
          "Content-Security-Policy",
          "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src 'self'; "
          "connect-src 'self'; frame-ancestors 'none'");
      return Allowed(request, response) ? httplib::Server::HandlerResponse::Unhandled
                                        : httplib::Server::HandlerResponse::Handled;
    });
    server->set_error_handler([](const httplib::Request&, httplib::Response& response) {
      if (!response.body.empty()) return;
      Refuse(response, response.status,
             response.status == 404   ? "there is nothing at this address"
             : response.status == 413 ? "the body has more than " + std::to_string(kLargestBody) + " bytes"
                                      : "this is no request that the daemon knows");
    });
    server->Get("/", [](const httplib::Request&, httplib::Response& response) {
      response.set_content(kOperatorPage, "text/html; charset=utf-8");
    });
    server->Get("/api/schema", [](const httplib::Request&, httplib::Response& response) {
      response.set_content(kApiSchema, "application/schema+json");
    });
    server->Get("/api/state", [this](const httplib::Request&, httplib::Response& response) {
      std::string text;
      state.AppendTo(text, daemon.Version());
      response.set_content(text, "application/json");
    });
    server->Get("/api/events",
                [this](const httplib::Request&, httplib::Response& response) { Events(response); });
    server->Get(R"(/api/frames/(\d{1,5})\.png)",
                [this](const httplib::Request& request, httplib::Response& response) {
                  const std::string png = daemon.Thumbnail(std::stoi(request.matches[1]));
                  if (png.empty()) return Refuse(response, 404, "there is no such frame");
                  response.set_content(png, "image/png");
                });
    server->Post("/api/steer", [this](const httplib::Request& request, httplib::Response& response) {
      const json body = json::parse(request.body, nullptr, false);
      if (!body.is_object() || !body.contains("key") || !body["key"].is_string()) {
        return Refuse(response, 400, "expected {\"key\": \"...\"}");
      }
      Steer(body, response);
    });
    Post("/api/release", [this](const json&) {
      const std::lock_guard lock(helm_mutex);
      helm_key.clear();
    });
    Post("/api/start", [this](const json& body) {
      daemon.Start({body.at("session").get<std::string>(), body.value("subject", ""), body.value("site", ""),
                    body.value("notes", ""), body.value("reference", ""), body.value("resume", false)});
    });
    Post("/api/answer", [this](const json&) { daemon.Answer(); });
    Post("/api/pause", [this](const json&) { daemon.Pause(); });
    Post("/api/continue", [this](const json&) { daemon.Continue(); });
    Post("/api/abort", [this](const json&) { daemon.Abort(); });
    Post("/api/retake", [this](const json& body) {
      const json& number = body.at("number");
      if (!number.is_number_integer() || number < 1 || number > kLargestFrameNumber)
        throw InputError("'number' is " + number.dump() + "; expected the number of a frame");
      daemon.Retake(number.get<int>());
    });
  }
};

HttpServer::HttpServer(CaptureDaemon& daemon, ServerOptions options)
    : impl_(std::make_unique<Impl>(daemon, std::move(options))) {
  ServerOptions& o = impl_->options;
  if (!IsLoopback(o.address) && o.token.empty()) {
    throw InputError("the daemon listens beyond this machine (" + o.address +
                     ") only with a token; remedy: name a file that holds one by --token-file");
  }
  impl_->Route();
  const bool bound = o.port == 0 ? (o.port = impl_->server->bind_to_any_port(o.address.c_str())) > 0
                                 : impl_->server->bind_to_port(o.address.c_str(), o.port);
  if (!bound) {
    throw InputError("cannot listen on " + o.address + ":" + std::to_string(o.port) +
                     "; remedy: name a free port by --listen, or end the daemon that runs already");
  }
  // The library has five connections wait at most: of fifty windows that open at once most would be dropped,
  // and try again seconds later.
  ::listen(impl_->listener, SOMAXCONN);
}

HttpServer::~HttpServer() {
  Stop();
}

int HttpServer::port() const {
  return impl_->options.port;
}

void HttpServer::Run() {
  impl_->server->listen_after_bind();
}

void HttpServer::Stop() {
  impl_->stopping = true;
  impl_->state.Stop();
  impl_->server->stop();
}

}  // namespace dermap
