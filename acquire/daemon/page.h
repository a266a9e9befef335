// SPDX-License-Identifier: Apache-2.0
// The operator's page, page.html, and the API's JSON schema, api_schema.json, as they are compiled into the
// program.
#pragma once

namespace dermap {

extern const char* const kOperatorPage;
extern const char* const kApiSchema;

}  // namespace dermap
