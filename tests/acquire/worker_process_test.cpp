// SPDX-License-Identifier: Apache-2.0
// A helper process that libgphoto2 has led astray may say anything: it is a fault of the device, with its
// remedy, and the next question goes to a new process. Programs of /bin/sh stand for it.
#include "acquire/devices/worker_process.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>

#include "acquire/devices/device_fault.h"
#include "tests/acquire/support.h"

namespace dermap {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

class Worker : public testing::Test {
 protected:
  // A program that answers every line with what `answer`, a command of sh, prints.
  WorkerProcess Make(const std::string& answer) {
    const auto program = folder_.Write("worker", "#!/bin/sh\nwhile read question; do " + answer + "; done\n");
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    return {program, folder_.path()};
  }
  static std::string FaultOf(WorkerProcess& worker, std::chrono::milliseconds limit = 20s) {
    try {
      worker.Ask("{}", limit);
    } catch (const DeviceFault& fault) {
      EXPECT_THAT(fault.what(), HasSubstr("remedy"));
      EXPECT_FALSE(worker.running());
      return fault.what();
    }
    return "no fault";
  }
  acquire_test::TemporaryFolder folder_;
};

TEST_F(Worker, AnswersWithALineAndTheBytesThatItTellsOf) {
  WorkerProcess worker = Make(R"(printf '{"bytes": 5}\nfiles{"other": 1}\n')");
  const WorkerAnswer answer = worker.Ask("{}", 20s);
  EXPECT_EQ(answer.line, "{\"bytes\": 5}");
  EXPECT_EQ(answer.bytes.size(), 5u);
  EXPECT_EQ(static_cast<char>(answer.bytes[0]), 'f');
}

TEST_F(Worker, ThatTalksNonsenseIsAFault) {
  for (const char* line : {"nonsense", "[1]", "7", "{\"bytes\": \"many\"}", "{\"bytes\": -1}",
                           "{\"bytes\": 1e300}", "{\"bytes\": 1.5}", "{\"bytes\": 99999999999}",
                           "{\"bytes\": [4]}", "{\"bytes\": null}", "\\0\\377"}) {
    WorkerProcess worker = Make(std::string("printf '") + line + "\\n'");
    EXPECT_THAT(FaultOf(worker), HasSubstr("talks nonsense")) << line;
  }
}

TEST_F(Worker, ThatEndsOrFallsSilentIsAFault) {
  WorkerProcess ends_at_once = Make("exit");
  EXPECT_THAT(FaultOf(ends_at_once), HasSubstr("has ended"));
  WorkerProcess ends_amid_bytes = Make(R"(printf '{"bytes": 100}\nshort'; exit)");
  EXPECT_THAT(FaultOf(ends_amid_bytes), HasSubstr("has ended"));
  WorkerProcess silent = Make("read never");
  EXPECT_THAT(FaultOf(silent, 100ms), HasSubstr("says nothing"));
  WorkerProcess endless = Make("head -c 3000000 /dev/zero");
  EXPECT_THAT(FaultOf(endless), HasSubstr("talks nonsense"));
}

// A copy of a connection that is open here would outlive us in it.
TEST_F(Worker, HoldsNothingOpenButItsPipes) {
  const int ours = fcntl(STDERR_FILENO, F_DUPFD, 50);  // not close-on-exec, as some libraries open things
  const std::string held = "/proc/$$/fd/" + std::to_string(ours);
  WorkerProcess worker = Make("if [ -e " + held + R"( ]; then echo '{"held": 1}'; else echo '{}'; fi)");
  EXPECT_EQ(worker.Ask("{}", 20s).line, "{}");
  close(ours);
}

TEST_F(Worker, IsStartedAnewAfterAFault) {
  WorkerProcess worker = Make("if [ -e $HOME/said ]; then printf '{}\\n'; else : >$HOME/said; exit; fi");
  EXPECT_THAT(FaultOf(worker), HasSubstr("has ended"));
  EXPECT_EQ(worker.Ask("{}", 20s).line, "{}");
}

}  // namespace
}  // namespace dermap
