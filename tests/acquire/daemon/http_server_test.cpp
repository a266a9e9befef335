// SPDX-License-Identifier: Apache-2.0
// The daemon as programs and browsers see it: whole sessions on the simulated station, over HTTP.
#include "acquire/daemon/http_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "common/core/error.h"
#include "common/files/session.h"
#include "tests/acquire/support.h"

namespace dermap {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr int kMostTries = 600;

class Daemon : public testing::Test {
 protected:
  Daemon() {
    folder_.Write("scene.toml", acquire_test::SmallSceneToml());
    DaemonOptions options;
    options.rig = folder_.Write("rig.toml", acquire_test::SmallRigToml("scene.toml"));
    options.plan = folder_.Write("plan.toml", acquire_test::SmallPlanToml());
    options.root = folder_.path() / "sessions";
    daemon_ = std::make_unique<CaptureDaemon>(options);
    ServerOptions server;
    server.port = 0;
    server_ = std::make_unique<HttpServer>(*daemon_, server);
    thread_ = std::thread([this] { server_->Run(); });
    client_ = std::make_unique<httplib::Client>("127.0.0.1", server_->port());
    client_->set_read_timeout(5, 0);
    key_ = json::parse(Post("steer", {{"key", ""}}).body).at("key");
  }
  ~Daemon() override {
    server_->Stop();
    thread_.join();
  }

  httplib::Response Post(const std::string& what, const json& body, const httplib::Headers& more = {}) {
    httplib::Headers headers = more;
    headers.emplace("X-Dermap-Key", key_);
    const json object = body.is_null() ? json::object() : body;  // {} is null to the library
    const auto result = client_->Post("/api/" + what, headers, object.dump(), "application/json");
    return result ? *result : httplib::Response{};
  }
  json State() {
    const auto result = client_->Get("/api/state");
    return result ? json::parse(result->body) : json::object();
  }
  // The state once it is `name`; fails after a while.
  json Await(const std::string& name) {
    for (int i = 0; i < kMostTries; ++i) {
      const json state = State();
      if (state.value("state", "") == name) return state;
      std::this_thread::sleep_for(10ms);
    }
    ADD_FAILURE() << "never " << name << ": " << State().dump();
    return {};
  }

  acquire_test::TemporaryFolder folder_;
  std::unique_ptr<CaptureDaemon> daemon_;
  std::unique_ptr<HttpServer> server_;
  std::thread thread_;
  std::unique_ptr<httplib::Client> client_;
  std::string key_;
};

TEST_F(Daemon, TakesAWholeSession) {
  EXPECT_EQ(State().at("state"), "idle");
  EXPECT_EQ(Post("start", {{"session", "one"}, {"subject", "S7"}, {"site", "forearm"}}).status, 200);
  const json state = Await("complete");
  EXPECT_EQ(state.at("done"), acquire_test::kSmallPlanFrames);
  ASSERT_EQ(state.at("frames").size(), static_cast<std::size_t>(acquire_test::kSmallPlanFrames));
  EXPECT_EQ(state["frames"][2]["role"], "spectralon");
  EXPECT_EQ(state["frames"][2]["histogram"].size(), 64u);
  EXPECT_TRUE(state["frames"][4]["window_found"].get<bool>());
  const Session session = ReadSession(folder_.path() / "sessions/one");
  EXPECT_TRUE(session.complete);
  EXPECT_EQ(session.plan.subject, "S7");
  EXPECT_EQ(session.plan.site, "forearm");
  const auto picture = client_->Get("/api/frames/5.png");
  ASSERT_TRUE(picture);
  EXPECT_EQ(picture->body.substr(1, 3), "PNG");
  EXPECT_EQ(client_->Get("/api/frames/77.png")->status, 404);
}

TEST_F(Daemon, PausesGoesOnEndsAndResumes) {
  folder_.Write("plan.toml",
                "skin_frames = 60\n" + acquire_test::SmallPlanToml());  // long enough to be paused
  ASSERT_EQ(Post("start", {{"session", "two"}}).status, 200);
  ASSERT_EQ(Post("pause", {}).status, 200);
  Await("paused");
  EXPECT_EQ(Post("start", {{"session", "other"}}).status, 400);
  ASSERT_EQ(Post("continue", {}).status, 200);
  ASSERT_EQ(Post("pause", {}).status, 200);
  Await("paused");
  ASSERT_EQ(Post("abort", {}).status, 200);
  Await("ended");
  EXPECT_FALSE(ReadSession(folder_.path() / "sessions/two").complete);
  ASSERT_EQ(Post("start", {{"session", "two"}, {"resume", true}}).status, 200);
  Await("complete");
  EXPECT_TRUE(ReadSession(folder_.path() / "sessions/two").complete);
}

TEST_F(Daemon, TakesOneFrameAgain) {
  ASSERT_EQ(Post("start", {{"session", "three"}}).status, 200);
  Await("complete");
  const auto before = State().at("version").get<int>();
  EXPECT_EQ(Post("retake", {{"number", 99}}).status, 400);
  ASSERT_EQ(Post("retake", {{"number", 5}}).status, 200);
  const json state = Await("complete");
  EXPECT_GT(state.at("version").get<int>(), before);
  const Session session = ReadSession(folder_.path() / "sessions/three");
  EXPECT_TRUE(session.complete);
  EXPECT_EQ(session.frames.size(), static_cast<std::size_t>(acquire_test::kSmallPlanFrames));
  VerifyFrames(session);
}

TEST_F(Daemon, TellsWatchersOfEveryChange) {
  std::string heard;
  std::thread watcher([&] {
    httplib::Client client("127.0.0.1", server_->port());
    client.set_read_timeout(10, 0);
    client.Get("/api/events", [&](const char* data, std::size_t size) {
      heard.append(data, size);
      return heard.find("\"state\":\"complete\"") == std::string::npos;
    });
  });
  ASSERT_EQ(Post("start", {{"session", "four"}}).status, 200);
  watcher.join();
  EXPECT_THAT(heard, HasSubstr("data: {"));
  EXPECT_THAT(heard, HasSubstr("\"state\":\"complete\""));
}

TEST_F(Daemon, HasOneAtTheHelm) {
  const std::string mine = key_;
  key_.clear();
  EXPECT_EQ(Post("steer", {{"key", ""}}).status, 409);
  EXPECT_EQ(Post("start", {{"session", "stolen"}}).status, 409);
  key_ = std::string(32, '0');
  EXPECT_EQ(Post("pause", {}).status, 409);
  key_ = mine;
  EXPECT_EQ(Post("steer", {{"key", mine}}).status, 200);
}

TEST_F(Daemon, StaysInItsFolder) {
  for (const char* name : {"../out", "/etc/x", "a/b", "", ".hidden", "x\n", "\xC3\xA4"}) {
    EXPECT_EQ(Post("start", {{"session", name}}).status, 400) << name;
    EXPECT_EQ(Post("start", {{"session", "good"}, {"reference", std::string(name) + "/"}}).status, 400)
        << name;
  }
  EXPECT_EQ(State().at("state"), "idle");
}

// DNS rebinding: the browser believes that it talks to another site. Cross-site posts: another site's page
// sends them.
TEST_F(Daemon, RefusesWhatOtherSitesSend) {
  const auto port = std::to_string(server_->port());
  EXPECT_EQ(client_->Get("/api/state", {{"Host", "evil.example:" + port}})->status, 403);
  EXPECT_EQ(client_->Get("/api/state", {{"Host", "localhost:" + port}})->status, 200);
  EXPECT_EQ(Post("pause", {}, {{"Origin", "http://evil.example"}}).status, 403);
  httplib::Headers headers{{"X-Dermap-Key", key_}};
  EXPECT_EQ(client_->Post("/api/abort", headers, "{}", "text/plain")->status, 415);
}

TEST_F(Daemon, RefusesWhatIsTooLargeOrNoJson) {
  httplib::Headers headers{{"X-Dermap-Key", key_}};
  EXPECT_EQ(client_->Post("/api/start", headers, "{not json", "application/json")->status, 400);
  EXPECT_EQ(client_->Post("/api/start", headers, "[1]", "application/json")->status, 400);
  EXPECT_EQ(client_->Post("/api/start", headers, R"({"session": 7})", "application/json")->status, 400);
  EXPECT_EQ(client_
                ->Post("/api/start", headers,
                       R"({"session": "x", "notes": ")" + std::string(500, 'n') + "\"}", "application/json")
                ->status,
            400);
  const auto large = client_->Post("/api/start", headers, std::string(200000, ' '), "application/json");
  EXPECT_TRUE(!large || large->status == 413);
  EXPECT_EQ(State().at("state"), "idle");
}

TEST_F(Daemon, ServesThePage) {
  const auto page = client_->Get("/");
  ASSERT_TRUE(page);
  EXPECT_THAT(page->body, HasSubstr("<title>dermap station</title>"));
  EXPECT_THAT(page->get_header_value("Content-Security-Policy"), HasSubstr("default-src 'none'"));
}

TEST_F(Daemon, ListensBeyondThisMachineOnlyWithAToken) {
  EXPECT_THROW(HttpServer(*daemon_, {"0.0.0.0", 0, ""}), InputError);
  HttpServer guarded(*daemon_, {"127.0.0.1", 0, "a-token-to-guard-it"});
  std::thread thread([&] { guarded.Run(); });
  httplib::Client client("127.0.0.1", guarded.port());
  EXPECT_EQ(client.Get("/api/state")->status, 401);
  EXPECT_EQ(client.Get("/api/state?token=a-token-to-guard-it")->status, 200);
  EXPECT_EQ(client.Get("/api/state", {{"Authorization", "Bearer a-token-to-guard-it"}})->status, 200);
  EXPECT_EQ(client.Get("/api/state", {{"Authorization", "Bearer a-token-to-guard-ix"}})->status, 401);
  guarded.Stop();
  thread.join();
}

}  // namespace
}  // namespace dermap
