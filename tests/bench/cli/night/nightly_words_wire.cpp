// nightly: what it prints, tells and keeps of a small night, scenario by scenario; and one that cannot be started.
#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "db/run_store.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using Told = nlohmann::ordered_json;

namespace {

// The first is green after 60 frames, the second red at once, the third as long as it is given.
struct SmallNight {
  SmallNight() {
    write_file(folder.path("s.toml"),
               "schema = 1\nname = \"small\"\n"
               "[[scenario]]\nname = \"whole\"\nabout = \"nothing is wrong\"\nrecipes = [\"equilibration\"]\n"
               "fits = false\n[scenario.figures]\nframes = [60, 60.5]\n"
               "[[scenario]]\nname = \"misspelt\"\nabout = \"no such recipe\"\nrecipes = [\"no-such\"]\n");
  }
  Finished night(std::vector<std::string> more) const {
    more.insert(more.begin(), {"nightly", "./s.toml"});
    return call(folder, more);
  }
  [[nodiscard]] bool exists(const std::string& name) const { return std::filesystem::exists(folder.path(name)); }
  TemporaryFolder folder;
};

// Without the seconds that a scenario took.
std::string night_without_seconds(std::string text) {
  for (std::size_t at = 0; (at = text.find(" s  ", at)) != std::string::npos; at += 3) {
    const std::size_t from = text.rfind("  ", at) + 2;
    text.replace(from, at - from, "#");
    at = from;
  }
  return text;
}

}  // namespace

TEST_CASE("nightly: its page, a line a scenario meanwhile, and no store that stays") {
  const SmallNight of;
  const Finished both = of.night({"--jobs", "1", "--junit", "night.xml", "--html", "night.html"});
  CHECK(both.code == 1);
  CHECK(both.err == "1 of 2\n2 of 2\n");
  const std::string printed = both.out;
  CHECK_THAT(printed, Catch::StartsWith("SIMULATED DATA. small: 2 scenarios\ngreen whole    ") &&
                          Catch::Contains("  nothing is wrong\nRED   misspelt ") &&
                          Catch::Contains("  no such recipe\n        its process ended with exit code 2 and left no "
                                          "result\n        error: there is no file 'no-such', and no shipped ") &&
                          Catch::EndsWith("\n1 green, 1 red, 0 not run\n"));
  CHECK_THAT(read_file(of.folder.path("night.xml")),
             Catch::Contains("tests=\"2\" failures=\"1\" errors=\"0\"") && Catch::Contains("name=\"misspelt\""));
  CHECK_THAT(read_file(of.folder.path("night.html")), Catch::Contains("2 scenarios, 1 red, 0 not run."));
  for (const char* name : {"whole.db", "misspelt.db", "whole.log"}) CHECK_FALSE(of.exists(name));
  const Finished quiet = of.night({"--only", "whole", "-q"});
  CHECK(quiet.code == 0);
  CHECK(quiet.err.empty());
  CHECK(night_without_seconds(quiet.out) ==
        night_without_seconds(
            "SIMULATED DATA. small: 1 scenario\ngreen whole                           0.3 s  nothing is "
            "wrong\n1 green, 0 red, 0 not run\n"));
  const Finished told = of.night({"--only", "whole", "--json"});
  CHECK(told.err.empty());
  const Told document = Told::parse(told.out);
  CHECK(document.at("schema") == "tactbench.nightly");
  CHECK(document.at("suite") == "small");
  CHECK(document.at("red") == 0);
  CHECK(document.at("scenarios").size() == 1);
}

TEST_CASE("nightly: kept with --db it is compared and has its words, as one part it waits for the others") {
  const SmallNight of;
  const auto last_line_but_one = [](const std::string& out) { return out.substr(out.find("green whole")); };
  const Finished first = of.night({"--only", "whole", "--db", "n.db", "--junit", "night.xml", "--html", "night.html"});
  CHECK(first.code == 0);
  CHECK_THAT(last_line_but_one(first.out), Catch::Contains(" s  nothing is wrong; first run with this seed\n"));
  const Finished second = of.night({"--only", "whole", "--db", "n.db", "--stores", "kept"});
  CHECK_THAT(last_line_but_one(second.out), Catch::Contains(" s  nothing is wrong; same frames as run 1\n"));
  CHECK((of.exists("kept/whole.db") && of.exists("kept/whole.log")));
  CHECK_FALSE(of.exists("whole.db"));
  const db::RunStore store = db::RunStore::open_read_only(of.folder.path("n.db"));
  CHECK(store.runs().size() == 2);
  const std::vector<db::NightRecord> nights = store.nights();
  REQUIRE(nights.size() == 2);
  CHECK(nights[1].suite == "small");
  CHECK(nights[1].shard == 1);
  CHECK(nights[1].shards == 1);
  const Finished part = of.night({"--shard", "1/2", "--db", "p.db"});
  CHECK_THAT(part.out, Catch::StartsWith("SIMULATED DATA. small: 1 scenario, part 1/2 of 2\ngreen whole ") &&
                           Catch::Contains(" s  nothing is wrong\n"));
}

TEST_CASE("nightly: the parts of a night are put together, printed as one and counted") {
  const SmallNight of;
  CHECK(of.night({"--shard", "1/2", "--db", "p1.db", "-q"}).code == 0);
  CHECK(of.night({"--shard", "2/2", "--db", "p2.db", "-q"}).code == 1);
  const auto merge = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"runs", "merge", "p1.db", "p2.db", "--db", "all.db"};
    words.insert(words.end(), more.begin(), more.end());
    return call(of.folder, words);
  };
  const Finished merged = merge({"--html", "night.html", "--junit", "night.xml"});
  CHECK(merged.code == 1);
  CHECK_THAT(merged.out, Catch::StartsWith("SIMULATED DATA. night of 20") &&
                             Catch::Contains("Z, small: 2 scenarios\ngreen whole ") &&
                             Catch::Contains("\nRED   misspelt ") &&
                             Catch::EndsWith("\n1 green, 1 red, 0 not run\nall.db: 1 run taken from 2 stores, 1 "
                                             "night\n"));
  CHECK_THAT(read_file(of.folder.path("night.html")), Catch::Contains("2 scenarios, 1 red, 0 not run."));
  CHECK_THAT(read_file(of.folder.path("night.xml")), Catch::Contains("failures=\"1\""));
  const Finished again = merge({});
  CHECK(again.code == 1);
  CHECK(again.out == "all.db: 0 runs taken from 2 stores; 1 there already\n");
}

TEST_CASE("nightly: files that cannot be written end it before a scenario begins") {
  const SmallNight of;
  write_file(of.folder.path("blocked"), "no folder");
  for (const char* file : {"--junit", "--metrics", "--html"}) {
    const Finished refused = of.night({"--only", "whole", "--stores", "kept", file, "blocked/file"});
    INFO(file);
    CHECK(refused.code == 2);
    CHECK(refused.out.empty());
    CHECK_FALSE(of.exists("kept/whole.db"));
  }
}

TEST_CASE("nightly: the lists say after each scenario how far the night is") {
  const SmallNight of;
  std::string suite = read_file(of.folder.path("s.toml"));
  suite +=
      "[[scenario]]\nname = \"endless\"\nabout = \"ended by a signal\"\nrecipes = [\"./long.toml\"]\nfits = "
      "false\n";
  write_file(of.folder.path("long.toml"),
             "schema = 1\nname = \"long\"\nunit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 2\nrepeats = 1000\n");
  write_file(of.folder.path("s.toml"), suite);
  const std::string lists = of.folder.path("night.xml");
  const auto after_two = [&] {
    return std::filesystem::exists(lists) && read_file(lists).find("failures=\"1\"") != std::string::npos;
  };
  const Finished ended = run_program(program_path(), {"nightly", "./s.toml", "--jobs", "1", "--junit", "night.xml"},
                                     of.folder.path(), {SIGTERM, after_two});
  CHECK(ended.code == 143);
  CHECK_THAT(ended.err, Catch::StartsWith("1 of 3\n2 of 3\n") && Catch::Contains("[TB-NIGHTLY-STOPPED]"));
}

TEST_CASE("nightly: one scenario in a process that a night started writes its result, and prints nothing") {
  const SmallNight of;
  const Finished one = of.night({"--only", "whole", "--db", "one.db", "--result", "r.json"});
  CHECK(one.code == 0);
  CHECK(one.out.empty());
  const Told result = Told::parse(read_file(of.folder.path("r.json")));
  CHECK(result.at("name") == "whole");
  CHECK(result.at("figures").at("frames") == 60.0);
  CHECK(db::RunStore::open_read_only(of.folder.path("one.db")).runs().size() == 1);
}

TEST_CASE("nightly: a scenario whose process cannot be started ends the night and is named") {
  const SmallNight of;
  // An environment that the night's own process can be started with, and none whose words are longer.
  write_file(of.folder.path("full.sh"),
             "ulimit -s 2048\n"
             "A=$(printf %110000s)\nn=90000\n"
             "while [ $n -gt 70000 ]; do\n"
             "  E=$(printf %${n}s)\n"
             "  (A=$A B=$A C=$A D=$A E=$E exec \"$1\" nightly ./s.toml --only whole) >out 2>err\n"
             "  code=$?\n"
             "  [ $code -ne 126 ] && exit $code\n"
             "  n=$((n-64))\n"
             "done\n");
  const Finished full = run_program("/usr/bin/env", {"-i", "/bin/sh", "full.sh", program_path()}, of.folder.path());
  CHECK(full.code == 70);
  CHECK_THAT(read_file(of.folder.path("err")),
             Catch::StartsWith("error: scenario whole could not be started: Argument list too long "
                               "[TB-NIGHTLY-SPAWN]\n  at: /") &&
                 Catch::EndsWith("\n  try: check the limits of processes and memory\n"));
}
