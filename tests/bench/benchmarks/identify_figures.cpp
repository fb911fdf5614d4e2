// `benchmark identify`: its figures worked out by hand from round numbers.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/benchmarks/identify.h"

using namespace tactbench::bench;

namespace {

using IdentifyLines = std::vector<std::string>;

IdentifyLines identify_lines(const IdentifyTimes& times) {
  IdentifyLines lines;
  for (const Figure& figure : figures_of(times))
    lines.push_back(fmt::format("{} {:.7g} {}", figure.name, figure.value, figure.unit));
  return lines;
}

IdentifyTimes round_times() {
  IdentifyTimes times;
  times.taxels = 200;
  times.plain_j = 0.0002;
  times.levels = {{"base", 0.008}, {"avx2", 0.002}};
  times.genetic = 0.5;
  times.exact = 0.001;
  times.genetic_j = {3.0, 1.0, 6.0};
  times.exact_j = {2.0, 1.0, 5.0};
  times.reading = 0.002;
  times.alone = 0.003;
  times.from_store = 0.006;
  times.one_thread = 0.012;
  times.two_threads = 0.008;
  times.growth = {{16, 256e-6}, {32, 2048e-6}, {64, 12288e-6}};
  times.models = {{"gpi", 0.04, 0.0004}, {"mpi", 0.02, 0.001}};
  times.few = 4;
  times.dynamic = 0.75;
  return times;
}

}  // namespace

TEST_CASE("benchmark identify: times a taxel, in units of one J, and ratios") {
  CHECK(identify_lines(round_times()) == IdentifyLines{"identify_plain_j 1 us",
                                                       "identify_elam_base 40 us/taxel",
                                                       "identify_elam_base_in_plain_j 40 x",
                                                       "identify_elam_base_in_plain_j_goal_at_most 100 x",
                                                       "identify_elam_avx2 10 us/taxel",
                                                       "identify_elam_avx2_in_plain_j 10 x",
                                                       "identify_elam_avx2_in_plain_j_goal_at_most 50 x",
                                                       "identify_elam_in_plain_j_stretch_base 50 x",
                                                       "identify_elam_in_plain_j_stretch_avx2 15 x",
                                                       "identify_elam_genetic 166666.7 us/taxel",
                                                       "identify_elam_genetic_time_over_exact 500 x",
                                                       "identify_elam_genetic_j_over_exact 1.25 x",
                                                       "identify_elam_genetic_j_over_exact_worst_taxel 1.5 x",
                                                       "identify_array_reading 2 ms",
                                                       "identify_array_identification_alone 3 ms",
                                                       "identify_array_from_store 6 ms",
                                                       "identify_array_over_floor 1.2 x",
                                                       "identify_array_over_floor_goal_at_most 1.5 x",
                                                       "identify_two_threads_speedup 1.5 x",
                                                       "identify_two_threads_speedup_goal_at_least 1.7 x",
                                                       "identify_growth_16x16 1 us/taxel",
                                                       "identify_growth_32x32 2 us/taxel",
                                                       "identify_growth_64x64 3 us/taxel",
                                                       "identify_growth_64x64_over_16x16 3 x",
                                                       "identify_gpi 10000 us/taxel",
                                                       "identify_gpi_in_walks 100 x",
                                                       "identify_mpi 5000 us/taxel",
                                                       "identify_mpi_in_walks 20 x",
                                                       "identify_dynamic_array 0.75 s",
                                                       "identify_dynamic_array_goal_at_most 1 s"});
}

TEST_CASE("benchmark identify: a genetic search that ends below the exact one is told as less than one") {
  IdentifyTimes times = round_times();
  times.genetic_j = {1.0, 0.5, 3.0};
  const IdentifyLines lines = identify_lines(times);
  CHECK(lines[11] == "identify_elam_genetic_j_over_exact 0.5625 x");
  CHECK(lines[12] == "identify_elam_genetic_j_over_exact_worst_taxel 0.6 x");
}

TEST_CASE("benchmark identify: without the genetic search its figures are left out") {
  IdentifyTimes times = round_times();
  times.genetic_j = times.exact_j = {};
  const IdentifyLines lines = identify_lines(times);
  CHECK(lines.size() == 26);
  CHECK(lines[8] == "identify_elam_in_plain_j_stretch_avx2 15 x");
  CHECK(lines[9] == "identify_array_reading 2 ms");
}
