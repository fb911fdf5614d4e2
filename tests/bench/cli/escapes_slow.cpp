// Escape sequences in arguments, files and stores: none reaches a terminal, whichever verb prints it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "db/sqlite.h"
#include "tests/bench/cli/check_refusal.h"
#include "tests/support/paths.h"

using namespace tactbench::tests;
using tactbench::db::sqlite::Access;
using tactbench::db::sqlite::Connection;

namespace {

// Colour, window title, bell, return, backspace, delete, the C1 form of ESC [, a change of direction.
const std::string kEvil = "x\x1b[31m\x1b]0;t\x07\r\b\x7f\u009b2J\u202ey";

bool harmless(const std::string& text) {
  const bool plain = std::all_of(text.begin(), text.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return (byte >= 0x20 && byte != 0x7F) || c == '\n' || c == '\t';
  });
  return plain && text.find("\u009b") == std::string::npos && text.find("\u202e") == std::string::npos &&
         text.find('\xff') == std::string::npos;
}

class Terminal {
 public:
  Finished run(const std::vector<std::string>& words) {
    Finished finished = run_program(program_path(), words, folder.path());
    std::string line;
    for (const std::string& word : words) line += word + " ";
    INFO(line << "\n" << finished.out << finished.err);
    CHECK(harmless(finished.out));
    CHECK(harmless(finished.err));
    return finished;
  }
  const TemporaryFolder folder;
};

}  // namespace

TEST_CASE("escape sequences in arguments and stored texts are printed visibly, not sent to the terminal") {
  Terminal terminal;
  REQUIRE(terminal.run({"init"}).code == 0);
  write_file(terminal.folder.path("small.toml"),
             "schema = 1\nname = \"n\\u001b[2Jm\"\ntitle = \"t\\u009b\\u202e\"\nunit = \"psi\"\n"
             "turning_points = [0, 60, 20, 60, 0]\nstep = 20\nrepeats = 1\ndwell_s = 1.0\n");
  const std::string& evil = kEvil;
  CHECK(terminal.run({"sensors", "add", evil + "\xff", "--type", "sensor.toml"}).code == 2);  // a stray byte: no text
  CHECK(terminal.run({"sensors", "add", evil, "--type", "sensor.toml", "--note", evil}).code == 0);
  CHECK(terminal.run({"plan", "small.toml"}).code == 0);
  const std::vector<std::string> set = {"--set", "bench.location=\"a\\u001b[31m\"", "--set",
                                        "reference.serial=\"r\\u001b]0;t\\u0007\""};
  REQUIRE(terminal
              .run(joined_words({"run", "small.toml", "--bench", "bench.toml", "--sensor", evil, "--operator", evil,
                                 "--purpose", evil},
                                set))
              .code == 0);
  CHECK_THAT(terminal.run(joined_words({"devices", "check", "--bench", "bench.toml"}, set)).out,
             Catch::Contains("r\\x1b]0;t\\x07"));
  CHECK_THAT(terminal.run(joined_words({"config", "--origin", "--bench", "bench.toml"}, set)).out,
             Catch::Contains("a\\x1b[31m"));
  CHECK(terminal.run({"runs", "note", "1", evil}).code == 0);
  CHECK(terminal.run({"runs", "void", "1", "--reason", evil, "--by", evil}).code == 0);
  Connection(terminal.folder.path("runs.db"), Access::kReadWrite)
      .execute("UPDATE events SET detail = 'd' || char(27) || '[31m' || char(13), id = char(7)");
  const std::string list = terminal.run({"runs", "list", "--all"}).out;
  CHECK_THAT(list, Catch::Contains("x\\x1b[31m"));
  CHECK(std::count(list.begin(), list.end(), '\n') == 3);  // head, run, origin
  CHECK_THAT(terminal.run({"runs", "show", "1"}).out, Catch::Contains("\\x0d"));
  for (const char* verb : {"list", "show"}) {
    std::vector<std::string> sensors = {"sensors", verb};
    if (std::string(verb) == "show") sensors.push_back(evil);
    CHECK_THAT(terminal.run(sensors).out, Catch::Contains("x\\x1b[31m"));
    sensors.push_back("--json");
    CHECK_NOTHROW(nlohmann::json::parse(terminal.run(sensors).out));  // what stands for escapes there is JSON
  }
  CHECK_NOTHROW(nlohmann::json::parse(terminal.run({"runs", "show", "1", "--json"}).out));
  (void)terminal.run({"verify", "1"});
  (void)terminal.run({"fit", "1"});
  (void)terminal.run({"trend"});
}

TEST_CASE("escape sequences in refused input are printed visibly in the error") {
  Terminal terminal;
  const std::string& evil = kEvil;
  CHECK(terminal.run({"plan", evil}).code == 2);
  CHECK(terminal.run({evil}).code == 2);
  CHECK(terminal.run({"plan", "production", "--set", "recipe." + evil + "=1"}).code == 2);
  CHECK(terminal.run({"plan", "production", "--set", "bench." + evil + "=" + evil}).code == 2);
  CHECK(terminal.run({"run", "--" + evil}).code == 2);
  write_file(terminal.folder.path("bad.toml"), "schema = 1\n\"k\\u001b[31m\" = \"v\\u001b]0;t\\u0007\"\n");
  CHECK(terminal.run({"plan", "bad.toml"}).code == 2);
  CHECK(terminal.run({"nightly", "bad.toml", "--list"}).code == 2);
  write_file(terminal.folder.path("columns.csv"), evil + "," + evil + "b\n1,2\n");
  CHECK_THAT(well(terminal.run({"fit", "columns.csv"}), 2).err, Catch::Contains("\\x08"));  // behind its line end CR
  write_file(terminal.folder.path("wide.csv"), std::string(900'000, '\x1b') + ",b\n1,2\n");
  CHECK(terminal.run({"fit", "wide.csv"}).err.size() < 5000);
  write_file(terminal.folder.path("cell.csv"), "input,output\n1," + evil + "\n");
  CHECK(terminal.run({"fit", "cell.csv"}).code == 2);
  write_file(terminal.folder.path("suite.toml"),
             "schema = 1\nname = \"s\\u001b[31m\"\n[[scenario]]\nname = \"one\"\nabout = \"a\\u001b[31m\\u000d\"\n");
  CHECK_THAT(terminal.run({"nightly", "suite.toml", "--list"}).out, Catch::Contains("a\\x1b[31m\\x0d"));
}
