// Options that the environment or tactbench.toml may give: which source precedes, and what --help says.
#include "bench/cli/profile_options.h"

#include <CLI/CLI.hpp>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <string>
#include <vector>

#include "sequences/toml/strict_toml.h"
#include "tests/support/process.h"

using namespace tactbench;
using bench::ProfileKey;

namespace {

// A program with two verbs that take a bench; only `run` takes a recipe.
struct ProgramOfTwoVerbs {
  explicit ProgramOfTwoVerbs(const std::string& profile) {
    if (!profile.empty()) tests::write_file(folder.path("tactbench.toml"), profile);
    for (const char* name : {"run", "watch"})
      options.add(*app.add_subcommand(name), "--bench", ProfileKey::kBench, bench_file, "bench file")->required();
    options.add(*app.get_subcommand("run"), "recipe", ProfileKey::kRecipe, recipes, "recipes")->required();
    app.require_subcommand(1);
  }
  void parse(std::vector<std::string> words) {
    words.insert(words.begin(), "program");
    std::vector<const char*> argv;
    for (const std::string& word : words) argv.push_back(word.c_str());
    app.parse(static_cast<int>(argv.size()), argv.data());
  }
  tests::TemporaryFolder folder;
  bench::ProfileOptions options{folder.path("tactbench.toml")};
  CLI::App app{"of a test"};
  std::string bench_file;
  std::vector<std::string> recipes;
};

struct BenchVariable {
  explicit BenchVariable(const char* value) { setenv("TACTBENCH_BENCH", value, 1); }
  ~BenchVariable() { unsetenv("TACTBENCH_BENCH"); }
  BenchVariable(const BenchVariable&) = delete;
  BenchVariable& operator=(const BenchVariable&) = delete;
};

constexpr const char* kProfile = "bench = \"file.toml\"\nrecipe = \"descending, ascending\"\n";

}  // namespace

TEST_CASE("profile options: the command line outranks the environment, which outranks the file") {
  {
    ProgramOfTwoVerbs program(kProfile);
    program.parse({"run"});
    CHECK(program.bench_file == "file.toml");
    CHECK(program.recipes == std::vector<std::string>{"descending", "ascending"});
  }
  const BenchVariable variable("environment.toml");
  {
    ProgramOfTwoVerbs program(kProfile);
    program.parse({"run", "noise"});
    CHECK(program.bench_file == "environment.toml");
    CHECK(program.recipes == std::vector<std::string>{"noise"});  // not added to the file's
  }
  ProgramOfTwoVerbs program(kProfile);
  program.parse({"run", "--bench", "typed.toml"});
  CHECK(program.bench_file == "typed.toml");
}

TEST_CASE("profile options: help shows the given values without passwords") {
  ProgramOfTwoVerbs program("bench = \"host=db password=SECRET user=u\"\n");
  program.parse({"run", "x"});
  CHECK(program.bench_file == "host=db password=SECRET user=u");
  const std::string help = program.app.get_subcommand("run")->help();
  CHECK_THAT(help, Catch::Contains("host=db") && !Catch::Contains("SECRET"));
}

TEST_CASE("profile options: a value that no source gives is required") {
  ProgramOfTwoVerbs program("operator = \"me\"\n");
  CHECK_THROWS_AS(program.parse({"watch"}), CLI::RequiredError);
  ProgramOfTwoVerbs with_bench("bench = \"file.toml\"\n");
  with_bench.parse({"watch"});
  CHECK(with_bench.bench_file == "file.toml");
  ProgramOfTwoVerbs without_recipe("bench = \"file.toml\"\n");
  CHECK_THROWS_AS(without_recipe.parse({"run"}), CLI::RequiredError);
}

TEST_CASE("profile options: --help works with a broken profile file") {
  ProgramOfTwoVerbs program(kProfile);
  CHECK_THROWS_AS(program.parse({"watch", "--help"}), CLI::CallForHelp);
  ProgramOfTwoVerbs broken("bnech = \"x\"\n");
  CHECK_THROWS_AS(broken.parse({"watch", "--bench", "b.toml"}), sequences::FileError);
  ProgramOfTwoVerbs asked("bnech = \"x\"\n");
  asked.options.tolerate_unreadable();
  CHECK_THROWS_AS(asked.parse({"watch", "--help"}), CLI::CallForHelp);
}
