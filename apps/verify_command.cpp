// SPDX-License-Identifier: Apache-2.0
// dermap verify SESSION: whether every frame is as it was captured.
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/command_line.h"
#include "apps/commands.h"
#include "common/files/session.h"

namespace dermap {

int RunVerifyCommand(int argc, char** argv) {
  CommandLine command("verify", "Check a session: its manifest, and the SHA-256 of every frame.");
  std::filesystem::path directory;
  command.app().add_option("SESSION", directory, "The session folder")->required();
  return command.Run(argc, argv, [&] {
    const Session session = ReadSession(directory);
    VerifyFrames(session);
    Outcome outcome;
    outcome.code = session.complete ? ExitCode::kSuccess : ExitCode::kGoalNotReached;
    outcome.text = std::to_string(session.frames.size()) +
                   " frames are as they were captured; the session is " +
                   (session.complete ? "complete\n" : "not complete: go on with capture --resume\n");
    outcome.fill_json = [session](nlohmann::json& json) {
      json = {{"frames", session.frames.size()}, {"complete", session.complete}};
    };
    return outcome;
  });
}

}  // namespace dermap
