// What the benchmarks print of what they measured: each figure and goal worked out by hand from round numbers.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/benchmarks/array.h"
#include "bench/benchmarks/compensation_error.h"
#include "bench/benchmarks/coverage.h"
#include "bench/benchmarks/fleet.h"
#include "bench/benchmarks/many_rigs.h"
#include "bench/benchmarks/page.h"
#include "bench/benchmarks/report.h"
#include "bench/benchmarks/sequence.h"
#include "bench/benchmarks/store.h"

using namespace tactbench::bench;

namespace {

using Printed = std::vector<std::string>;

Printed printed(const std::vector<Figure>& figures) {
  Printed lines;
  for (const Figure& figure : figures)
    lines.push_back(fmt::format("{} {:.7g} {}", figure.name, figure.value, figure.unit));
  return lines;
}

CoveredErrors covered_errors(double sum, double max, int samples, double covered) {
  CoveredErrors errors;
  errors.error.sum = sum;
  errors.error.max = max;
  errors.error.samples = samples;
  errors.covered = covered;
  return errors;
}

constexpr const char* kConditions[] = {
    "random_1", "random_2",  "dwell_0.2_s",         "dwell_10_s",       "random_to_54_psi",
    "same",     "remounted", "month_and_5_degrees", "remounted_random", "month_and_5_degrees_random"};

// Of each condition 40 samples: dynamic 0.2 psi in the mean, its largest 3; alone 0.4 and 5; ELAM 0.8 and 7.
ErrorsOfSpecimen errors_of_all_conditions() {
  ErrorsOfSpecimen errors;
  for (const char* condition : kConditions) {
    errors.dynamic[condition] = covered_errors(8.0, 3.0, 40, 38.0);
    errors.alone[condition] = covered_errors(16.0, 5.0, 40, 36.0);
    errors.elam[condition] = covered_errors(32.0, 7.0, 40, 30.0);
  }
  return errors;
}

}  // namespace

TEST_CASE("benchmark fleet: frames a second, shares of psql's copy and times a run from the best rounds") {
  CHECK(printed(figures_of(FleetTimes{3310.0, 0.5, 0.25, 0.002})) ==
        Printed{"fleet_push 6620 frames/s", "fleet_push_goal_at_least 5000 frames/s", "fleet_psql_copy 13240 frames/s",
                "fleet_push_over_copy 0.5 x", "fleet_push_over_copy_goal_at_least 0.5 x", "fleet_push_a_run 100 ms",
                "fleet_push_again_a_run 0.4 ms", "fleet_push_again_a_run_goal_at_most 1 ms"});
}

TEST_CASE("benchmark many-rigs: one characterization's share, and a million of them in hours and terabytes") {
  ManyRigsSpent spent;
  spent.rigs = 4;
  spent.carried_out_s = 14.4;
  spent.merged_s = 0.72;
  spent.pruning_s = 0.08;
  spent.kept_bytes = 8e6;
  spent.left_bytes = 40e3;
  spent.page_bytes = 12e3;
  CHECK(printed(figures_of(spent)) == Printed{"many-rigs_carried_out_of_one 3.6 core s",
                                              "many-rigs_merge_of_one 180 core ms", "many-rigs_prune_of_one 20 core ms",
                                              "many-rigs_store_of_one 2 MB", "many-rigs_store_of_one_pruned 10 kB",
                                              "many-rigs_page_of_one 3 kB", "many-rigs_million_carried_out 1000 core h",
                                              "many-rigs_million_merge 50 core h", "many-rigs_million_store 2 TB",
                                              "many-rigs_million_store_pruned 10 GB"});
}

TEST_CASE("benchmark page: what serving takes of a core, and delays of pictures") {
  PageServed served;
  served.took_s = 20.0;
  served.frames = 400.0;
  served.page_s = 0.1;
  served.bare_writes_s = 0.01;
  served.resident_mb = 12.5;
  for (int i = 1; i <= 101; ++i) served.delays_ms.push_back(102 - i);  // 1 to 101 ms
  FigureList figures("page");
  add_figures(figures, served);
  CHECK(printed(figures.take()) == Printed{"page_frames 20 1/s", "page_pictures 5.05 1/s", "page_core 0.5 %",
                                           "page_core_goal_at_most 1 %", "page_core_bare_writes 0.05 %",
                                           "page_resident 12.5 MB", "page_resident_goal_at_most 20 MB",
                                           "page_stored_to_viewer_median 51 ms", "page_stored_to_viewer_p95 96 ms",
                                           "page_stored_to_viewer_p95_goal_at_most 150 ms"});
}

TEST_CASE("benchmark page: a run beside viewers against one alone, median of the pairs and the last one's step") {
  FigureList figures("page");
  add_figures(figures, std::vector<PageRunPair>{{{2.0, 1.0, 100.0}, {4.0, 1.5, 100.0}},
                                                {{1.0, 2.0, 100.0}, {3.0, 2.0, 100.0}},
                                                {{8.0, 4.0, 200.0}, {8.0, 5.0, 100.0}}});
  CHECK(printed(figures.take()) == Printed{"page_step 40000 us", "page_step_with_viewers_wall 2 x",
                                           "page_step_with_viewers 1.25 x",
                                           "page_step_with_viewers_goal_at_most 1.02 x"});
}

TEST_CASE("benchmark store: microseconds a frame, of 1000 durable ones and of 3310 others") {
  CHECK(printed(figures_of(StoreTimes{0.5, 0.625, 0.0331, 0.0662, 0.00331, 0.01655, 0.01986})) ==
        Printed{"store_append_and_fdatasync 500 us/frame", "store_full 625 us/frame", "store_full_over_floor 1.25 x",
                "store_full_over_floor_goal_at_most 1.5 x", "store_bare_insert 10 us/frame", "store_normal 20 us/frame",
                "store_normal_over_bare 2 x", "store_normal_over_bare_goal_at_most 1.25 x",
                "store_bare_insert_groups_of_100 1 us/frame", "store_bare_read 5 us/frame", "store_read 6 us/frame",
                "store_read_over_bare 1.2 x", "store_read_over_bare_goal_at_most 1.3 x"});
}

TEST_CASE("benchmark sequence: microseconds a step, and the run against its two parts") {
  CHECK(printed(figures_of(SequenceTimes{200.0, 0.06, 0.01, 0.02})) ==
        Printed{"sequence_steps 200 1", "sequence_run 300 us/step", "sequence_bare_exchanges 50 us/step",
                "sequence_bare_store 100 us/step", "sequence_ratio 2 x"});
}

TEST_CASE("benchmark array: microseconds a frame of 1000, and its share of the wire") {
  CHECK(printed(figures_of(ArrayTimes{0.02, 0.05, 0.06, 240.0})) ==
        Printed{"array_plain_plays 20 us/frame", "array_specimen_moved_and_read 50 us/frame",
                "array_specimen_over_plain_plays 2.5 x", "array_counts_with_noise 60 us/frame",
                "array_frame_on_the_wire 240 us", "array_share_of_the_wire 0.25 1"});
}

TEST_CASE("benchmark report: megabytes, and milliseconds against writing alone") {
  CHECK(printed(figures_of(ReportTimes{2.5e6, 0.004, 0.03})) ==
        Printed{"report_size 2.5 MB", "report_write_alone 4 ms", "report_rendered_and_written 30 ms",
                "report_rendered_and_written_goal_at_most 49.33333 ms", "report_over_write_alone 7.5 x",
                "report_over_write_alone_goal_at_most 20 x"});
}

TEST_CASE("benchmark coverage: shares, medians and half-widths, and sensors of which U is not stated") {
  Coverages coverages;
  coverages["paper_a"] = {3.0, 0.0, {0.4, 0.1, 0.2, 0.3, 0.0}, {2.0, 1.0, 3.0}};
  coverages["paper_b"] = {0.0, 2.0, {}, {}};
  coverages["paper_c"] = {1.0, 1.0, {0.5}, {0.75}};
  CHECK(printed(figures_of(coverages)) ==
        Printed{"coverage_paper_a 60 %", "coverage_paper_a_median_u 2 psi", "coverage_paper_a_half_width_95 0.4 psi",
                "coverage_paper_b_not_valid 2 sensors", "coverage_paper_c_not_valid 1 sensors",
                "coverage_paper_c 100 %", "coverage_paper_c_median_u 0.75 psi",
                "coverage_paper_c_half_width_95 0.5 psi"});
}

TEST_CASE("benchmark compensation-error: all figures and goals of each condition, paper's specimen") {
  ErrorsOfSpecimen errors = errors_of_all_conditions();
  errors.others["random_1_gpi"] = covered_errors(10.0, 9.0, 20, 0.0).error;
  FigureList figures("compensation-error");
  add_figures(figures, errors, false);
  const std::string goals[] = {"0.19", "0.19", "0.22", "0.22", "", "", "0.52", "0.77", "", ""};
  Printed expected;
  for (std::size_t i = 0; i < 10; ++i) {
    const std::string name = std::string("compensation-error_") + kConditions[i];
    expected.push_back(name + " 0.2 psi");
    if (!goals[i].empty()) expected.push_back(name + "_goal_at_most " + goals[i] + " psi");
    expected.push_back(name + "_most 3 psi");
    if (i < 2) expected.push_back(name + "_most_goal_at_most 5 psi");
    for (const char* rest : {"_within_2_u 95 %", "_one_run 0.4 psi", "_one_run_most 5 psi", "_one_run_within_2_u 90 %",
                             "_elam_stream 0.8 psi", "_elam_stream_most 7 psi", "_elam_stream_within_2_u 75 %"})
      expected.push_back(name + rest);
  }
  expected.emplace_back("compensation-error_random_1_gpi 0.5 psi");
  CHECK(printed(figures.take()) == expected);
}

TEST_CASE("benchmark compensation-error: on the harsh specimen goals are shares of ELAM's stream") {
  const ErrorsOfSpecimen errors = errors_of_all_conditions();
  FigureList figures("compensation-error");
  add_figures(figures, errors, true);
  const std::string goals[] = {"0.5", "0.5", "0.5", "0.5", "", "", "1", "1", "1", "1"};
  Printed expected;
  for (std::size_t i = 0; i < 10; ++i) {
    const std::string name = std::string("compensation-error_harsh_") + kConditions[i];
    for (const char* one : {" 0.2 psi", "_most 3 psi", "_within_2_u 95 %", "_one_run 0.4 psi", "_one_run_most 5 psi",
                            "_one_run_within_2_u 90 %", "_elam_stream 0.8 psi", "_elam_stream_most 7 psi",
                            "_elam_stream_within_2_u 75 %", "_of_elam_stream 0.25 ratio"})
      expected.push_back(name + one);
    if (!goals[i].empty()) expected.push_back(name + "_of_elam_stream_goal_at_most " + goals[i] + " ratio");
  }
  CHECK(printed(figures.take()) == expected);
}

TEST_CASE("benchmark compensation-error: errors of several sensors add up") {
  CoveredErrors all = covered_errors(1.0, 0.5, 4, 3.0);
  all.add(covered_errors(2.0, 0.75, 6, 6.0));
  CHECK(all.error.mean() == Approx(0.3));
  CHECK(all.error.max == 0.75);
  CHECK(all.covered == 9.0);
}
