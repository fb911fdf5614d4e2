// The seating check on simulated arrays: every fault of a mount is found and named, and nothing else is.
#include "analysis/statistics/sensor/seating.h"

#include <catch2/catch.hpp>

#include "tests/analysis/statistics/sensor/seated.h"

using namespace tactbench;
using namespace tactbench::analysis;
using bench::MountEdge;
using bench::MountTurn;
using bench::SpecimenOptions;
using bench::TaxelDefect;

namespace {

void break_line(SpecimenOptions& options, bool row, int line, TaxelDefect::Kind kind = TaxelDefect::Kind::kDead) {
  for (int i = 0; i < (row ? options.columns : options.rows); ++i) {
    options.defects.push_back({kind, row ? line : i, row ? i : line});
  }
}

SeatingResult check(const SpecimenOptions& options, const std::optional<SeatingFrames>& last = std::nullopt) {
  return check_seating(options.rows, options.columns, seated(options, 77), last);
}

std::string kinds(const SeatingResult& result) {
  std::string all;
  for (const SeatingFinding& finding : result.findings) all += (all.empty() ? "" : " ") + finding.kind;
  return all;
}

}  // namespace

TEST_CASE("seating: noise five times larger gives no finding") {
  const SeatingFrames first = seated(sensor(3), 1, 0.0075);
  CHECK(check_seating(16, 16, first, std::nullopt).verdict == "pass");
  CHECK(check_seating(16, 16, seated(mounted_again(3), 2, 0.0075), first).verdict == "pass");
}

TEST_CASE("seating: dead rows and columns are named, with their output") {
  SpecimenOptions options = sensor(2);
  break_line(options, true, 5);
  break_line(options, true, 9, TaxelDefect::Kind::kSaturated);
  break_line(options, false, 0);
  const SeatingResult result = check(options);
  CHECK(result.verdict == "fail");
  REQUIRE(kinds(result) == "dead-rows dead-columns");
  CHECK(result.findings[0].rows == std::vector<int>{5, 9});
  CHECK(result.findings[1].columns == std::vector<int>{0});
  CHECK(result.dead_taxels.empty());
}

TEST_CASE("seating: a block of lines at one end is a half-inserted connector, elsewhere it is not") {
  const bool row = GENERATE(true, false);
  const bool last = GENERATE(true, false);
  const int lines = GENERATE(2, 7, 14);
  SpecimenOptions options = sensor(4);
  for (int i = 0; i < lines; ++i) break_line(options, row, last ? 15 - i : i, TaxelDefect::Kind::kSaturated);
  const SeatingResult result = check(options, seated(sensor(4)));
  REQUIRE(kinds(result) == "half-inserted");
  CHECK(result.verdict == "fail");
  const SeatingFinding& finding = result.findings.front();
  CHECK((row ? finding.rows : finding.columns).size() == static_cast<std::size_t>(lines));
  CHECK_THAT(finding.text, Catch::Contains("standing at 5.00 V"));
  CHECK_THAT(finding.text,
             Catch::Contains(std::string("side of the ") + (last ? "last " : "first ") + (row ? "row" : "column")));
  SpecimenOptions inner = sensor(4);
  for (int i = 0; i < 3; ++i) break_line(inner, row, 6 + i);
  CHECK(kinds(check(inner)) == (row ? "dead-rows" : "dead-columns"));
}

TEST_CASE("seating: an edge outside the membrane is found against the last seating") {
  const auto edge =
      GENERATE(MountEdge::kFirstRow, MountEdge::kLastRow, MountEdge::kFirstColumn, MountEdge::kLastColumn);
  const int lines = GENERATE(2, 3, 4);
  SpecimenOptions options = mounted_again(5);
  options.edge_outside = edge;
  options.edge_outside_lines = lines;
  const SeatingResult result = check(options, seated(sensor(5)));
  CHECK(result.verdict == "fail");
  REQUIRE_THAT(kinds(result), Catch::Contains("edge-outside"));
  const SeatingFinding& finding = result.findings.back();
  const bool rows = edge == MountEdge::kFirstRow || edge == MountEdge::kLastRow;
  const std::vector<int>& named = rows ? finding.rows : finding.columns;
  const bool last = edge == MountEdge::kLastRow || edge == MountEdge::kLastColumn;
  CHECK((last ? named.back() : named.front()) == (last ? 15 : 0));
  CHECK(static_cast<int>(named.size()) >= lines - 1);
  CHECK(static_cast<int>(named.size()) <= lines);
  // Without a last seating the array's own slope may hide some of it, but not four lines.
  if (lines == 4) CHECK(check(options).verdict == "fail");
}

TEST_CASE("seating: every rotation and mirror image of a square array is distinguished") {
  const std::vector<std::string> words = {"as before",         "turned by 180",      "first row with last",
                                          "first column with", "turned clockwise",   "turned counter-clockwise",
                                          "rows with columns", "from the far corner"};
  const int turn = GENERATE(range(1, 8));
  SpecimenOptions options = mounted_again(6);
  options.mount_turn = static_cast<MountTurn>(turn);
  const SeatingResult result = check(options, seated(sensor(6)));
  REQUIRE(kinds(result) == "turned");
  CHECK(result.verdict == "fail");
  CAPTURE(turn, result.findings.front().text);
  CHECK_THAT(result.findings.front().text, Catch::Contains(words[static_cast<std::size_t>(turn)]));
}

TEST_CASE("seating: for an array that is not square four orientations are compared") {
  SpecimenOptions options = sensor(7);
  options.rows = 8;
  const SeatingFrames first = seated(options);
  options.mount_turn = MountTurn::kBy180;
  const SeatingResult result = check(options, first);
  REQUIRE(kinds(result) == "turned");
  CHECK_THAT(result.findings.front().text, Catch::Contains("turned by 180 degrees"));
  const std::vector<bool> all(128, true);
  CHECK(compare_positions(8, 16, first.loaded_v, first.loaded_v, all, all).size() == 4);
}

TEST_CASE("seating: an even array is not compared by pattern, since it looks the same from all sides") {
  SeatingFrames first{8.0, std::vector<double>(256, 0.02), std::vector<double>(256)};
  SeatingFrames again = first;
  for (std::size_t i = 0; i < 256; ++i) {
    first.loaded_v[i] = 0.6 + 0.01 * bench::bell_of(bench::hash_of(1, 1, i));
    again.loaded_v[i] = 0.6 + 0.01 * bench::bell_of(bench::hash_of(2, 1, i));
  }
  const SeatingResult result = check_seating(16, 16, again, first);
  CHECK(result.verdict == "pass");
  CHECK_FALSE(result.correlation);
}

TEST_CASE("seating: another sensor, and a response far from the last, are deviations") {
  const SeatingFrames first = seated(sensor(8));
  const SeatingResult other = check(sensor(9), first);
  CHECK(other.verdict == "fail");
  CHECK(kinds(other) == "deviation");
  SeatingFrames weaker = seated(sensor(8), 2);
  const auto scaled = [&](double by) {
    SeatingFrames frames = weaker;
    for (std::size_t i = 0; i < 256; ++i) {
      frames.loaded_v[i] = frames.unloaded_v[i] + by * (frames.loaded_v[i] - frames.unloaded_v[i]);
    }
    return check_seating(16, 16, frames, first);
  };
  CHECK(scaled(0.85).verdict == "pass");
  CHECK(scaled(0.7).verdict == "warning");
  CHECK(scaled(0.4).verdict == "fail");
  CHECK(scaled(0.4).mean_ratio.value() == Approx(0.4).epsilon(0.01));
  weaker.pressure_psi = 7.0;
  CHECK(scaled(0.7).verdict == "pass");  // at another pressure the mean says nothing
}

TEST_CASE("seating: single dead taxels are counted, a warning only when new and many") {
  SpecimenOptions few = sensor(10), many = sensor(10);
  few.defects = {{TaxelDefect::Kind::kDead, 3, 4}, {TaxelDefect::Kind::kStuck, 7, 4}};
  for (int i = 0; i < 6; ++i) many.defects.push_back({TaxelDefect::Kind::kDead, 2 * i, i});
  const SeatingFrames first = seated(sensor(10));
  const SeatingResult two = check(few, first);
  CHECK(two.verdict == "pass");
  CHECK(two.dead_taxels == std::vector<int>{3 * 16 + 4, 7 * 16 + 4});
  const SeatingResult six = check(many, first);
  CHECK(six.verdict == "warning");
  REQUIRE(kinds(six) == "dead-taxels");
  CHECK_THAT(six.findings.front().text, Catch::Contains("6 single taxels") && Catch::Contains("(10, 5)"));
  const SeatingResult known = check(many, seated(many));
  CHECK(known.verdict == "pass");
  CHECK(known.dead_taxels.size() == 6);
}

TEST_CASE("seating: an array that does not answer at all is one finding, and a wrong shape is refused") {
  SeatingFrames silent{8.0, std::vector<double>(256, 0.02), std::vector<double>(256, 0.021)};
  const SeatingResult result = check_seating(16, 16, silent, std::nullopt);
  CHECK(result.verdict == "fail");
  CHECK(kinds(result) == "no-response");
  CHECK_THROWS_AS(check_seating(16, 15, silent, std::nullopt), std::invalid_argument);
  CHECK_THROWS_AS(check_seating(0, 0, {}, std::nullopt), std::invalid_argument);
}
