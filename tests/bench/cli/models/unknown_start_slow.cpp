// compensate on a recording that begins in mid-branch: said, and its uncertainty holds the truth.
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "tests/bench/cli/play_table.h"
#include "tests/support/process.h"

using namespace tactbench::tests;

namespace {

std::string rows_from(const std::vector<PlaySample>& samples, std::size_t first) {
  std::string text = "input,output\n";
  for (std::size_t i = first; i < samples.size(); ++i)
    text += std::to_string(samples[i].input) + "," + std::to_string(samples[i].output) + "\n";
  return text;
}

struct Read {
  double input = 0.0, compensated = 0.0, uncertainty = 0.0;
  std::string flags;
};

std::vector<Read> reads_of(const std::string& text) {
  std::istringstream lines(text);
  std::string line;
  std::vector<Read> reads;
  std::getline(lines, line);
  REQUIRE(line == "input,output,compensated,uncertainty,flags");
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    std::vector<std::string> found(5);
    for (std::string& cell : found) std::getline(cells, cell, ',');
    reads.push_back({std::stod(found[0]), std::stod(found[2]), std::stod(found[3]), found[4]});
  }
  return reads;
}

}  // namespace

TEST_CASE("compensate: a recording from mid-fall is flagged unknown, and twice its uncertainty holds the truth") {
  const TemporaryFolder folder;
  write_file(folder.path("fitted.csv"),
             rows_from(play_samples({0, 10, 0, 10, 5, 10, 3, 10, 1, 10, 0, 8, 0, 6, 0, 4, 0}), 0));
  const std::vector<PlaySample> all = play_samples({0, 10, 2, 9, 0, 10, 4});
  std::size_t mid_fall = 0;  // on the way down from the first 10
  while (mid_fall == 0 || all[mid_fall].input > 6.0 || all[mid_fall].input > all[mid_fall - 1].input) ++mid_fall;
  write_file(folder.path("late.csv"), rows_from(all, mid_fall));
  write_file(folder.path("whole.csv"), rows_from(all, 0));
  for (const std::string model : {"elam", "preisach", "gpi"}) {
    INFO(model);
    REQUIRE(call(folder, {"fit", "fitted.csv", "--model", model, "-o", model + ".json"}).code == 0);
    const Finished late = call(folder, {"compensate", model + ".json", "late.csv"});
    INFO(late.err);
    REQUIRE(late.code == 0);
    const std::vector<Read> reads = reads_of(late.out);
    CHECK_THAT(reads.front().flags, Catch::Contains("unknown"));
    int held = 0;
    for (const Read& read : reads)
      if (!(std::abs(read.compensated - read.input) > 2.0 * read.uncertainty)) ++held;
    CHECK(held >= 0.9 * static_cast<double>(reads.size()));
    CHECK(std::abs(reads.front().compensated - reads.front().input) <= 2.0 * reads.front().uncertainty);
    CHECK_THAT(reads.back().flags, !Catch::Contains("unknown"));
    CHECK_THAT(call(folder, {"compensate", model + ".json", "whole.csv"}).out, !Catch::Contains("unknown"));
  }
}
