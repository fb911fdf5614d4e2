// By command: both specimens, both calibrations. The report's U against the truth: the plant's pressure, on sensors,
// seeds and reversals that nothing was chosen on. Each condition that U is stated for has to hold within 93 to 98 %.
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/benchmarks/study/coverage.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// Every use of one specimen, calibration and model but those left out, as in the figures' names after "coverage_".
struct StatedUses {
  std::string which;  // "paper_production_dynamic"
  std::vector<std::string> left_out;
};

// Each condition that U is stated for holds 93 to 98 %; `stated`: those for which U has to be stated for every sensor,
// else a report that is valid for nothing would pass.
void check_coverage(const bench::CoverageOptions& options, const std::vector<StatedUses>& stated) {
  const TemporaryFolder folder;
  const std::vector<bench::Figure> figures = bench::benchmark_coverage(options, folder.path());
  const auto find = [&](const std::string& name) { return std::ranges::find(figures, name, &bench::Figure::name); };
  for (const bench::Figure& figure : figures) {
    if (figure.unit != "%") continue;
    const double median_u = find(figure.name + "_median_u")->value;
    const double half_width = find(figure.name + "_half_width_95")->value;
    CAPTURE(figure.name, figure.value, median_u, half_width);
    CHECK(figure.value >= 93.0);
    CHECK(figure.value <= 98.0);
    CHECK(median_u <= 1.3 * half_width);
  }
  for (const StatedUses& uses : stated)
    for (const char* use : {"full_sweeps", "inner_branches", "random_reversals", "other_dwell", "held",
                            "other_temperature", "remounted", "month_later"}) {
      if (std::ranges::find(uses.left_out, use) != uses.left_out.end()) continue;
      const std::string condition = "coverage_" + uses.which + "_" + use;
      CAPTURE(condition);
      CHECK(find(condition) != figures.end());
      CHECK(find(condition + "_not_valid") == figures.end());
    }
}

}  // namespace

TEST_CASE("U holds 93 to 98 % of the readings of the harsh specimen under each condition that it is stated for") {
  bench::CoverageOptions options;
  options.sensor_seeds = {4201, 4202, 4203};
  options.specimens = {bench::SpecimenKind::kHarsh};
  // Of the others five runs of one or two of the three sensors leave U open by more than 6 %.
  check_coverage(options, {{"harsh_production_dynamic", {"other_temperature"}},
                           {"harsh_production_elam", {}},
                           {"harsh_table_1_dynamic", {"other_temperature"}},
                           {"harsh_table_1_elam", {"other_temperature", "random_reversals", "remounted"}}});
}

TEST_CASE("U holds 93 to 98 % of the readings of the paper's specimen under each condition that it is stated for") {
  bench::CoverageOptions options;
  options.sensor_seeds = {4101, 4102, 4103};
  options.specimens = {bench::SpecimenKind::kPaper};
  check_coverage(options, {{"paper_production_dynamic", {}},
                           {"paper_production_elam", {"held", "month_later"}},
                           {"paper_table_1_dynamic", {}},
                           {"paper_table_1_elam", {"held"}}});
}
