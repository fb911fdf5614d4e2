// runs export over a file that is there: one of its own kind is written anew, any other only with --replace.
#include <catch2/catch.hpp>
#include <map>
#include <string>

#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// Run 1 has frames and no series, run 2 a series, run 3 neither, run 4 one frame.
struct StoreOfKinds {
  StoreOfKinds() {
    for (int kind = 1; kind <= 4; ++kind) {
      const Begun begun = begin_example(store);
      for (int i = 0; i < (kind == 1 ? 2 : kind == 4 ? 1 : 0); ++i)
        store.append_frame(begun.run, example_frame(begun.branch, i));
      if (kind == 2) store.append_series(begun.run, {{0, 3, {0.5}, {2.5}}});
      store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
    }
  }
  Finished exported(const std::string& run, const std::string& format, const std::string& file) const {
    return verb_here(bench::add_runs,
                     {"runs", "export", run, "--db", path, "--format", format, "-o", folder.path(file)});
  }
  TemporaryFolder folder;
  std::string path = folder.path("runs.db");
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
};

struct KindOfExport {
  std::string run, format;
};

}  // namespace

TEST_CASE("export: a file of the same kind is written anew, one of another kind is left as it is") {
  const StoreOfKinds of;
  const std::map<std::string, KindOfExport> kinds = {
      {"frames", {"1", "csv"}}, {"series", {"2", "csv"}}, {"json", {"1", "json"}}};
  for (const auto& [there, first] : kinds)
    for (const auto& [then, second] : kinds) {
      INFO(then << " over " << there);
      const std::string file = there + "-" + then;
      REQUIRE(of.exported(first.run, first.format, file).code == 0);
      const std::string before = read_file(of.folder.path(file));
      const Finished again = of.exported(second.run, second.format, file);
      CHECK(again.code == (there == then ? 0 : 2));
      if (there == then) continue;
      CHECK_THAT(again.err, Catch::Contains("--replace"));
      CHECK(read_file(of.folder.path(file)) == before);
    }
}

TEST_CASE("export CSV: the names of the columns stand once, also for one frame and for none") {
  const StoreOfKinds of;
  const auto table = [&](const std::string& run) {
    REQUIRE(of.exported(run, "csv", "run-" + run).code == 0);
    const std::string text = read_file(of.folder.path("run-" + run));
    return text.substr(text.find("\nframe,") + 1);
  };
  CHECK_THAT(table("3"), Catch::StartsWith("frame,sequence,recipe,") && Catch::EndsWith(",flags,scan\n"));
  CHECK(table("3").find('\n') == table("3").size() - 1);
  for (const std::string run : {"1", "4"}) {
    const std::string text = table(run);
    CHECK(text.find("frame,sequence,recipe,", 1) == std::string::npos);
    CHECK_THAT(text, Catch::Contains(",flags,scan,counts_r0_c0,counts_r0_c1,counts_r1_c0,") &&
                         Catch::Contains("\n1,1,down,0,0,0,0,0,0,0.1,"));
  }
}

TEST_CASE(
    "export CSV: a line for each scan of a frame under force, with the wrench, its place and volts of each count") {
  const StoreOfKinds of;
  REQUIRE(of.exported("4", "csv", "one").code == 0);
  const std::string text = read_file(of.folder.path("one")),
                    frame =
                        "1,1,down,0,0,0,0,0,0,0.1,0.3333333333333333,6.1,0.1,0.2,-6.2,1.5,2.5,3.5,20.1,30.2,40.3,2000,"
                        "2.000000001,1.500000002,5000000000003,4,dwell,";
  CHECK(text.substr(text.find("volts_r2_c1\n") + 12) ==
        frame + "0,65535,65278,65021,64764,64507,64250,6553.5,6527.8,6502.1,6476.4,6450.7,6425\n" + frame +
            "1,63993,63736,63479,63222,62965,62708,6399.3,6373.6,6347.9,6322.2,6296.5,6270.8\n");
}
