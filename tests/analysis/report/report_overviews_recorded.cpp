// Every number on the pages that compare runs, in sums as they were when recorded.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "analysis/report/overview/overview.h"
#include "tests/analysis/report/numbers_on_pages.h"
#include "tests/analysis/report/whole_report.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::pages_in_numbers;

TEST_CASE("recorded: numbers of a comparison of two runs are those that were printed when recorded") {
  ReportInput second = whole_report(PressureUnit::kPsi);
  second.run.run = 44;
  second.evaluation.mean_error_psi = 0.625;
  second.behaviour.full_scale_v = 3.25;
  second.health.median_noise_v = 0.0016;
  check_parts(printed_on(render_comparison(whole_report(PressureUnit::kPsi), second)),
              {{"page", 124698.4712000, 1026, 547, 7}, {"data", 9346.0454906, 1015, 137, 6}});
  ReportInput bare = example::example_input();
  bare.fit = {};
  bare.evaluation = {};
  bare.verdicts.clear();
  check_parts(printed_on(render_comparison(bare, second)),
              {{"page", 128198.8492277, 1007, 543, 21}, {"data", 6911.3056921, 994, 97, 11}});
}

TEST_CASE("recorded: numbers of a page on seven sensors are those that were printed when recorded") {
  std::vector<ReportInput> runs;
  example::Noise noise;
  for (int i = 0; i < 7; ++i) {
    ReportInput& own = runs.emplace_back(example::example_input());
    own.run.run = 60 + i;
    own.run.sensor_serial = fmt::format("TA16-{:04d}", i);
    own.evaluation.mean_error_psi = i == 4 ? 3.0 : 0.5 + 0.05 * noise();
    own.evaluation.comp_distance = 0.02 + 0.002 * noise();
    own.behaviour.full_scale_v = 3.4 + 0.1 * noise();
    own.health.median_noise_v = 0.0008 + 0.0001 * noise();
    if (i == 2) own.verdicts.clear();
    if (i == 3)
      for (db::VerdictRecord& verdict : own.verdicts) verdict.verdict = "pass";
    if (i == 5) {
      own.fit = {};
      own.evaluation = {};
      own.verdicts.clear();
    }
    for (RawLoop& loop : own.behaviour.loops)
      for (double& v : loop.down_v) v *= 1.0 + 0.01 * i;
  }
  check_parts(printed_on(render_batch(runs)),
              {{"page", 158017.5512842, 1904, 615, 13}, {"data", 26283.4129250, 2624, 380, 19}});
}
