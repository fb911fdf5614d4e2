// Each key of docs/reference-keys.md stands in its manual page with the same facts, in the words of that page.
#include <catch2/catch.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "bench/cli/words/key_list.h"
#include "bench/cli/words/key_manual.h"
#include "bench/cli/words/roff.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

std::string replaced_all(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

// The cells of a row: "| a | b \| c |" has two.
std::vector<std::string> cells_of_row(const std::string& row) {
  std::vector<std::string> cells;
  for (std::size_t at = 2; at < row.size();) {
    std::size_t end = at;
    while (row.compare(end, 1, "|") != 0 || row[end - 1] == '\\') ++end;
    cells.push_back(replaced_all(row.substr(at, end - at - 1), "\\|", "|"));
    at = end + 2;
  }
  return cells;
}

struct RowOfKey {
  std::string key, meaning, type, unit, range, usual;
};

// The rows below "## TITLE", in their order.
std::vector<RowOfKey> rows_of_reference(const std::string& title) {
  const std::string page = tests::read_file(tests::source_path("docs/reference-keys.md"));
  std::istringstream lines(page.substr(page.find("\n## " + title + "\n") + 1));
  std::vector<RowOfKey> rows;
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line) && !line.starts_with("## ")) {
    if (!line.starts_with("| `")) continue;
    const std::vector<std::string> cells = cells_of_row(line);
    REQUIRE(cells.size() == 6);
    rows.push_back({replaced_all(cells[0], "`", ""), cells[1], cells[2], cells[3], cells[4], cells[5]});
  }
  return rows;
}

// "(number, psi, 0 to 60, default 5)"
std::string facts_in_words(const RowOfKey& row) {
  const bool word = row.type == "one of" && !row.range.empty();
  std::string facts = word ? "one of " + row.range : row.type;
  if (row.unit == "`unit`")
    facts += ", in the file's unit";
  else if (!row.unit.empty())
    facts += ", " + row.unit;
  if (!word && !row.range.empty()) facts += ", " + row.range;
  if (row.usual == "required")
    facts += ", required";
  else if (!row.usual.empty())
    facts += ", default " + replaced_all(row.usual.substr(1, row.usual.size() - 2), "` or `", " or ");
  return facts;
}

// "[[scenario]]" above the keys of "scenario[]".
std::string head_of_table(const std::string& table) {
  if (table.empty()) return "At the top of the file";
  const std::string name = replaced_all(table, "[]", "");
  return table.ends_with("[]") ? "[[" + name + "]]" : "[" + name + "]";
}

}  // namespace

TEST_CASE("manual pages of keys hold each row of the reference, below the head of its table") {
  for (const FileKind& kind : file_kinds()) {
    INFO(kind.title);
    const std::vector<RowOfKey> rows = rows_of_reference(kind.title);
    REQUIRE(rows.size() > 5);
    std::string keys = ".SH KEYS\n", table = "none yet";
    for (const RowOfKey& row : rows) {
      const std::size_t dot = row.key.rfind('.');
      const std::string own = dot == std::string::npos ? "" : row.key.substr(0, dot);
      if (own != table) keys += ".SS \"" + roff(head_of_table(own)) + "\"\n";
      table = own;
      std::string meaning = roff_paragraph(row.meaning);
      if (!meaning.ends_with(".")) meaning += ".";
      keys += ".TP\n\\fB" + roff(row.key.substr(dot == std::string::npos ? 0 : dot + 1)) + "\\fR (" +
              roff(facts_in_words(row)) + ")\n" + meaning + "\n";
    }
    const std::string page = key_manual(kind.page, "0.1", "2026-01-31");
    const std::size_t from = page.find(".SH KEYS\n");
    CHECK(page.substr(from, page.find(".SH SEE ALSO\n") - from) == keys);
    CHECK_THAT(page, Catch::StartsWith(".TH ") && Catch::Contains("\n.SH NAME\n" + roff(kind.page) + " \\- " +
                                                                  roff(kind.summary) + "\n.SH DESCRIPTION\n"));
  }
}
