// SPDX-License-Identifier: Apache-2.0
// What an operator fills in for a session; names of people do not belong here.
#pragma once

#include <string>

namespace dermap {

struct SessionForm {
  std::string session;  // the folder's name: letters, digits, '.', '-', '_'
  std::string subject, site, notes;
  std::string reference;  // the name of an earlier session, or empty
  bool resume = false;
};

// Throws InputError for a name that is none of a folder below the root, and for a text that is too long.
void RequireFilledIn(const SessionForm& form);

}  // namespace dermap
