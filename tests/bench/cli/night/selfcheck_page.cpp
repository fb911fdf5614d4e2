// A record of selfcheck as people read it, of two checks, and the folder that it needs.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/cli/night/selfcheck.h"
#include "tests/bench/cli/verb_here.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("selfcheck: the program's facts in a few lines, each check with what was expected and found, and the sum") {
  const nlohmann::ordered_json line = {
      {"area", "store"}, {"checked", "sixty frames"}, {"expected", "60"}, {"found", "60"}, {"pass", true}};
  nlohmann::ordered_json failed = line;
  failed["area"] = "clock";
  failed["checked"] = "ticks";
  failed["expected"] = "rise";
  failed["found"] = "fall";
  failed["pass"] = false;
  nlohmann::ordered_json record = {{"date_utc", "2026-01-31T12:00:00Z"},
                                   {"program_version", "0.1.0"},
                                   {"git_commit", "0123abc"},
                                   {"modified", false},
                                   {"build", "Release, GNU"},
                                   {"identification_lanes", "avx2"},
                                   {"compensator_dispatch", "base"},
                                   {"shipped_files", "/share"},
                                   {"libraries", {{"sqlite", "3.40"}, {"fmt", "9.1"}}},
                                   {"checks", {line, failed}},
                                   {"failed", 1},
                                   {"seconds", 12.34},
                                   {"sha256", "ab12"}};
  const std::string rest =
      "; Release, GNU\nidentification on avx2, compensator on base\nshipped files: /share\nlibraries: sqlite 3.40 fmt "
      "9.1\n\npass  store: sixty frames\n      expected: 60\n      found:    60\nFAIL  clock: ticks\n      expected: "
      "rise\n      found:    fall\n\n2 checks, 1 failed, 12.3 s\nsha256 ab12\n";
  const std::string begin = "tactbench selfcheck, 2026-01-31T12:00:00Z\nversion 0.1.0, commit 0123abc";
  CHECK(bench::selfcheck_text(record) == begin + rest);
  record["modified"] = true;
  CHECK(bench::selfcheck_text(record) == begin + ", modified" + rest);
}

TEST_CASE("selfcheck: a folder that is not there, and a file of another kind, end it before anything is checked") {
  const TemporaryFolder folder;
  const std::string store = folder.path("none/runs.db"), other = folder.path("mine.txt");
  const Finished nowhere = verb_here(bench::add_selfcheck, {"selfcheck", "--db", store});
  CHECK(nowhere.code == 2);
  CHECK(nowhere.out.empty());
  CHECK_THAT(nowhere.err,
             Catch::StartsWith("error: cannot make the folder " + folder.path("none") + "/.tactbench-selfcheck-") &&
                 Catch::EndsWith(": No such file or directory [TB-FILE-WRITE]\n  at: --db " + store +
                                 "\n  try: name a store in a writable folder\n"));
  write_file(other, "mine\n");
  const Finished kept = verb_here(bench::add_selfcheck, {"selfcheck", "--db", store, "-o", other});
  CHECK(kept.code == 2);
  CHECK_THAT(kept.err, Catch::Contains("[TB-FILE-EXISTS]") && Catch::Contains("\n  at: " + other + "\n"));
  CHECK(read_file(other) == "mine\n");
  write_file(other, "tactbench selfcheck, 2026-01-31T12:00:00Z\n");
  CHECK_THAT(verb_here(bench::add_selfcheck, {"selfcheck", "--db", store, "-o", other}).err,
             Catch::Contains("[TB-FILE-WRITE]"));
}
