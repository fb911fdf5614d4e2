// The seating check on simulated arrays: every fault of a mount is found and named, and nothing else is.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "analysis/statistics/sensor/seating.h"
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

TEST_CASE("seating: dead rows and columns are found and named") {
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

TEST_CASE("seating: a block of dead lines at one end is a half-inserted connector, elsewhere it is dead lines") {
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

TEST_CASE("seating: an edge outside the membrane is found by comparison with the last seating") {
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

TEST_CASE("seating: every rotation and mirror image of a square array is identified") {
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

TEST_CASE("seating: another sensor is reported as a deviation") {
  const SeatingResult other = check(sensor(9), seated(sensor(8)));
  CHECK(other.verdict == "fail");
  CHECK(kinds(other) == "deviation");
}

// The parts of the seating check by hand: how well a pattern fits in each position, and the lines at each limit.

namespace {

// Places of compare_positions().
constexpr std::size_t kAsBefore = 0, kBy180 = 1, kRowsMirrored = 2;

}  // namespace

TEST_CASE("seating positions: correlations do not depend on the mean, and are 0 without variation") {
  struct Pattern {
    const char* what;
    std::vector<double> now, before;
    double correlation;
  };
  // About their means 0.02 and 0.03: (-1 0 1) with (-1 1 0), each times 0.01: 1 / 2. With (-1 2 -1): 0.
  const std::vector<Pattern> patterns = {{"half", {0.01, 0.02, 0.03}, {0.02, 0.04, 0.03}, 0.5},
                                         {"none", {0.01, 0.02, 0.03}, {0.02, 0.05, 0.02}, 0.0},
                                         {"opposite", {0.01, 0.02, 0.03}, {0.09, 0.06, 0.03}, -1.0},
                                         {"the same, twice as large", {0.01, 0.02, 0.05}, {0.02, 0.04, 0.10}, 1.0},
                                         {"far from zero", {5.01, 5.02, 5.03}, {-3.02, -3.00, -3.01}, 0.5},
                                         {"below zero", {-2.0, -1.0, 0.0, 1.0}, {-1.0, -2.0, 1.0, 0.0}, 0.6},
                                         {"all alike now", {0.5, 0.5, 0.5}, {0.25, 0.5, 1.0}, 0.0},
                                         {"all alike before", {0.25, 0.5, 1.0}, {0.5, 0.5, 0.5}, 0.0},
                                         {"two taxels say nothing", {0.01, 0.02}, {0.01, 0.02}, 0.0}};
  for (const Pattern& own : patterns) {
    INFO(own.what);
    const std::vector<bool> all(own.now.size(), true);
    const auto fits = compare_positions(1, static_cast<int>(own.now.size()), own.now, own.before, all, all);
    REQUIRE(fits.size() == 4);
    // There is one row: mirrored it is what it was.
    for (const std::size_t at : {kAsBefore, kRowsMirrored})
      CHECK(fits[at].correlation == Approx(own.correlation).margin(1e-9));
  }
}

TEST_CASE("seating positions: each of the eight fits only the pattern that was moved accordingly") {
  // 1 to 9 by rows, then where each of them lies after the sensor was moved.
  const std::vector<double> before{1, 2, 3, 4, 5, 6, 7, 8, 10};
  const std::vector<std::vector<double>> moved = {before,
                                                  {10, 8, 7, 6, 5, 4, 3, 2, 1},   // half a turn
                                                  {7, 8, 10, 4, 5, 6, 1, 2, 3},   // rows mirrored
                                                  {3, 2, 1, 6, 5, 4, 10, 8, 7},   // columns mirrored
                                                  {7, 4, 1, 8, 5, 2, 10, 6, 3},   // a quarter clockwise
                                                  {3, 6, 10, 2, 5, 8, 1, 4, 7},   // and the other way
                                                  {1, 4, 7, 2, 5, 8, 3, 6, 10},   // rows are columns
                                                  {10, 6, 3, 8, 5, 2, 7, 4, 1}};  // from the other corner
  const std::vector<bool> all(9, true);
  for (std::size_t turn = 0; turn < moved.size(); ++turn) {
    const auto fits = compare_positions(3, 3, moved[turn], before, all, all);
    REQUIRE(fits.size() == 8);
    for (std::size_t at = 0; at < 8; ++at) {
      CAPTURE(turn, at);
      CHECK((at == turn ? fits[at].correlation == Approx(1.0) : fits[at].correlation < 0.99));
    }
  }
}

TEST_CASE("seating positions: only taxels that responded in both seatings count, at their place in each") {
  // Turned by 180 degrees: what lay first lies last. The last of now and the first of before are one taxel.
  const std::vector<double> before{9, 1, 2, 3, 4, 5}, now{5, 4, 3, 2, 1, -9};
  std::vector<bool> all(6, true), not_first = all, not_last = all;
  not_first[0] = false;
  not_last[5] = false;
  const auto turned = [&](const std::vector<bool>& use_now, const std::vector<bool>& use_before) {
    return compare_positions(2, 3, now, before, use_now, use_before)[kBy180].correlation;
  };
  CHECK(turned(all, all) < 0.5);
  CHECK(turned(not_last, all) == Approx(1.0));
  CHECK(turned(all, not_first) == Approx(1.0));
  CHECK(turned(not_first, all) < 0.5);
  // Three taxels are the fewest that say something.
  const std::vector<bool> three{true, true, true, false, false, false}, two{true, true, false, false, false, false};
  CHECK(compare_positions(1, 6, before, before, three, all)[kAsBefore].correlation == Approx(1.0));
  CHECK(compare_positions(1, 6, before, before, two, all)[kAsBefore].correlation == 0.0);
}

// The seating check as a whole at each of its limits, on patterns whose correlation is known.

namespace {

constexpr int kHigh = 4, kLong = 8;

// Patterns of +-1 by columns, each of mean 0 and at right angles to the others: halves turns into its opposite when the
// array is turned by half a turn, sides stays, stripes turns into its opposite.
double halves(int column) { return column < 4 ? 1.0 : -1.0; }
double sides(int column) { return column < 2 || column > 5 ? 1.0 : -1.0; }
double stripes(int column) { return column % 2 == 0 ? 1.0 : -1.0; }

template <class Of>
SeatingFrames pattern_of(const Of& of_column, double pressure_psi = 8.0) {
  SeatingFrames frames{pressure_psi, {}, {}};
  for (int i = 0; i < kHigh * kLong; ++i) {
    frames.unloaded_v.push_back(0.3);
    frames.loaded_v.push_back(0.3 + of_column(i % kLong));
  }
  return frames;
}

SeatingFrames even_frames(double response_v, double pressure_psi = 8.0, std::size_t taxels = 100) {
  return {pressure_psi, std::vector<double>(taxels, 0.3), std::vector<double>(taxels, 0.3 + response_v)};
}

std::string findings_of(const SeatingResult& result) {
  std::string all;
  for (const SeatingFinding& finding : result.findings)
    all += (all.empty() ? "" : ", ") + finding.verdict + " " + finding.kind;
  return all;
}

// A pattern that resembles halves by this correlation: cos and sin of the angle between them.
SeatingResult resembling(double correlation, double sign = 1.0) {
  const double rest = std::sqrt(1.0 - correlation * correlation);
  const SeatingFrames before = pattern_of([](int c) { return 1.0 + 0.2 * halves(c); });
  const SeatingFrames now =
      pattern_of([&](int c) { return 1.0 + 0.2 * (sign * correlation * halves(c) + rest * stripes(c)); });
  return check_seating(kHigh, kLong, now, before);
}

}  // namespace

TEST_CASE("seating bounds: correlation with the last pattern passes from 0.9, warns from 0.8 and fails below") {
  const SeatingResult passes = resembling(0.91), warns = resembling(0.89), still = resembling(0.81),
                      fails = resembling(0.79);
  CHECK(passes.verdict == "pass");
  REQUIRE(passes.correlation);
  CHECK(*passes.correlation == Approx(0.91));
  CHECK(*passes.mean_ratio == Approx(1.0));
  CHECK(passes.mean_response_v == Approx(1.0));
  CHECK(findings_of(warns) == "warning deviation");
  CHECK(warns.verdict == "warning");
  CHECK_THAT(warns.findings[0].text, Catch::Contains("0.89"));
  CHECK(findings_of(still) == "warning deviation");
  CHECK(findings_of(fails) == "fail deviation");
  CHECK_THAT(fails.findings[0].text, Catch::Contains("0.79"));
}

TEST_CASE("seating bounds: another position must correlate by at least 0.8") {
  const SeatingResult turned = resembling(0.81, -1.0), other = resembling(0.79, -1.0);
  REQUIRE(findings_of(turned) == "fail turned");
  CHECK_THAT(turned.findings[0].text, Catch::Contains("180") && Catch::Contains(" 0.81") && Catch::Contains("-0.81"));
  CHECK(*turned.correlation == Approx(-0.81));
  CHECK(findings_of(other) == "fail deviation");
}

TEST_CASE("seating bounds: another position must correlate better than the last one by 0.2") {
  // Turned by half a turn, a pattern of `share` sides and the rest halves fits itself as it is by 2 share - 1.
  const auto half_turned = [](double share) {
    const auto by = [share](double sign) {
      return pattern_of(
          [=](int c) { return 1.0 + 0.2 * (std::sqrt(share) * sides(c) + sign * std::sqrt(1.0 - share) * halves(c)); });
    };
    return check_seating(kHigh, kLong, by(-1.0), by(1.0));
  };
  CHECK(findings_of(half_turned(0.89)) == "fail turned");        // 0.78
  CHECK(findings_of(half_turned(0.91)) == "warning deviation");  // 0.82
  CHECK(*half_turned(0.91).correlation == Approx(0.82));
}

TEST_CASE("seating bounds: patterns are compared from a spread of 5 % and sixteen responding taxels on") {
  const auto compared = [](double spread) {
    const SeatingFrames before = pattern_of([&](int c) { return 1.0 + spread * halves(c); });
    return check_seating(kHigh, kLong, before, before).correlation.has_value();
  };
  CHECK(compared(0.051));
  CHECK_FALSE(compared(0.049));
  const auto answering = [](int rows, int columns) {
    SeatingFrames frames{8.0, {}, {}};
    for (int i = 0; i < rows * columns; ++i) {
      frames.unloaded_v.push_back(0.1);
      frames.loaded_v.push_back(0.1 + (i % 2 == 0 ? 0.5 : 1.0));
    }
    return check_seating(rows, columns, frames, frames).correlation.has_value();
  };
  CHECK(answering(4, 4));
  CHECK_FALSE(answering(3, 5));
}

TEST_CASE("seating bounds: a mean off by a fifth warns, by half fails, if pressures agree within 0.5 psi") {
  const auto by = [](double factor, double pressure_psi = 8.0) {
    return check_seating(10, 10, even_frames(factor, pressure_psi), even_frames(1.0));
  };
  CHECK(by(0.81).verdict == "pass");
  CHECK(by(0.79).verdict == "warning");
  CHECK(by(0.51).verdict == "warning");
  CHECK(by(0.49).verdict == "fail");
  CHECK(by(1.19).verdict == "pass");
  CHECK(by(1.21).verdict == "warning");
  CHECK(by(1.51).verdict == "fail");
  CHECK(by(0.49, 8.5).verdict == "fail");
  CHECK(by(0.49, 7.5).verdict == "fail");
  CHECK(by(0.49, 8.51).verdict == "pass");
  CHECK(by(0.49, 7.49).verdict == "pass");
  CHECK(by(0.79).mean_ratio.value() == Approx(0.79));
  CHECK_FALSE(check_seating(10, 10, even_frames(1.0), even_frames(0.0)).mean_ratio);  // nothing to compare with
  // However small: four taxels of 0.2 V.
  CHECK(check_seating(2, 2, even_frames(0.15, 8.0, 4), even_frames(0.2, 8.0, 4)).mean_ratio.value() == Approx(0.75));
}

TEST_CASE("seating bounds: taxels below 10 mV are dead, and more than 2 % newly dead ones give a warning") {
  const auto with_dead = [](int count, double response_v, bool known = false) {
    SeatingFrames now = even_frames(1.0), before = even_frames(1.0);
    for (int i = 0; i < count; ++i) {
      const auto at = static_cast<std::size_t>(11 * i + 3);  // no two in a line
      now.loaded_v[at] = 0.3 + response_v;
      if (known) before.loaded_v[at] = 0.3 + response_v;
    }
    return check_seating(10, 10, now, before);
  };
  CHECK(with_dead(2, 0.009).verdict == "pass");
  CHECK(with_dead(2, 0.009).dead_taxels == std::vector<int>{3, 14});
  const SeatingResult three = with_dead(3, 0.009);
  REQUIRE(findings_of(three) == "warning dead-taxels");
  CHECK(three.findings[0].rows == std::vector<int>{0, 1, 2});
  CHECK(three.findings[0].columns == std::vector<int>{3, 4, 5});
  CHECK(with_dead(3, -0.009).verdict == "warning");
  CHECK(with_dead(3, 0.011).dead_taxels.empty());
  CHECK(with_dead(3, -0.011).dead_taxels.empty());
  CHECK(with_dead(3, 0.009, true).verdict == "pass");
  CHECK(with_dead(3, 0.009, true).dead_taxels.size() == 3);
}

TEST_CASE("seating bounds: an array responds if a tenth of its taxels exceeds 20 mV") {
  const auto answered_by = [](std::size_t taxels, double response_v) {
    SeatingFrames frames = even_frames(0.001);
    for (std::size_t i = 0; i < taxels; ++i) frames.loaded_v[10 * i] = 0.3 + response_v;
    return findings_of(check_seating(10, 10, frames, std::nullopt));
  };
  CHECK(answered_by(10, 0.019) == "fail no-response");
  CHECK(answered_by(9, 1.0) == "fail no-response");
  CHECK(answered_by(10, 1.0) != "fail no-response");
  const SeatingResult silent = check_seating(10, 10, even_frames(0.015, 8.04), std::nullopt);
  CHECK_THAT(silent.findings[0].text, Catch::Contains("8.0"));
  CHECK_THROWS_AS(check_seating(10, 9, even_frames(1.0), std::nullopt), std::invalid_argument);
  CHECK_THROWS_AS(check_seating(-10, -10, even_frames(1.0), std::nullopt), std::invalid_argument);
  CHECK_THROWS_AS(check_seating(0, 0, {}, std::nullopt), std::invalid_argument);
  SeatingFrames uneven = even_frames(1.0);
  uneven.unloaded_v.pop_back();
  CHECK_THROWS_AS(check_seating(10, 10, uneven, std::nullopt), std::invalid_argument);
}

TEST_CASE("seating bounds: the worst of several findings decides") {
  // A mean of 45 % fails, three new dead taxels warn.
  SeatingFrames now = even_frames(0.45);
  for (const std::size_t at : {3U, 14U, 25U}) now.loaded_v[at] = 0.3;
  const SeatingResult both = check_seating(10, 10, now, even_frames(1.0));
  CHECK(findings_of(both) == "fail deviation, warning dead-taxels");
  CHECK(both.verdict == "fail");
}

// Rows and columns of the seating check at each of their limits, from lines of one response each: by hand.

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
  for (const SeatingFinding& finding : check_lines(taxels, along_rows, lost)) {
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

TEST_CASE("seating lines: one below 8 % of the other lines' response is dead, with all of its taxels") {
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

TEST_CASE("seating lines alone: an edge below 15 % of the median is outside, with rising lines below 20 %") {
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

TEST_CASE("seating lines alone: an edge outside needs a line above 3 % of the others, else the lines are dead") {
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

TEST_CASE("seating lines alone: three lines are too few for an edge outside") {
  CHECK(judged(lines_answering({0.1, 1, 1, 1}, true), true).kinds == "edge-outside");
  CHECK(judged(lines_answering({0.1, 1, 1}, true), true).kinds.empty());
}

TEST_CASE("seating lines and the last seating: an edge below 50 % is outside, with lines below 80 %") {
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

TEST_CASE("seating lines: known dead taxels and crossing open lines are ignored, a quarter must be left") {
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

TEST_CASE("open lines: have nine of ten taxels below the least response of either sign") {
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
