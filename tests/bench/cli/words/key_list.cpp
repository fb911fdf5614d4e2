// Every key has its meaning, and every meaning its key; manual pages of section 5 are made of both.
#include "bench/cli/words/key_list.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <stdexcept>
#include <string>

#include "bench/cli/words/key_manual.h"
#include "bench/common/error.h"

using namespace tactbench::bench;

TEST_CASE("each key of each file has a meaning of its own words, in one plain line") {
  std::size_t count = 0;
  for (const FileKind& kind : file_kinds()) {
    INFO(kind.title);
    for (const KnownKey& key : known_keys(kind)) {
      INFO(key.use.key << ": " << key.meaning);
      CHECK(key.meaning.size() > 8);
      CHECK(key.meaning.find('\n') == std::string::npos);
      CHECK((!key.meaning.ends_with('.') || key.meaning.ends_with("...")));
      ++count;
    }
  }
  CHECK(count > 350);
}

TEST_CASE("a key without a meaning is refused, and so is a meaning without a key") {
  for (FileKind kind : file_kinds()) {
    INFO(kind.title);
    CHECK_NOTHROW(check_meanings(kind));
    const KeyMeaning first = kind.meanings.front();
    kind.meanings.push_back({"no.such_key", "Nothing"});
    CHECK_THROWS_WITH(check_meanings(kind), Catch::Contains("'no.such_key'"));
    kind.meanings.back() = first;
    CHECK_THROWS_AS(check_meanings(kind), std::logic_error);  // twice
    kind.meanings.pop_back();
    kind.meanings.erase(kind.meanings.begin());
    CHECK_THROWS_WITH(check_meanings(kind), Catch::Contains("no line for '" + std::string(first.key) + "'"));
  }
}

TEST_CASE("the table that a key stands in") {
  CHECK(table_of("limits.command_psi") == "limits");
  CHECK(table_of("scenario[].figures.NAME") == "scenario[].figures");
  CHECK(table_of("schema").empty());
}

TEST_CASE("a manual page of keys has each table with its keys, their facts and meanings") {
  const std::string page = key_manual("tactbench-limits", "0.1", "2026-01-31");
  const auto has = [&](const std::string& part) {
    INFO(part << "\n" << page);
    CHECK(page.find(part) != std::string::npos);
  };
  has(".TH TACTBENCH\\-LIMITS 5 \"2026-01-31\" \"tactbench 0.1\" \"File Formats\"\n.SH NAME\ntactbench\\-limits \\- "
      "limits.toml");
  has(".SS \"[[mpe]]\"\n.TP\n\\fBspan_psi\\fR (");
  has(".TP\n\\fBunfit_taxels\\fR (number, required)\nLargest number of dead, stuck, saturated or not modelled "
      "taxels.\n");
  has(".TP\n\\fBtaxels_percent\\fR (number, %, 1 to 100, default 95)\n");
  has("\\fBtactbench\\-bench\\fR(5)");
  const std::string suite = key_manual("tactbench-nightly", "0.1", "2026-01-31");
  CHECK(suite.find(".SS \"[scenario.taxels]\"\n.TP\n\\fBNAME\\fR (") != std::string::npos);
  CHECK(suite.find(".SS \"At the top of the file\"\n") != std::string::npos);
  CHECK_THROWS_AS(key_manual("tactbench-what", "0.1", "2026-01-31"), Error);
}
