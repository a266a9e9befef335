// SPDX-License-Identifier: Apache-2.0
// Pages of studies.
#include "studies/study_page.h"

#include "common/files/picture.h"
#include "fit/report_parts.h"

namespace dermap {
namespace {

constexpr const char* kSort = R"js(
document.querySelectorAll('.sortable th').forEach((head, column) => {
  head.style.cursor = 'pointer';
  head.addEventListener('click', () => {
    const body = head.closest('table').tBodies[0], up = head.dataset.up !== 'yes';
    const value = row => row.cells[column].textContent.trim();
    const order = (a, b) => {
      if (a === '' || b === '') return a === b ? 0 : a === '' ? 1 : -1;
      const x = Number(a), y = Number(b), down = up ? 1 : -1;
      return down * (isNaN(x) || isNaN(y) ? a.localeCompare(b) : x - y);
    };
    [...body.rows].sort((a, b) => order(value(a), value(b))).forEach(row => body.append(row));
    head.dataset.up = up ? 'yes' : 'no';
  });
});
)js";

}  // namespace

std::string StudyPage(const std::string& title, const std::string& sections) {
  return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><title>" +
         EscapeHtml(title) + "</title><style>" + std::string(ReportStyle()) +
         "svg.sheet { width: 100%; height: auto; }</style></head><body><main><h1>" + EscapeHtml(title) +
         "</h1>" + sections + "</main></body></html>\n";
}

std::string VerdictTable(const std::vector<Verdict>& verdicts) {
  std::vector<std::vector<std::string>> rows{{"claim", "worst", "limit", ""}};
  for (const Verdict& v : verdicts)
    rows.push_back(
        {EscapeHtml(v.claim), FormatValue(v.worst), FormatValue(v.limit), v.holds() ? "holds" : "FAILS"});
  return DrawTable(rows);
}

std::string SortableTable(const std::vector<std::vector<std::string>>& rows) {
  return "<div class=\"sortable\">" + DrawTable(rows) + "</div><script>" + kSort + "</script>";
}

}  // namespace dermap
