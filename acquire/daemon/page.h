// SPDX-License-Identifier: Apache-2.0
// The operator's page, page.html, as it is compiled into the program.
#pragma once

namespace dermap {

extern const char* const kOperatorPage;

}  // namespace dermap
