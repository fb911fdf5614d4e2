// Where the identifiers of errors (TB-...) stand in the sources of all rooms.
#pragma once

#include <cctype>
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/paths.h"
#include "tests/support/process.h"

namespace tactbench::tests {

// An id as a literal: in which file, of which call or initializer it is an argument, and what stands before it there.
struct IdSite {
  std::string id, file, call, before;
};

inline bool is_name(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

// Where the bracket opens that `at` lies in, or the statement begins.
inline std::size_t opening_before(const std::string& text, std::size_t at) {
  int depth = 0;
  for (std::size_t i = at; i-- > 0;) {
    const char c = text[i];
    if (c == '"') {
      while (i > 0 && !(text[i - 1] == '"' && (i < 2 || text[i - 2] != '\\'))) --i;
      if (i > 0) --i;
    } else if (c == ')' || c == ']' || c == '}') {
      ++depth;
    } else if (c == '(' || c == '[' || c == '{') {
      if (depth-- == 0) return i;
    } else if (c == ';' && depth == 0) {
      return i;
    }
  }
  return 0;
}

inline std::vector<IdSite> sites_in(const std::string& text, const std::string& file) {
  std::vector<IdSite> sites;
  for (std::size_t at = 0; (at = text.find("\"TB-", at)) != std::string::npos; ++at) {
    std::size_t past = at + 1;
    while (is_name(text[past]) || text[past] == '-') ++past;
    const std::size_t open = opening_before(text, at);
    std::size_t end = open;
    while (end > 0 && std::isspace(static_cast<unsigned char>(text[end - 1])) != 0) --end;
    std::size_t begin = end;
    while (begin > 0 && is_name(text[begin - 1])) --begin;
    const std::string id = text.substr(at + 1, past - at - 1), call = text.substr(begin, end - begin);
    if (call == "starts_with") continue;  // the beginning of several
    sites.push_back({id, file, text[open] == ';' ? "" : call, text.substr(open + 1, at - open - 1)});
  }
  return sites;
}

inline const std::vector<IdSite>& all_sites() {
  static const std::vector<IdSite> sites = [] {
    std::vector<IdSite> found;
    for (const char* room : {"devices", "db", "sequences", "analysis", "bench"}) {
      for (const auto& entry : std::filesystem::recursive_directory_iterator(source_path(room))) {
        const std::string path = entry.path().string(), kind = entry.path().extension().string();
        if (kind != ".h" && kind != ".cpp") continue;
        const std::string below = path.substr(source_path("").size());
        for (IdSite& site : sites_in(read_file(path), below)) found.push_back(std::move(site));
      }
    }
    return found;
  }();
  return sites;
}

}  // namespace tactbench::tests
