// verify, result by result: what cannot be worked out again since runs have changed, lost their frames or are not in
// the store, and dynamic models, which rest on several runs.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/bench/reporting/verified_store.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("verified by hand: models of a run that has changed, or whose frames are gone, judge nothing again") {
  VerifiedStore made;
  for (int i = 0; i < 3; ++i) (void)made.add(film_inner_loops());
  made.judge(made.fitted(1), {2, 3});
  made.prune(3);
  CHECK(made.verified(3) == VerifiedLines{"1 of 1, verdicts, 4: left"});
  made.change("UPDATE frames SET status = 9 WHERE frame = (SELECT min(frame) FROM frames)");  // of run 1
  CHECK(made.verified(2) == VerifiedLines{"1 of 1, verdicts, 4: differs"});
  CHECK_THAT(made.results(2)[0].difference, Catch::Contains("run 1,") && Catch::Contains("frame 1 "));
  CHECK_FALSE(made.results(2)[0].recomputed);
  const bench::RunVerification own = bench::verify_run(made.store, 1);
  CHECK_FALSE(own.content.holds());
  CHECK(own.results.empty());
  CHECK(own.first_difference == own.content.difference);
}

TEST_CASE("verified by hand: without its frames a run's fits are not made again, and say since when") {
  VerifiedStore made;
  for (int i = 0; i < 2; ++i) (void)made.add(film_inner_loops());
  made.judge(made.fitted(1), {2});
  made.prune(1);
  CHECK(made.verified(1) == VerifiedLines{"1 of 1, elam, 0: left"});
  CHECK(made.verified(2) == VerifiedLines{"1 of 1, verdicts, 4: left"});
  for (const std::int64_t run : {1, 2})
    CHECK_THAT(made.results(run)[0].compared, Catch::Contains("run 1,") && Catch::Contains("2026-04-01T00:00:00Z"));
}

TEST_CASE("verified by hand: a seal that is broken beside results that hold is the first difference") {
  VerifiedStore made;
  (void)made.add(film_inner_loops());
  (void)made.fitted(1);
  made.store.add_report({1, "1-a", "h", "K. Lee", "2026-03-02T00:00:00Z", "", ""});
  made.change("UPDATE reports SET approved_by = 'B'");
  const bench::RunVerification verified = bench::verify_run(made.store, 1);
  REQUIRE(verified.beside.size() == 1);
  CHECK(verified.first_difference == verified.beside[0]);
}

TEST_CASE("verified by hand: a dynamic model rests on the runs of its lag and creep, known by their content") {
  VerifiedStore made;
  for (int i = 0; i < 3; ++i) (void)made.add(film_inner_loops());
  const analysis::SensorModel alone = [&] {
    analysis::Runs runs(made.store);
    return bench::fit_run_dynamic(made.store, runs, 1);
  }();
  CHECK(made.verified(1) == VerifiedLines{"1 of 1, dynamic, 3: holds"});
  const auto verified_with = [&](std::int64_t run, const std::string& content, bool creep) {
    analysis::SensorModel with = alone;
    analysis::SensorDynamics::Source& source = creep ? with.dynamics->creep : with.dynamics->rate;
    source.run = run;
    source.content_sha256 = content;
    const std::int64_t fit = bench::keep_fit(made.store, with);
    for (const bench::VerifiedResult& result : made.results(1))
      if (result.fit == fit) return result;
    return bench::VerifiedResult();
  };
  made.prune(3);
  const std::string none = std::string(64, '0'), third = made.store.run(3).content_sha256;
  struct Row {
    std::int64_t run;
    std::string content;
    bool creep;
    std::vector<std::string> told;
  };
  for (const Row& row : {Row{77, none, false, {"lag", "run 77", "000000000000"}},
                         Row{78, none, true, {"creep", "run 78", "000000000000"}},
                         Row{77, third, false, {"lag", "run 3"}}, Row{3, "", true, {"creep", "run 3"}}}) {
    const bench::VerifiedResult result = verified_with(row.run, row.content, row.creep);
    INFO(result.compared);
    CHECK((result.what == "dynamic" && !result.recomputed && result.difference.empty()));
    for (const std::string& told : row.told) CHECK(result.compared.find(told) != std::string::npos);
  }
  // Made with one of the two alone, as no program does: made again without either.
  CHECK(verified_with(2, made.store.run(2).content_sha256, false).recomputed);
  made.change("UPDATE frames SET status = 9 WHERE frame = (SELECT max(frame) FROM frames)");  // of run 2
  CHECK_THAT(verified_with(2, made.store.run(2).content_sha256, true).difference,
             Catch::Contains("run 2,") && Catch::EndsWith("[TB-ANALYSIS-FRAME]"));
}

TEST_CASE("verified by hand: a dynamic document without its sources, and models of an imported table") {
  VerifiedStore made;
  (void)made.add(film_inner_loops());
  analysis::FitOptions options;
  options.model = "monotone";
  db::FitRecord record;
  record.run = 1;
  record.model = "dynamic";
  record.document = analysis::to_line(analysis::fit_array(analysis::load_dataset(made.store, 1), options));
  (void)made.store.add_fit(record);
  CHECK(made.verified(1) == VerifiedLines{"1 of 1, dynamic, 0: left"});
  FilmRun table = film_inner_loops();
  table.origin = "imported";
  record.run = made.add(table);
  record.model = "monotone";
  (void)made.store.add_fit(record);
  CHECK(made.verified(2) == VerifiedLines{"2 of 2, monotone, 0: left"});
}
