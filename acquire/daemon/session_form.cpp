// SPDX-License-Identifier: Apache-2.0
// Names lead to no other folder; texts stay short.
#include "acquire/daemon/session_form.h"

#include <algorithm>
#include <cctype>

#include "common/core/error.h"

namespace dermap {
namespace {

constexpr std::size_t kLongestName = 64, kLongestText = 400;

void RequireName(const std::string& name) {
  const bool good = !name.empty() && name.size() <= kLongestName && name[0] != '.' &&
                    std::all_of(name.begin(), name.end(), [](unsigned char c) {
                      return std::isalnum(c) != 0 || c == '.' || c == '-' || c == '_';
                    });
  if (good) return;
  throw InputError("'" + name.substr(0, kLongestName) +
                   "' is no name for a session; expected 1 to 64 letters, digits, '-', '_' or '.', not "
                   "beginning with '.'");
}

void RequireShort(const char* what, const std::string& text) {
  if (text.size() <= kLongestText) return;
  throw InputError(std::string("'") + what + "' has " + std::to_string(text.size()) +
                   " bytes; expected at most " + std::to_string(kLongestText));
}

}  // namespace

void RequireFilledIn(const SessionForm& form) {
  RequireName(form.session);
  if (!form.reference.empty()) RequireName(form.reference);
  RequireShort("subject", form.subject);
  RequireShort("site", form.site);
  RequireShort("notes", form.notes);
}

}  // namespace dermap
