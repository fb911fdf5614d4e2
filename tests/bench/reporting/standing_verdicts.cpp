// Which stored verdicts stand, which of them decides, and what is said of the others: on runs and fits stored by hand.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/reporting/judgement.h"
#include "tests/bench/reporting/judged_store.h"

using namespace tactbench;

namespace {

class StandingByHand : public tests::FilmStore {
 public:
  void add_runs(int count) {
    for (int i = 0; i < count; ++i) (void)add();
  }
  std::int64_t add_fit(std::int64_t run, const std::string& model = "elam") {
    db::FitRecord fit;
    fit.run = run;
    fit.model = model;
    return store.add_fit(fit);
  }
  void judge(std::int64_t run, std::int64_t fit, const std::string& limits, const std::vector<std::string>& words) {
    std::vector<db::VerdictRecord> rows;
    for (const std::string& word : words) {
      db::VerdictRecord row;
      row.criterion = to_string(static_cast<analysis::Criterion>(rows.size()));
      row.verdict = word;
      row.limits_toml = tests::film_limits_text(1.0, "simple", limits);
      row.limits_sha256 = db::sha256_hex(limits);
      rows.push_back(row);
    }
    store.replace_verdicts(run, fit, rows);
  }
  void declare_void(std::int64_t run) { store.void_run(run, "gauge closed", "me", "2026-03-02T00:00:00Z"); }
  // "run on models' run: verdict; "
  [[nodiscard]] std::string standing(std::int64_t run) const { return in_words(bench::standing(store, run).figures); }
  [[nodiscard]] std::string decided(std::int64_t run) const {
    return analysis::verdict_word(bench::standing(store, run).verdict);
  }
  static std::string in_words(const std::vector<analysis::JudgedFigure>& rows) {
    std::string text;
    for (const analysis::JudgedFigure& row : rows)
      text += fmt::format("{} on {}: {}; ", row.run, row.model_run, to_string(row.verdict));
    return text;
  }
  // The judgement on that run: its rows, worse ones, and whether it is none.
  [[nodiscard]] std::string judgement(std::int64_t run) const {
    const analysis::Judgement found = bench::judgement_on(store, run);
    return fmt::format("{}| {}| {}", in_words(found.figures), in_words(found.stored_worse),
                       found.not_judged ? "not judged" : "");
  }
};

}  // namespace

TEST_CASE("standing verdicts: those on a run, and those on other runs by its models") {
  StandingByHand made;
  made.add_runs(4);
  const std::int64_t fit = made.add_fit(1), other = made.add_fit(4);
  CHECK(made.standing(1).empty());
  CHECK(made.decided(1).empty());
  CHECK(made.judgement(1) == "| | ");
  made.judge(2, fit, "a", {"pass", "fail"});
  made.judge(3, fit, "a", {"pass"});
  made.judge(2, other, "a", {"pass"});
  CHECK(made.standing(1) == "2 on 1: pass; 2 on 1: fail; 3 on 1: pass; ");
  CHECK(made.standing(2) == "2 on 1: pass; 2 on 1: fail; 2 on 4: pass; ");
  CHECK(made.standing(3) == "3 on 1: pass; ");
  CHECK(made.standing(4) == "2 on 4: pass; ");
  CHECK(made.decided(1) == "fail");
  CHECK(made.decided(3) == "pass");
  CHECK(made.decided(4) == "pass");
}

TEST_CASE(
    "standing verdicts: figures on the models' own run are inconclusive, and count only without independent ones") {
  StandingByHand made;
  made.add_runs(3);
  const std::int64_t fit = made.add_fit(1);
  made.judge(1, fit, "a", {"pass", "fail"});
  CHECK(made.standing(1) == "1 on 1: inconclusive; 1 on 1: inconclusive; ");
  CHECK(made.decided(1) == "inconclusive");
  CHECK(made.judgement(1) == "1 on 1: inconclusive; 1 on 1: inconclusive; | | not judged");
  made.judge(2, fit, "a", {"pass"});
  CHECK(made.standing(1) == "2 on 1: pass; ");
  CHECK(made.standing(2) == "2 on 1: pass; ");
  CHECK(made.judgement(2) == "2 on 1: pass; | | ");
  // A verdict on run 1 by the models of another run is independent of its own models, and takes nothing away.
  const std::int64_t other = made.add_fit(3);
  made.judge(1, other, "a", {"fail"});
  CHECK(made.standing(1) == "1 on 3: fail; 2 on 1: pass; ");
}

TEST_CASE("standing verdicts: none on a void run, nor by a void run's models") {
  StandingByHand made;
  made.add_runs(4);
  const std::int64_t fit = made.add_fit(1), other = made.add_fit(4);
  made.judge(2, fit, "a", {"pass"});
  made.judge(3, fit, "a", {"fail"});
  made.judge(2, other, "a", {"fail"});
  made.declare_void(3);
  CHECK(made.standing(1) == "2 on 1: pass; ");
  CHECK(made.standing(3).empty());
  CHECK(made.judgement(3) == "| | not judged");
  made.declare_void(4);
  CHECK(made.standing(2) == "2 on 1: pass; ");
  CHECK(made.standing(4).empty());
  made.declare_void(1);
  CHECK(made.standing(1).empty());
  CHECK(made.standing(2).empty());
  CHECK(made.judgement(2) == "| | not judged");
}

TEST_CASE("standing verdicts: of several limits the newest decide, and a fail by any") {
  StandingByHand made;
  made.add_runs(2);
  const std::int64_t fit = made.add_fit(1);
  made.judge(2, fit, "a", {"inconclusive", "pass"});
  made.judge(2, fit, "b", {"pass"});
  CHECK(made.decided(2) == "pass");
  CHECK(made.judgement(2) == "2 on 1: pass; | 2 on 1: inconclusive; | ");
  made.judge(2, fit, "c", {"conditional pass", "pass"});
  CHECK(made.decided(2) == "conditional pass");
  made.judge(2, fit, "d", {"fail"});
  made.judge(2, fit, "e", {"pass"});
  CHECK(made.decided(2) == "fail");
  CHECK(made.judgement(2) == "2 on 1: pass; | 2 on 1: inconclusive; 2 on 1: conditional pass; 2 on 1: fail; | ");
}

TEST_CASE("standing verdicts: of two fits with one run the newest one's rows are the judgement") {
  StandingByHand made;
  made.add_runs(2);
  const std::int64_t first = made.add_fit(1, "gpi"), second = made.add_fit(1);
  made.judge(2, first, "a", {"fail"});
  made.judge(2, second, "a", {"pass", "pass"});
  CHECK(made.judgement(2) == "2 on 1: pass; 2 on 1: pass; | 2 on 1: fail; | ");
}

TEST_CASE("standing verdicts: a pass rests on means alone where no requirement is on single readings") {
  StandingByHand made;
  made.add_runs(2);
  const std::int64_t fit = made.add_fit(1);
  const auto alone = [&] { return bench::standing(made.store, 2).rests_on_means_alone; };
  CHECK_FALSE(alone());
  made.judge(2, fit, "a", {"pass", "conditional pass"});
  CHECK(alone());
  made.judge(2, fit, "b", {"pass", "pass", "pass", "pass", "pass", "pass"});  // the last one is mpe
  CHECK_FALSE(alone());
  made.judge(2, fit, "c", {"fail"});
  CHECK_FALSE(alone());
}
