// SPDX-License-Identifier: Apache-2.0
// What the daemon says, held to the schema that it serves itself. The validator is valijson's.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>

#include "tests/acquire/daemon/daemon_under_test.h"

namespace dermap {
namespace {

using nlohmann::json;

class ApiSchema : public acquire_test::DaemonUnderTest {
 protected:
  ApiSchema() { schema_ = json::parse(client_->Get("/api/schema")->body); }

  // What is wrong with it; empty where it fits that definition.
  std::string Problems(const std::string& definition, const json& value) {
    json root = schema_;
    root["$ref"] = "#/definitions/" + definition;
    valijson::Schema parsed;
    valijson::SchemaParser parser;
    parser.populateSchema(valijson::adapters::NlohmannJsonAdapter(root), parsed);
    valijson::Validator validator;
    valijson::ValidationResults results;
    if (validator.validate(parsed, valijson::adapters::NlohmannJsonAdapter(value), &results)) return "";
    std::string text = "does not fit";
    valijson::ValidationResults::Error error;
    while (results.popError(error)) {
      for (const std::string& part : error.context) text += part;
      text += ": " + error.description + "; ";
    }
    return text;
  }

  json schema_;
};

TEST_F(ApiSchema, DescribesEveryStateOfASession) {
  folder_.Write("plan.toml", "[[exposure]]\nslot = 1\niso = 1600\n");  // grows while it is taken
  EXPECT_EQ(Problems("state", State()), "");
  std::string text;
  int events = 0;
  std::thread watcher([&] {
    httplib::Client client("127.0.0.1", server_->port());
    client.set_read_timeout(10, 0);
    client.Get("/api/events", [&](const char* data, std::size_t size) {
      text.append(data, size);
      for (auto end = text.find("\n\n"); end != std::string::npos; end = text.find("\n\n")) {
        if (text.rfind("data: ", 0) == 0) {
          const json state = json::parse(text.substr(6, end - 6));
          EXPECT_EQ(Problems("state", state), "") << state.dump();
          ++events;
          if (state.at("state") == "complete") return false;
        }
        text.erase(0, end + 2);
      }
      return true;
    });
  });
  const json start{{"session", "one"}, {"subject", "S7"}};
  EXPECT_EQ(Problems("start", start), "");
  ASSERT_EQ(Post("start", start).status, 200);
  watcher.join();
  EXPECT_GT(events, 3);
  const json state = State();
  EXPECT_GT(state.at("schedule").size(), 3u) << "black frames of the changed exposure";
  EXPECT_FALSE(state.at("warnings").empty());
}

TEST_F(ApiSchema, DescribesRefusals) {
  for (const auto& [what, body] : {std::pair<std::string, json>{"start", {{"session", "../x"}}},
                                   {"retake", {{"number", 7}}},
                                   {"answer", json::object()},
                                   {"continue", json::object()}}) {
    const auto answer = Post(what, body);
    EXPECT_EQ(answer.status, 400) << what;
    EXPECT_EQ(Problems("error", json::parse(answer.body)), "") << what;
  }
  EXPECT_NE(Problems("start", {{"session", "../x"}}), "");
  EXPECT_EQ(Problems("steer", {{"key", key_}}), "");
}

// A schema that fits everything would prove nothing.
TEST_F(ApiSchema, RefusesAnotherState) {
  json state = State();
  state["surprise"] = 1;
  EXPECT_NE(Problems("state", state), "");
  state.erase("surprise");
  state["state"] = "asleep";
  EXPECT_NE(Problems("state", state), "");
  state.erase("state");
  EXPECT_NE(Problems("state", state), "");
}

}  // namespace
}  // namespace dermap
