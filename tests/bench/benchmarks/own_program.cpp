// The benchmarks that call this program's verbs, with a script in its place: which words it gets, where, and what of
// its exit codes and files counts.
#include "bench/benchmarks/own_program.h"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/benchmarks/large_store.h"
#include "bench/benchmarks/many_rigs.h"
#include "tests/bench/benchmarks/counted_time.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// In a folder of its own, so that a path with a blank is met, too.
class ScriptInPlace {
 public:
  explicit ScriptInPlace(const std::string& then) {
    std::filesystem::create_directory(folder_.path("a b"));
    write_file(file(), "#!/bin/sh\necho \"$(basename \"$PWD\"): $*\" >> ../calls\n" + then + "\n");
    ::chmod(file().c_str(), 0700);
  }
  [[nodiscard]] std::string folder() const { return folder_.path("a b"); }
  [[nodiscard]] std::string file() const { return folder_.path("the script"); }
  [[nodiscard]] std::string calls() const { return read_file(folder_.path("calls")); }

 private:
  TemporaryFolder folder_;
};

}  // namespace

TEST_CASE("benchmarks of verbs: the program gets its words in its folder, and may end with 0, 1 or 6") {
  const ScriptInPlace script("echo \"it's said\"\nexit $2");
  const bench::OwnProgram program(script.folder(), script.file());
  for (const char* code : {"0", "1", "6"}) CHECK_NOTHROW(program.run({"it's a verb", code}));
  CHECK(script.calls() == "a b: it's a verb 0\na b: it's a verb 1\na b: it's a verb 6\n");
  for (const char* code : {"2", "5", "7"})
    CHECK_THROWS_WITH(program.run({"verb", code, "--x"}),
                      std::string("tactbench verb ") + code + " --x ended with " + code + ": it's said\n");
}

TEST_CASE("benchmarks of verbs: the best of the rounds counts, by wall clock") {
  const ScriptInPlace script("[ -e ../slept ] && exit 0\ntouch ../slept\nsleep 0.3");
  const bench::OwnProgram program(script.folder(), script.file());
  const double slow = program.best_seconds(1, {"a"});
  CHECK(slow >= 0.3);
  CHECK(program.best_seconds(3, {"b"}) > 0.0);
  CHECK(script.calls() == "a b: a\na b: b\na b: b\na b: b\n");
}

TEST_CASE("benchmarks of verbs: seconds of ended processes grow by what a process computed, not by what it waited") {
  const double before = bench::now_s(bench::By::kEnded);
  const ScriptInPlace script("i=0\nwhile [ $i -lt 30000 ]\ndo i=$((i + 1))\ndone");
  bench::OwnProgram(script.folder(), script.file()).run({});
  const double computed = bench::now_s(bench::By::kEnded) - before;
  CHECK(computed > 0.002);
  CHECK(computed < 20.0);
  const ScriptInPlace waiting("sleep 0.5");
  const double between = bench::now_s(bench::By::kEnded);
  bench::OwnProgram(waiting.folder(), waiting.file()).run({});
  CHECK(bench::now_s(bench::By::kEnded) - between < 0.4);
}

TEST_CASE("benchmark many-rigs: two parts of a night, their merging and pruning, and the sizes of what they left") {
  const ScriptInPlace script("case \"$*\" in *prune*) truncate -s 8000 all.db;; esac");
  write_file(script.folder() + "/all.db", std::string(80000, 'x'));
  write_file(script.folder() + "/all.html", std::string(24000, 'x'));
  std::map<std::string, double> figures;
  {
    const CountedTime time;
    for (const bench::Figure& figure : bench::benchmark_many_rigs(2, script.folder(), script.file()))
      CHECK(figures.emplace(figure.name, figure.value).second);
    CHECK(time.readings() == std::vector<bench::By>(8, bench::By::kEnded));
  }
  CHECK(script.calls() ==
        "a b: nightly ./rigs.toml -q --seeds 8 --shard 1/2 --db 1.db\n"
        "a b: nightly ./rigs.toml -q --seeds 8 --shard 2/2 --db 2.db\n"
        "a b: runs merge 1.db 2.db --db all.db --html all.html\n"
        "a b: db prune --keep 2999-01-01 --yes --shrink --db all.db\n");
  CHECK(read_file(script.folder() + "/rigs.toml") ==
        "schema = 1\nname = \"rigs\"\n[[scenario]]\nname = \"rig\"\nabout = \"one characterization\"\n"
        "recipes = [\"production\"]\n");
  // Of each of eight rigs.
  CHECK(figures.at("many-rigs_store_of_one") == Approx(0.01));
  CHECK(figures.at("many-rigs_store_of_one_pruned") == Approx(1.0));
  CHECK(figures.at("many-rigs_page_of_one") == Approx(3.0));
  // Both parts, then the merging, then the pruning: 2 + 4, 6 and 8 s.
  CHECK(figures.at("many-rigs_carried_out_of_one") == Approx(6.0 / 8));
  CHECK(figures.at("many-rigs_merge_of_one") == Approx(6000.0 / 8));
  CHECK(figures.at("many-rigs_prune_of_one") == Approx(8000.0 / 8));
}

TEST_CASE("benchmark large-store: each verb on stores of every size, and the sizes of their files") {
  const ScriptInPlace script("case \"$*\" in *show*) wc -c < ${5} > ../size_of_$5;; esac\nexit 6");
  {
    db::RunStore real = db::RunStore::open(script.folder() + "/real.db");
    for (int i = 0; i < 2; ++i) {
      const std::int64_t run = i == 0 ? begin_example(real).run : real.begin_run(example_run());
      real.end_run(run, db::Outcome::kCompleted, "done", db::SafeState::kVerified, kUtc);
    }
  }
  const std::vector<bench::Figure> figures = [&] {
    const CountedTime time;
    return bench::benchmark_large_store({3, 5}, 2, script.folder(), script.file());
  }();
  std::string expected =
      "a b: init\n"
      "a b: sensors add S-1 --type sensor.toml --db real.db\n";
  for (const char* seed : {"1", "2"})
    expected +=
        std::string("a b: run production --bench bench.toml --sensor S-1 --operator benchmark --yes -q --seed ") +
        seed + " --db real.db\n";
  expected += "a b: fit 1 --held-out 2 --limits limits.toml --db real.db\n";
  for (const char* count : {"3", "5"}) {
    const std::string real = std::string(count) == "3" ? "2" : "4", db = std::string(" --db ") + count + ".db\n";
    for (const std::string& verb :
         {"runs show " + real, std::string("runs list"), std::string("runs list --since 2026-01-31 --sensor B-1"),
          std::string("trend --subject bulk/7"), std::string("trend"), "report " + real + " -o report.html",
          "verify " + real, std::string("db check")})
      for (int round = 0; round < 2; ++round) expected += "a b: " + verb + db;
  }
  CHECK(script.calls() == expected);
  std::vector<std::string> names;
  for (const bench::Figure& figure : figures) {
    INFO(figure.name);
    CHECK(figure.value > 0.0);
    names.push_back(figure.name + " " + figure.unit);
  }
  std::vector<std::string> all;
  for (const char* count : {"3", "5"})
    for (const char* name : {"file", "open_and_show", "runs_list_all", "runs_list_20", "trend_of_a_subject",
                             "trend_of_all", "report", "verify", "db_check"})
      all.push_back(std::string("large-store_") + name + "_of_" + count +
                    (std::string(name) == "file" ? " MB" : " ms"));
  CHECK(names == all);
  ActsInOrder act;
  for (const std::size_t i : {std::size_t{0}, std::size_t{9}}) {
    const std::string count = i == 0 ? "3" : "5";
    CHECK(figures[i].value == Approx(1e-6 * std::stod(read_file(script.folder() + "/../size_of_" + count + ".db"))));
    CHECK_FALSE(std::filesystem::exists(script.folder() + "/" + count + ".db"));  // gone after its verbs
    for (std::size_t k = 1; k < 9; ++k) {  // the first of the two rounds is the best one
      CHECK(figures[i + k].value == Approx(1000.0 * act.next()));
      act.pass(1);
    }
  }
}
