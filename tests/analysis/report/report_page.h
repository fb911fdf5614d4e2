// Parses a report's page for tests: tags, attributes, xmllint; and its data.
#pragma once

#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/analysis/report/report_example.h"

namespace tactbench::analysis {

inline std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++n;
  return n;
}

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

inline nlohmann::json report_json(const ReportInput& input) { return nlohmann::json::parse(render_report(input).json); }

// 0 when xmllint finds the page well-formed; -1 when there is no xmllint.
inline int xmllint(const std::string& page) {
  if (std::system("command -v xmllint >/dev/null 2>&1") != 0) return -1;
  const auto path =
      std::filesystem::temp_directory_path() / ("tactbench-report-" + std::to_string(::getpid()) + ".html");
  std::ofstream(path, std::ios::binary) << page;
  const int status = std::system(("xmllint --noout --nonet '" + path.string() + "'").c_str());
  std::filesystem::remove(path);
  return status;
}

inline void require_well_formed(const std::string& page) {
  const int status = xmllint(page);
  if (status < 0) {
    WARN("xmllint (package libxml2-utils) is not installed: well-formedness not checked");
    return;
  }
  CHECK(status == 0);
}

// The tags as a parser sees them: text holds no raw '<', the JSON none at all.
inline std::vector<std::string> tags_of(const std::string& page) {
  std::vector<std::string> out;
  for (std::size_t at = page.find('<'); at != std::string::npos; at = page.find('<', at + 1)) {
    out.push_back(page.substr(at + 1, page.find('>', at) - at - 1));
  }
  return out;
}

// name="value" pairs of a tag; the page writes double quotes only.
inline std::vector<std::pair<std::string, std::string>> attributes_of(const std::string& tag) {
  std::vector<std::pair<std::string, std::string>> out;
  std::size_t at = tag.find(' ');
  while (at != std::string::npos) {
    const std::size_t equals = tag.find("=\"", at);
    if (equals == std::string::npos) break;
    const std::size_t end = tag.find('"', equals + 2);
    if (end == std::string::npos) break;
    out.emplace_back(tag.substr(at + 1, equals - at - 1), tag.substr(equals + 2, end - equals - 2));
    at = tag.find(' ', end);
  }
  return out;
}

inline std::set<std::string> words_of(const std::string& words) {
  std::istringstream stream(words);
  return {std::istream_iterator<std::string>(stream), {}};
}

// Every figure and table has its title.
inline void require_titled(const std::string& page) {
  CHECK(count(page, "<svg ") == count(page, "<svg role=\"img\""));
  CHECK(count(page, "<svg ") == count(page, "</title>") - 1);
  CHECK(count(page, "<table") == count(page, "<caption>"));
}

// Nothing that loads or runs: only elements and attributes that the report is known to need.
inline void require_inert(const std::string& page) {
  CHECK(count(page, "<script") == 1);
  CHECK(count(page, "<script type=\"application/json\" id=\"report-data\">") == 1);
  CHECK(count(page, "</script") == 1);
  static const std::set<std::string> elements = words_of(
      "!DOCTYPE aside html head meta title style body header main footer nav ul li a h1 h2 h3 h4 p div span code br "
      "table tr thead tbody th td b figcaption figure svg g path text script caption");
  static const std::set<std::string> attributes = words_of(
      "lang charset http-equiv content name id class role scope colspan rowspan href aria-label tabindex viewBox width "
      "height fill stroke stroke-width stroke-linecap stroke-dasharray d transform x y text-anchor type style");
  for (const std::string& tag : tags_of(page)) {
    const std::size_t start = tag.front() == '/' ? 1 : 0;
    const std::string name = tag.substr(start, tag.find_first_of(" /", start) - start);
    if (!elements.contains(name)) FAIL_CHECK("element " << tag.substr(0, 100));
    for (const auto& [attribute, value] : attributes_of(tag)) {
      if (!attributes.contains(attribute)) FAIL_CHECK("attribute " << attribute << " in " << tag.substr(0, 100));
      if (attribute == "href" && value.front() != '#') FAIL_CHECK("link to " << value);
      if (value.find("url(") != std::string::npos) FAIL_CHECK("url in " << attribute);
    }
  }
  const std::string style = page.substr(page.find("<style>"), page.find("</style>") - page.find("<style>"));
  CHECK_FALSE(contains(style, "url("));
  CHECK_FALSE(contains(style, "@import"));
  CHECK(contains(page,
                 "http-equiv=\"Content-Security-Policy\" content=\"default-src &#39;none&#39;; "
                 "style-src &#39;unsafe-inline&#39;; img-src data:\""));
}

}  // namespace tactbench::analysis
