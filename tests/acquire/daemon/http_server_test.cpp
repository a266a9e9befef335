// SPDX-License-Identifier: Apache-2.0
// The daemon as programs and browsers see it: whole sessions on the simulated station, over HTTP.
#include "acquire/daemon/http_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "common/core/error.h"
#include "common/files/session.h"
#include "tests/acquire/daemon/daemon_under_test.h"

namespace dermap {
namespace {

using nlohmann::json;
using testing::HasSubstr;

using Daemon = acquire_test::DaemonUnderTest;

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

// Every one of 50 watchers hears how it ends, and the daemon still answers.
TEST_F(Daemon, TellsFiftyWatchersAtOnce) {
  constexpr int kWatchers = 50;
  std::atomic<int> connected{0}, heard_the_end{0};
  std::vector<std::thread> watchers;
  for (int i = 0; i < kWatchers; ++i) {
    watchers.emplace_back([&] {
      httplib::Client client("127.0.0.1", server_->port());
      client.set_read_timeout(20, 0);
      bool counted = false;
      std::string tail;
      client.Get("/api/events", [&](const char* data, std::size_t size) {
        if (!counted) ++connected;
        counted = true;
        tail.append(data, size);
        if (tail.find("\"state\":\"complete\"") != std::string::npos) {
          ++heard_the_end;
          return false;
        }
        if (tail.size() > 1000) tail.erase(0, tail.size() - 1000);
        return true;
      });
    });
  }
  for (int i = 0; i < acquire_test::kMostTries && connected < kWatchers; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(connected, kWatchers);
  ASSERT_EQ(Post("start", {{"session", "fifty"}}).status, 200);
  Await("complete");
  for (std::thread& watcher : watchers) watcher.join();
  EXPECT_EQ(heard_the_end, kWatchers);
}

// What is no HTTP at all, at random but the same each time: it closes, and goes on.
TEST_F(Daemon, OutlivesMalformedRequests) {
  std::mt19937 random(7);
  const std::string good =
      "POST /api/start HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 20\r\n"
      "Content-Type: application/json\r\n\r\n{\"session\": \"x\"}    ";
  for (int i = 0; i < 60; ++i) {
    std::string bytes = good;
    for (unsigned changes = random() % 12; changes > 0; --changes)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    if (i % 3 == 0) bytes.resize(random() % bytes.size());
    if (i % 7 == 0) bytes.insert(random() % bytes.size(), std::string(random() % 9000, 'A'));
    const int file = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(server_->port()));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ASSERT_EQ(::connect(file, reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
    EXPECT_GE(::send(file, bytes.data(), bytes.size(), MSG_NOSIGNAL), 0);
    ::shutdown(file, SHUT_WR);
    ::close(file);
  }
  EXPECT_EQ(State().at("state"), "idle");
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

// Whatever is wrong, the answer is a JSON object with a sentence.
TEST_F(Daemon, TellsEveryErrorInASentence) {
  httplib::Headers headers{{"X-Dermap-Key", key_}};
  for (const char* number : {"1e99", "-1", "0", "\"x\"", "null", "99999999999999999999", "1.5", "[]"}) {
    const auto answer = client_->Post("/api/retake", headers, std::string("{\"number\": ") + number + "}",
                                      "application/json");
    ASSERT_TRUE(answer) << number;
    EXPECT_EQ(answer->status, 400) << number;
    EXPECT_TRUE(json::parse(answer->body).at("error").is_string()) << answer->body;
  }
  for (const char* path : {"/nothing", "/../etc/passwd", "/api/frames/-1.png", "/api/frames/123456.png"}) {
    const auto answer = client_->Get(path);
    ASSERT_TRUE(answer) << path;
    EXPECT_EQ(answer->status, 404) << path;
    EXPECT_TRUE(json::parse(answer->body).at("error").is_string()) << path;
  }
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
