// Rows and columns of the seating check at each of their limits, from lines of one response each: by hand.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/statistics/sensor/seating_lines.h"

using namespace tactbench::analysis;

namespace {

// Lines along one axis, ten taxels long, that answer by `volts` and stand 0.02 V higher.
SeatingTaxels lines_answering(const std::vector<double>& volts, bool along_rows,
                              const std::vector<double>& before = {}) {
  const int lines = static_cast<int>(volts.size());
  SeatingTaxels taxels;
  taxels.rows = along_rows ? lines : 10;
  taxels.columns = along_rows ? 10 : lines;
  for (int row = 0; row < taxels.rows; ++row)
    for (int column = 0; column < taxels.columns; ++column) {
      const auto line = static_cast<std::size_t>(along_rows ? row : column);
      taxels.response_v.push_back(volts[line]);
      taxels.loaded_v.push_back(volts[line] + 0.02);
      if (!before.empty()) taxels.before_v.push_back(before[line]);
    }
  taxels.known_dead.assign(taxels.response_v.size(), false);
  taxels.open_rows.assign(static_cast<std::size_t>(taxels.rows), false);
  taxels.open_columns.assign(static_cast<std::size_t>(taxels.columns), false);
  return taxels;
}

struct LineVerdict {
  std::string kinds;
  std::vector<int> lines;  // of all findings
  int lost = 0;
};

LineVerdict judged(const SeatingTaxels& taxels, bool along_rows) {
  std::vector<bool> lost(taxels.response_v.size(), false);
  LineVerdict out;
  for (const SeatingFinding& finding : check_lines(taxels, along_rows, {}, lost)) {
    out.kinds += (out.kinds.empty() ? "" : " ") + finding.kind;
    const std::vector<int>& own = along_rows ? finding.rows : finding.columns;
    CHECK((along_rows ? finding.columns : finding.rows).empty());
    CHECK(finding.verdict == "fail");
    out.lines.insert(out.lines.end(), own.begin(), own.end());
  }
  for (const bool own : lost) out.lost += own ? 1 : 0;
  return out;
}

// Ten lines of 1 V but those given from the first or, in reverse, from the last one on.
LineVerdict at_edge(const std::vector<double>& volts, bool along_rows = true, bool last = false,
                    const std::vector<double>& before = {}) {
  std::vector<double> all(10, 1.0);
  for (std::size_t i = 0; i < volts.size(); ++i) all[last ? 9 - i : i] = volts[i];
  return judged(lines_answering(all, along_rows, before), along_rows);
}

LineVerdict inner(double volts) {
  std::vector<double> all(10, 1.0);
  all[4] = volts;
  return judged(lines_answering(all, true), true);
}

}  // namespace

TEST_CASE("lines: one below 8 % of what lines answer is dead, and all of its taxels are lost") {
  CHECK(inner(0.081).kinds.empty());
  CHECK(inner(0.081).lost == 0);
  const LineVerdict dead = inner(0.079);
  CHECK(dead.kinds == "dead-rows");
  CHECK(dead.lines == std::vector<int>{4});
  CHECK(dead.lost == 10);
  // What lines answer is their upper quartile: of 1 2 3 4 V four and four of each 3 V. 0.24 V are 8 % of it.
  const auto among = [](double volts) {
    return judged(lines_answering({1, 1, 2, volts, 2, 3, 4, 4}, true), true).kinds;
  };
  CHECK(among(0.33) == "");
  CHECK(among(0.31) == "dead-rows");  // of 1 1 2 2 3 4 4 the value at place 5 is 4 V: 0.32 V
}

TEST_CASE("lines alone: an edge is outside below 15 % of the median line, with the lines below 20 % that rise inward") {
  for (const bool along_rows : {true, false}) {
    for (const bool last : {false, true}) {
      INFO((along_rows ? "rows " : "columns ") << (last ? "last" : "first"));
      const auto found = [&](const std::vector<double>& volts) { return at_edge(volts, along_rows, last); };
      const auto lines = [&](int count) {
        std::vector<int> expected;
        for (int i = 0; i < count; ++i) expected.push_back(last ? 10 - count + i : i);
        return expected;
      };
      CHECK(found({0.151}).kinds.empty());
      CHECK(found({0.149}).kinds == "edge-outside");
      CHECK(found({0.149}).lines == lines(1));
      CHECK(found({0.149}).lost == 10);
      CHECK(found({0.1, 0.199}).lines == lines(2));
      CHECK(found({0.1, 0.201}).lines == lines(1));
      CHECK(found({0.1, 0.15, 0.19}).lines == lines(3));
      // A step back of less than 5 % is noise.
      CHECK(found({0.145, 0.1}).lines == lines(2));
      CHECK(found({0.145, 0.09}).lines == lines(1));
    }
  }
}

TEST_CASE("lines alone: a fall-off has a line above 3 % of the others, without one the lines are dead") {
  CHECK(at_edge({0.031}).kinds == "edge-outside");
  CHECK(at_edge({0.029}).kinds == "dead-rows");
  CHECK(at_edge({0.0, 0.031}).kinds == "edge-outside");
  CHECK(at_edge({0.0, 0.029}).kinds == "half-inserted");
  CHECK(at_edge({0.0}).kinds == "dead-rows");
  const LineVerdict open = at_edge({0.0, 0.0, 0.0}, false, true);
  CHECK(open.kinds == "half-inserted");
  CHECK(open.lines == std::vector<int>{7, 8, 9});
  CHECK(open.lost == 30);
  // A block at the edge and a line by itself.
  std::vector<double> all(10, 1.0);
  all[0] = all[1] = all[6] = 0.0;
  const LineVerdict both = judged(lines_answering(all, true), true);
  CHECK(both.kinds == "half-inserted dead-rows");
  CHECK(both.lines == std::vector<int>{0, 1, 6});
  CHECK(both.lost == 30);
}

TEST_CASE("lines alone: three lines are too few for an edge") {
  CHECK(judged(lines_answering({0.1, 1, 1, 1}, true), true).kinds == "edge-outside");
  CHECK(judged(lines_answering({0.1, 1, 1}, true), true).kinds.empty());
}

TEST_CASE("lines against the last seating: an edge is outside below 50 % of it, with the lines below 80 %") {
  // Then the lines answered by 1 to 2 V; now all by half of that, which is the mount's, and the edge by less.
  std::vector<double> before, now;
  for (int i = 0; i < 10; ++i) before.push_back(1.0 + 0.1 * i);
  const auto found = [&](const std::vector<double>& shares) {
    now.clear();
    for (std::size_t i = 0; i < 10; ++i) now.push_back(0.5 * before[i] * (i < shares.size() ? shares[i] : 1.0));
    return judged(lines_answering(now, true, before), true);
  };
  CHECK(found({}).kinds.empty());
  CHECK(found({0.51}).kinds.empty());
  CHECK(found({0.49}).kinds == "edge-outside");
  CHECK(found({0.49}).lines == std::vector<int>{0});
  CHECK(found({0.3, 0.79}).lines == std::vector<int>{0, 1});
  CHECK(found({0.3, 0.81}).lines == std::vector<int>{0});
  // A line that was as weak then is not weak now.
  before[0] = 0.2;
  CHECK(found({}).kinds.empty());
}

TEST_CASE("lines: taxels known to be dead, and those in open lines across, say nothing, a quarter has to be left") {
  std::vector<double> all(10, 1.0);
  all[4] = 0.0;
  SeatingTaxels taxels = lines_answering(all, true);
  for (std::size_t i = 0; i < 7; ++i) taxels.known_dead[40 + i] = true;
  CHECK(judged(taxels, true).kinds == "dead-rows");  // three of ten
  taxels.known_dead[47] = true;
  CHECK(judged(taxels, true).kinds.empty());  // two
  for (std::size_t i = 0; i < 8; ++i) taxels.known_dead[40 + i] = false;
  for (std::size_t i = 0; i < 8; ++i) taxels.open_columns[i] = true;
  CHECK(judged(taxels, true).kinds.empty());
  taxels.open_columns[0] = false;
  CHECK(judged(taxels, true).kinds == "dead-rows");
  // Columns look at open rows: each column without row 4 answers by 1 V, and one where two known dead are left out.
  CHECK(judged(taxels, false).kinds.empty());
  SeatingTaxels half = lines_answering(std::vector<double>(10, 1.0), false);
  for (std::size_t row = 0; row < 10; ++row) half.response_v[row * 10 + 3] = row < 6 ? 0.0 : 1.0;
  CHECK(judged(half, false).kinds.empty());  // 0.4 V in the mean
  for (std::size_t row = 6; row < 10; ++row) half.open_rows[row] = true;
  CHECK(judged(half, false).kinds == "dead-columns");
}

TEST_CASE("open lines are those with nine of ten taxels silent, below the least response of either sign") {
  SeatingTaxels taxels;
  taxels.rows = 20;
  taxels.columns = 10;
  taxels.response_v.assign(200, 1.0);
  for (std::size_t i = 0; i < 9; ++i) taxels.response_v[2 * 10 + i] = 0.0;   // row 2: nine of ten
  for (std::size_t i = 0; i < 8; ++i) taxels.response_v[5 * 10 + i] = 0.0;   // row 5: eight
  for (std::size_t i = 0; i < 18; ++i) taxels.response_v[i * 10 + 9] = 0.0;  // column 9: eighteen of twenty
  for (std::size_t i = 3; i < 20; ++i) taxels.response_v[i * 10 + 0] = -0.009;
  find_open_lines(taxels, 0.01);
  for (std::size_t row = 0; row < 20; ++row) CHECK(taxels.open_rows[row] == (row == 2 || row == 5));  // with column 9
  for (std::size_t column = 0; column < 10; ++column)
    CHECK(taxels.open_columns[column] == (column == 0 || column == 9));
  SeatingTaxels answers = taxels;
  answers.open_rows.clear();
  answers.open_columns.clear();
  for (std::size_t i = 3; i < 20; ++i) answers.response_v[i * 10 + 0] = -0.01;  // answers, the wrong way round
  answers.response_v[17 * 10 + 9] = 1.0;                                        // seventeen of twenty
  find_open_lines(answers, 0.01);
  CHECK_FALSE(answers.open_columns[0]);
  CHECK_FALSE(answers.open_columns[9]);
}
