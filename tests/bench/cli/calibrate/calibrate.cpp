// Refusals of calibrate and page before anything is opened.

#include <catch2/catch.hpp>

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/cli/calibrate/calibration.h"
#include "bench/cli/judgement_output.h"
#include "bench/cli/rig/page.h"
#include "tests/analysis/support/judged_figures.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

using WordsOfVerb = std::vector<std::string>;

struct RefusedWords {
  WordsOfVerb words;
  std::string id, place;
};

// Each of the words behind `begin`.
void check_each_refused(AddVerb add, const WordsOfVerb& begin, const std::vector<RefusedWords>& rows) {
  for (const RefusedWords& row : rows) {
    WordsOfVerb words = begin;
    words.insert(words.end(), row.words.begin(), row.words.end());
    const Finished finished = verb_here(add, words);
    CAPTURE(words);
    check_refusal(finished, 2, row.id);
    if (!row.place.empty()) CHECK_THAT(finished.err, Catch::Contains("\n  at: " + row.place));
    CHECK(finished.out.empty());
  }
}

}  // namespace

TEST_CASE("calibrate: rejects runs of another sensor, incomplete runs, and recipes that yield no model") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  {
    db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
    (void)store_example(store);  // run 1 of S-1
    const Begun failed = begin_example(store);
    store.end_run(failed.run, db::Outcome::kFailed, "x", db::SafeState::kVerified, kUtc);
    (void)begin_example(store);  // run 3 has not ended
  }
  const WordsOfVerb rest = {"--bench", "simulated.toml", "--operator", "me", "--db", path};
  const std::string limits = folder.path("between.toml");  // at levels between those of the recipe alone
  write_file(
      limits,
      "schema = 1\nname = \"between\"\nrule = \"simple\"\nmean_compensation_error_psi = 1\n"
      "worst_taxel_error_psi = 3\ndistance_of_mean_percent_fs = 1\nunfit_taxels = 0\n"
      "[[mismatch]]\npressure_psi = 10\nstd_percent_fs = 5\n[[mismatch]]\npressure_psi = 41\nstd_percent_fs = 5\n");
  const auto of_sensor = [&](const std::string& serial) { return joined({"calibrate", serial}, rest); };
  check_each_refused(bench::add_calibrate, of_sensor("S-1"),
                     {{{"--held-out", "1"}, "TB-USAGE", "--held-out"},
                      {{"--run", "2"}, "TB-USAGE", "--run"},
                      {{"--run", "1", "--held-out", "3"}, "TB-USAGE", "--held-out"},
                      {{"--recipe", "production", "--recipe", "ring"}, "TB-USAGE", "calibrate"},
                      {{"--held-out-recipe", "ring"}, "TB-USAGE", "calibrate"},
                      {{"--limits", limits, "--held-out-recipe", "loops"}, "TB-CALIBRATE-LEVELS", "--held-out-recipe"},
                      {{"--minutes", "5"}, "TB-CALIBRATE-MINUTES", "--minutes"},
                      {{"--run", "9"}, "TB-STORE-NOT-FOUND", ""}});
  check_each_refused(bench::add_calibrate, of_sensor("S-2"), {{{"--run", "1"}, "TB-USAGE", "--run"}});
  check_each_refused(bench::add_calibrate,
                     {"calibrate", "S-1", "--bench", "simulated.toml", "--operator", " ", "--db", path},
                     {{{}, "TB-USAGE", "--operator"}});
}

TEST_CASE(
    "calibrate: rejects an unregistered sensor on a hardware bench, and invalid files or keys, before measuring") {
  const TemporaryFolder folder;
  const std::string type = folder.path("type.toml"), lab = folder.path("none.toml");
  check_each_refused(
      bench::add_calibrate,
      {"calibrate", "NEW-1", "--bench", "paper-rig.example.toml", "--operator", "me", "--db", folder.path("runs.db")},
      {{{"--type", type}, "TB-SENSOR-UNKNOWN", "--type " + type + "\n"}});
  const auto said = [&](const WordsOfVerb& more) {
    const Finished finished = verb_here(
        bench::add_calibrate,
        joined({"calibrate", "S-1", "--bench", "simulated.toml", "--operator", "me", "--db", folder.path("runs.db")},
               more));
    CHECK(finished.code == (more.front() == "--run" && more.back() == "1" ? 5 : 2));
    CHECK(finished.out.empty());
    return finished.err;
  };
  CHECK_THAT(said({"--lab", lab}), Catch::Contains("[TB-FILE-MISSING]") && Catch::Contains(lab));
  for (const WordsOfVerb& more : std::vector<WordsOfVerb>{{"--meta", "nonesuch"},
                                                          {"--limits", "nonesuch.toml"},
                                                          {"--recipe", "nonesuch"},
                                                          {"--held-out-recipe", "nonesuch"},
                                                          {"--set", "recipe.nonesuch=1"},
                                                          {"--set", "bench.nonesuch=1"}})
    CHECK_THAT(said(more), Catch::Contains("nonesuch"));
  CHECK_THAT(said({"--run", "1"}), Catch::Contains("[TB-STORE-OPEN]"));
  CHECK_THAT(said({"--model", "nonesuch"}), Catch::StartsWith("parse: "));
  for (const char* option : {"--run", "--held-out"}) CHECK_THAT(said({option, "0"}), Catch::StartsWith("parse: "));
}

TEST_CASE("page: rejects a missing nightly page, an empty operator, and a non-loopback address without TLS") {
  const TemporaryFolder folder;
  const std::string night = folder.path("none.html");
  check_each_refused(bench::add_page, {"page"},
                     {{{"--night", night}, "TB-FILE-MISSING", night},
                      {{"--operator", " "}, "TB-USAGE", "--operator"},
                      {{"--listen", "0.0.0.0", "--tls", folder.path("none.pem"), folder.path("none.key")},
                       "TB-PAGE-CERTIFICATE",
                       ""}});
  for (const std::string address : {"0.0.0.0", "::", "192.168.1.7", "128.0.0.1"})
    check_each_refused(bench::add_page, {"page"},
                       {{{"--listen", address}, "TB-PAGE-OPEN", "--listen " + address + "\n"}});
}

// Output of `calibrate` besides the verdict: the bad taxels, and the command line to continue.

namespace {

using analysis::Criterion;
using analysis::JudgedFigure;
using analysis::Verdict;
using analysis::by_hand::judged_figure;
using analysis::by_hand::judgement_of;

const JudgedFigure kDead = judged_figure(2, Criterion::kUnfitTaxels, 1, 0, Verdict::kFail);
const JudgedFigure kWorst = judged_figure(2, Criterion::kWorstTaxelError, 3.4, 3, Verdict::kFail);

// 2 x 3 taxels, of which numbers 1 and 5 have no model; the worst one on the held-out run is number 3.
JudgedFit small_fit() {
  JudgedFit fit;
  fit.model.rows = 2;
  fit.model.columns = 3;
  for (int taxel = 0; taxel < 6; ++taxel) {
    analysis::ModelTaxel& own = fit.model.taxels.emplace_back();
    own.taxel = taxel;
    own.status = taxel == 1   ? analysis::TaxelStatus::kDead
                 : taxel == 5 ? analysis::TaxelStatus::kSaturated
                              : analysis::TaxelStatus::kFitted;
  }
  NamedEvaluation own, held_out;
  own.evaluation.worst_taxel = 0;
  held_out.evaluation.worst_taxel = 3;
  held_out.evaluation.worst_taxel_mean_error_psi = 3.4;
  fit.evaluations = {own, held_out};
  return fit;
}

}  // namespace

TEST_CASE("calibrate text: bad taxels are listed by row and column, the worst one only if its criterion fails") {
  CHECK(bad_taxels(small_fit(), judgement_of({kDead})).size() == 2);
  const std::vector<BadTaxel> bad = bad_taxels(small_fit(), judgement_of({kDead, kWorst}));
  REQUIRE(bad.size() == 3);
  CHECK((bad[0].row == 0 && bad[0].column == 1 && bad[0].why == "dead"));
  CHECK((bad[1].row == 1 && bad[1].column == 2 && bad[1].why == "saturated"));
  CHECK((bad[2].row == 1 && bad[2].column == 0));
  JudgedFit first = small_fit();
  first.evaluations.back().evaluation.worst_taxel = 0;
  const std::vector<BadTaxel> with_first = bad_taxels(first, judgement_of({kWorst}));
  REQUIRE(with_first.size() == 3);
  CHECK((with_first.back().row == 0 && with_first.back().column == 0));
  first.evaluations.back().evaluation.worst_taxel = -1;  // none
  CHECK(bad_taxels(first, judgement_of({kWorst})).size() == 2);
}

TEST_CASE("calibrate text: the command to continue omits values that come from the profile or the defaults") {
  const tests::TemporaryFolder folder;
  tests::write_file(folder.path("tactbench.toml"), "bench = \"rig.toml\"\noperator = \"me\"\n");
  Session session;
  session.profile = ProfileOptions(folder.path("tactbench.toml"));
  CalibrateOptions options;
  options.serial = "MY-1";
  options.bench = "rig.toml";
  options.operator_name = "me";
  CHECK(resume_command_line(options, session, 0, 0) == "tactbench calibrate MY-1");
  CHECK(resume_command_line(options, session, 3, 4) == "tactbench calibrate MY-1 --run 3 --held-out 4");
  options.operator_name = "A. O'Neil";
  options.recipes = {"descending", "ascending"};
  options.set = {"recipe.repeats=1"};
  options.seeds.seed = 7;
  session.db = "b.db";
  CHECK(resume_command_line(options, session, 3, 0) ==
        "tactbench calibrate MY-1 --db b.db --operator 'A. O'\\''Neil' --recipe descending --recipe ascending --set "
        "recipe.repeats=1 --seed 7 --run 3");
}
