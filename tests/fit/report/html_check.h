// SPDX-License-Identifier: Apache-2.0
// Looks at a page as a browser would: are its elements closed, does it fetch anything?
#pragma once

#include <string>
#include <vector>

namespace dermap {

// Everything that is wrong with the nesting of elements; empty for a page whose elements are closed in order.
std::vector<std::string> NestingFaults(const std::string& html);

// Every src, href, url() and @import that is neither part of the page nor an anchor within it, and every
// script.
std::vector<std::string> OutsideReferences(const std::string& html);

// The text of the page without elements, style sheet and pictures.
std::string VisibleText(const std::string& html);

int CountOf(const std::string& html, const std::string& what);

}  // namespace dermap
