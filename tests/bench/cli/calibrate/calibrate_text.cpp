// Output of `calibrate` besides the verdict: the bad taxels, and the command line to continue.
#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

#include "bench/cli/calibrate/calibration.h"
#include "bench/cli/judgement_output.h"
#include "tests/analysis/support/judged_figures.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;

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
