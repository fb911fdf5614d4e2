// verify, result by result: what cannot be worked out again since runs have changed, lost their frames or are not in
// the store, and dynamic models, which rest on several runs.
#include <fmt/format.h>

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
  CHECK(made.verified(3) ==
        VerifiedLines{"1 of 1, verdicts, 4: not recomputed: the frames of this run were removed | ", ""});
  made.change("UPDATE frames SET status = 9 WHERE frame = (SELECT min(frame) FROM frames)");  // of run 1
  const VerifiedLines changed = made.verified(2);
  REQUIRE(changed.size() == 2);
  CHECK_THAT(changed[0],
             Catch::StartsWith("1 of 1, verdicts, 4: not recomputed: the run of their models is not what was stored | "
                               "run 1, whose models they rest on: the run's row, a sequence, a device, or frame 1 "));
  CHECK_THAT(changed[1], Catch::StartsWith("verdicts: run 1, whose models they rest on: "));
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
  const std::string gone =
      "not recomputed: the frames of run 1, which it rests on, were removed on 2026-04-01T00:00:00Z | ";
  CHECK(made.verified(1) == VerifiedLines{"1 of 1, elam, 0: " + gone, ""});
  CHECK(made.verified(2) == VerifiedLines{"1 of 1, verdicts, 4: " + gone, ""});
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
  CHECK(made.verified(1) == VerifiedLines{"1 of 1, dynamic, 3, recomputed: " + by_film_build() + " | ", ""});
  const auto verified_with = [&](std::int64_t run, const std::string& content, bool creep) {
    analysis::SensorModel with = alone;
    analysis::SensorDynamics::Source& source = creep ? with.dynamics->creep : with.dynamics->rate;
    source.run = run;
    source.content_sha256 = content;
    const std::int64_t fit = bench::keep_fit(made.store, with);
    for (const std::string& line : made.verified(1))
      if (line.starts_with(fmt::format("{} of 1, dynamic", fit))) return line.substr(line.find(": ") + 2);
    return std::string("none");
  };
  const std::string none = std::string(64, '0');
  CHECK(verified_with(77, none, false) ==
        "not recomputed: this store does not have the run that its lag is from, run 77 where it was made, content "
        "000000000000 | ");
  CHECK(verified_with(78, none, true) ==
        "not recomputed: this store does not have the run that its creep is from, run 78 where it was made, content "
        "000000000000 | ");
  made.prune(3);
  CHECK(verified_with(77, made.store.run(3).content_sha256, false) ==
        "not recomputed: the frames of run 3, which its lag is from, were removed | ");
  CHECK(verified_with(3, "", true) == "not recomputed: the frames of run 3, which its creep is from, were removed | ");
  // Made with one of the two alone, as no program does: made again without either.
  CHECK_THAT(verified_with(2, made.store.run(2).content_sha256, false), Catch::StartsWith(by_film_build() + " | "));
  made.change("UPDATE frames SET status = 9 WHERE frame = (SELECT max(frame) FROM frames)");  // of run 2
  CHECK_THAT(verified_with(2, made.store.run(2).content_sha256, true),
             Catch::StartsWith(by_film_build() + " | cannot be recomputed: run 2, which it rests on: frame ") &&
                 Catch::EndsWith(" [TB-ANALYSIS-FRAME]"));
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
  CHECK(made.verified(1) ==
        VerifiedLines{"1 of 1, dynamic, 0: not recomputed: it does not record which runs its lag and creep are from | ",
                      ""});
  FilmRun table = film_inner_loops();
  table.origin = "imported";
  record.run = made.add(table);
  record.model = "monotone";
  (void)made.store.add_fit(record);
  CHECK(made.verified(2) ==
        VerifiedLines{"2 of 2, monotone, 0: not recomputed: it was made from an imported table | ", ""});
}
