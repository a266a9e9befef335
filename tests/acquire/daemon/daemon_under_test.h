// SPDX-License-Identifier: Apache-2.0
// A daemon on the simulated station, behind HTTP on a free port, and a client at its helm.
#pragma once

#include <gtest/gtest.h>
#include <httplib.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "acquire/daemon/http_server.h"
#include "tests/acquire/support.h"

namespace dermap::acquire_test {

inline constexpr int kMostTries = 6000;  // of 10 ms; beyond it something hangs

class DaemonUnderTest : public testing::Test {
 protected:
  DaemonUnderTest() {
    folder_.Write("scene.toml", SmallSceneToml());
    DaemonOptions options;
    options.rig = folder_.Write("rig.toml", SmallRigToml("scene.toml"));
    options.plan = folder_.Write("plan.toml", SmallPlanToml());
    options.root = folder_.path() / "sessions";
    daemon_ = std::make_unique<CaptureDaemon>(options);
    ServerOptions server;
    server.port = 0;
    server_ = std::make_unique<HttpServer>(*daemon_, server);
    thread_ = std::thread([this] { server_->Run(); });
    client_ = std::make_unique<httplib::Client>("127.0.0.1", server_->port());
    client_->set_read_timeout(5, 0);
    key_ = nlohmann::json::parse(Post("steer", {{"key", ""}}).body).at("key");
  }
  ~DaemonUnderTest() override {
    server_->Stop();
    thread_.join();
  }

  httplib::Response Post(const std::string& what, const nlohmann::json& body,
                         const httplib::Headers& more = {}) {
    httplib::Headers headers = more;
    headers.emplace("X-Dermap-Key", key_);
    const nlohmann::json object =
        body.is_null() ? nlohmann::json::object() : body;  // {} is null to the library
    const auto result = client_->Post("/api/" + what, headers, object.dump(), "application/json");
    return result ? *result : httplib::Response{};
  }
  nlohmann::json State() {
    const auto result = client_->Get("/api/state");
    return result ? nlohmann::json::parse(result->body) : nlohmann::json::object();
  }
  // The state once it is `name`; fails after a while.
  nlohmann::json Await(const std::string& name) {
    for (int i = 0; i < kMostTries; ++i) {
      const nlohmann::json state = State();
      if (state.value("state", "") == name) return state;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ADD_FAILURE() << "never " << name << ": " << State().dump();
    return {};
  }

  TemporaryFolder folder_;
  std::unique_ptr<CaptureDaemon> daemon_;
  std::unique_ptr<HttpServer> server_;
  std::thread thread_;
  std::unique_ptr<httplib::Client> client_;
  std::string key_;
};

}  // namespace dermap::acquire_test
