// SPDX-License-Identifier: Apache-2.0
// `capture --daemon` at work: a session on a daemon that runs the simulated station.
#include "acquire/daemon/daemon_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/core/error.h"
#include "common/files/session.h"
#include "tests/acquire/daemon/daemon_under_test.h"

namespace dermap {
namespace {

using testing::HasSubstr;

class DaemonClient : public acquire_test::DaemonUnderTest {
 protected:
  DaemonClient() {
    session_.daemon.port = server_->port();
    session_.form.session = "remote";
    session_.form.subject = "S3";
    session_.stop = [] { return false; };
    session_.ask = [](const OperatorRequest&, const std::function<bool()>&) { return true; };
  }
  // As the fixture's own client has the helm, this one is another program.
  template <class Exception>
  std::string Refusal() {
    try {
      RunOnDaemon(session_);
    } catch (const Exception& error) {
      return error.what();
    }
    return "no error";
  }
  void GiveUpHelm() { ASSERT_EQ(Post("release", nullptr).status, 200); }
  RemoteSession session_;
};

TEST_F(DaemonClient, TakesAWholeSession) {
  GiveUpHelm();
  double last = 0.0;
  session_.progress = [&](double fraction) { last = fraction; };
  const RemoteSummary summary = RunOnDaemon(session_);
  EXPECT_TRUE(summary.complete);
  EXPECT_EQ(summary.done, acquire_test::kSmallPlanFrames);
  EXPECT_EQ(summary.total, acquire_test::kSmallPlanFrames);
  EXPECT_GE(last, 0.0);
  const Session session = ReadSession(folder_.path() / "sessions/remote");
  EXPECT_TRUE(session.complete);
  EXPECT_EQ(session.plan.subject, "S3");
}

TEST_F(DaemonClient, EndsASessionWhenAskedToAndResumesIt) {
  GiveUpHelm();
  folder_.Write("plan.toml", "skin_frames = 60\n" + acquire_test::SmallPlanToml());
  std::atomic<bool> stop{false};
  session_.stop = [&] { return stop.load(); };
  session_.progress = [&](double fraction) { stop = fraction > 0.0; };
  EXPECT_FALSE(RunOnDaemon(session_).complete);
  stop = false;
  session_.progress = nullptr;
  session_.form.resume = true;
  EXPECT_TRUE(RunOnDaemon(session_).complete);
}

TEST_F(DaemonClient, TellsWhyTheDaemonRefuses) {
  EXPECT_THAT(Refusal<InputError>(), HasSubstr("another window has the helm"));
  GiveUpHelm();
  session_.form.session = "../out";
  EXPECT_THAT(Refusal<InputError>(), HasSubstr("is no name for a session"));
}

TEST_F(DaemonClient, SaysThatNoDaemonAnswers) {
  session_.daemon.port = 1;
  EXPECT_THAT(Refusal<DeviceError>(), HasSubstr("dermap serve"));
}

}  // namespace
}  // namespace dermap
