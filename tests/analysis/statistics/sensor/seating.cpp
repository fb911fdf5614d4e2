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
  CHECK((row ? finding.rows : finding.columns).back() == (last ? 15 : lines - 1));
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
  const int turn = GENERATE(range(1, 8));
  SpecimenOptions options = mounted_again(6);
  options.mount_turn = static_cast<MountTurn>(turn);
  const SeatingFrames last = seated(sensor(6));
  const SeatingResult result = check(options, last);
  CAPTURE(turn);
  REQUIRE(kinds(result) == "turned");
  CHECK(result.verdict == "fail");
  // The finding names the position, as the comparison does.
  const std::vector<bool> all(256, true);
  const auto positions = compare_positions(16, 16, last.loaded_v, last.loaded_v, all, all);
  CHECK_THAT(result.findings.front().text, Catch::Contains(positions[static_cast<std::size_t>(turn)].name + " since"));
}

TEST_CASE("seating: another sensor is a deviation") {
  const SeatingResult other = check(sensor(9), seated(sensor(8)));
  CHECK(other.verdict == "fail");
  CHECK(kinds(other) == "deviation");
}
