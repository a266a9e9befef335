// SPDX-License-Identifier: Apache-2.0
// Other people's recordings: raw files in a folder, with a small TOML that says which file is what.
#pragma once

#include <filesystem>

#include "common/core/error.h"
#include "common/files/session.h"

namespace dermap {

// A raw file that the TOML names is not there, or its header cannot be read.
class UnreadableFrame : public InputError {
 public:
  UnreadableFrame(const std::string& message, Session session)
      : InputError(message), session_(std::move(session)) {}
  const Session& session() const noexcept { return session_; }  // as far as the TOML tells it

 private:
  Session session_;
};

// Keys in docs/formats.md. Exposure and ISO are read from the raw files where the TOML does not say. Throws
// InputError.
Session ReadFolderSession(const std::filesystem::path& files_toml);

}  // namespace dermap
