// SPDX-License-Identifier: Apache-2.0
// A small reader of HTML for tests.
#include "tests/fit/report/html_check.h"

#include <algorithm>
#include <cctype>
#include <set>

namespace dermap {
namespace {

struct Tag {
  std::string name;
  bool closing = false;
  bool self_closing = false;
  std::size_t begin = 0, end = 0;  // in the page, end behind the '>'
};

// The next tag at or behind `from`; quotes may hold '>'.
bool NextTag(const std::string& html, std::size_t from, Tag& tag) {
  const auto begin = html.find('<', from);
  if (begin == std::string::npos) return false;
  char quote = 0;
  std::size_t end = begin + 1;
  for (; end < html.size(); ++end) {
    const char c = html[end];
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      break;
    }
  }
  tag = {};
  tag.begin = begin;
  tag.end = std::min(html.size(), end + 1);
  std::size_t name = begin + 1;
  if (name < html.size() && html[name] == '/') {
    tag.closing = true;
    ++name;
  }
  while (name < end && (std::isalnum(static_cast<unsigned char>(html[name])) != 0 || html[name] == '!')) {
    tag.name += html[name++];
  }
  tag.self_closing = end > begin && html[end - 1] == '/';
  return true;
}

}  // namespace

std::vector<std::string> NestingFaults(const std::string& html) {
  static const std::set<std::string> kVoid{"!doctype", "meta", "img", "br", "link", "input", "hr"};
  std::vector<std::string> open, faults;
  std::size_t at = 0;
  for (Tag tag; NextTag(html, at, tag);) {
    at = tag.end;
    if ((tag.name == "style" || tag.name == "script") && !tag.closing)
      at = std::min(html.size(), html.find("</" + tag.name + ">", at));
    if (kVoid.count(tag.name) != 0 || tag.self_closing) continue;
    if (tag.name.empty()) {
      faults.push_back("a bare < at byte " + std::to_string(tag.begin));
    } else if (!tag.closing) {
      open.push_back(tag.name);
    } else if (open.empty() || open.back() != tag.name) {
      faults.push_back("</" + tag.name + "> at byte " + std::to_string(tag.begin) + " closes " +
                       (open.empty() ? "nothing" : open.back()));
    } else {
      open.pop_back();
    }
  }
  for (const std::string& name : open) faults.push_back("never closed: " + name);
  return faults;
}

std::vector<std::string> OutsideReferences(const std::string& html) {
  std::vector<std::string> found;
  for (const std::string attribute : {" src=", " href=", " srcset=", " action=", " data=", " poster="}) {
    for (auto at = html.find(attribute); at != std::string::npos; at = html.find(attribute, at + 1)) {
      const std::string value = html.substr(at + attribute.size(), 40);
      if (value.rfind("\"data:image/", 0) != 0 && value.rfind("\"#", 0) != 0)
        found.push_back(attribute + value);
    }
  }
  for (const std::string text :
       {"http://", "https://", "url(", "@import", "<link", "<iframe", "<object", "javascript:", "file://"}) {
    if (html.find(text) != std::string::npos) found.push_back(text);
  }
  return found;
}

std::string VisibleText(const std::string& html) {
  std::string text;
  std::size_t at = 0;
  for (Tag tag; NextTag(html, at, tag);) {
    text += html.substr(at, tag.begin - at);
    at = tag.end;
    if ((tag.name == "style" || tag.name == "script") && !tag.closing)
      at = std::min(html.size(), html.find("</" + tag.name + ">", at));
  }
  return text;
}

int CountOf(const std::string& html, const std::string& what) {
  int count = 0;
  for (auto at = html.find(what); at != std::string::npos; at = html.find(what, at + what.size())) ++count;
  return count;
}

}  // namespace dermap
