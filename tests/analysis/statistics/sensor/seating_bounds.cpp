// The seating check as a whole at each of its limits, on patterns whose correlation is known.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "analysis/statistics/sensor/seating.h"

using namespace tactbench::analysis;

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

TEST_CASE("seating bounds: a pattern that resembles the last one by 0.9 passes, by 0.8 warns, by less fails") {
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

TEST_CASE("seating bounds: another position fits by 0.8 at least") {
  const SeatingResult turned = resembling(0.81, -1.0), other = resembling(0.79, -1.0);
  REQUIRE(findings_of(turned) == "fail turned");
  CHECK_THAT(turned.findings[0].text, Catch::Contains("180") && Catch::Contains(" 0.81") && Catch::Contains("-0.81"));
  CHECK(*turned.correlation == Approx(-0.81));
  CHECK(findings_of(other) == "fail deviation");
}

TEST_CASE("seating bounds: another position fits better by 0.2 than the last one") {
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

TEST_CASE("seating bounds: patterns are compared from a spread of 5 % on, of sixteen taxels that answer") {
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

TEST_CASE("seating bounds: the mean may differ by a fifth, by half it fails, and only at pressures within half a psi") {
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

TEST_CASE("seating bounds: taxels below 10 mV are dead one by one, and more than 2 % of them are a warning") {
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

TEST_CASE("seating bounds: an array answers when a tenth of its taxels does by 20 mV") {
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

TEST_CASE("seating bounds: of several findings the worst counts, in whatever order they come") {
  // A mean of 45 % fails, three new dead taxels warn.
  SeatingFrames now = even_frames(0.45);
  for (const std::size_t at : {3U, 14U, 25U}) now.loaded_v[at] = 0.3;
  const SeatingResult both = check_seating(10, 10, now, even_frames(1.0));
  CHECK(findings_of(both) == "fail deviation, warning dead-taxels");
  CHECK(both.verdict == "fail");
}
