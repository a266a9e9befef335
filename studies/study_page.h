// SPDX-License-Identifier: Apache-2.0
// What the studies' pages have in common: self-contained HTML, verdicts, a table that sorts.
#pragma once

#include <string>
#include <vector>

#include "studies/verdict.h"

namespace dermap {

// A whole page around sections.
std::string StudyPage(const std::string& title, const std::string& sections);

std::string VerdictTable(const std::vector<Verdict>& verdicts);

// As DrawTable; a click on a heading sorts by that column, numbers by value, empty cells last. Once a page.
std::string SortableTable(const std::vector<std::vector<std::string>>& rows);

}  // namespace dermap
