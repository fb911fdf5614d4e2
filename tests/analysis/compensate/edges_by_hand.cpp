// What compensators refuse, one wrong value at a time, and what their curves and streams do exactly at an edge.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "analysis/compensate/dynamic_frame_compensator.h"
#include "analysis/compensate/inverse_stream.h"
#include "analysis/models/elam_pieces.h"
#include "analysis/models/preisach.h"
#include "tests/analysis/compensate/straight_setup.h"

using namespace tactbench::analysis;

namespace {

// One taxel, 60 psi at 3 V, without hysteresis.
FrameSetup frame_of_one_line() {
  FrameSetup setup;
  setup.pressure_psi = {0.0, 30.0, 60.0};
  setup.taxels.push_back({true, {0.0, 1.5, 3.0}, {0.0, 1.5, 3.0}, {}, 0.001, false});
  setup.volts_per_count = 1e-4;
  return setup;
}

// Each of an output's lengths alone is wrong.
template <class Frames, class Setup>
void check_lengths(const Setup& setup) {
  Frames frames(setup);
  std::vector<double> psi(2), doubt(2);
  std::vector<std::uint16_t> status(2);
  const std::vector<std::uint16_t> counts(2, 100);
  const std::vector<double> volts(2, 1.0);
  const auto refuses = [&](std::size_t samples, std::size_t pressures, std::size_t doubts, std::size_t bits) {
    const typename Frames::Output output{std::span(psi).first(pressures), std::span(doubt).first(doubts),
                                         std::span(status).first(bits)};
    CHECK_THROWS_AS(frames.frame(std::span<const std::uint16_t>(counts).first(samples), output), std::invalid_argument);
    CHECK_THROWS_AS(frames.frame(std::span<const double>(volts).first(samples), output), std::invalid_argument);
    if (samples == 1) CHECK_THROWS_AS(frames.lost_frame(output), std::invalid_argument);
  };
  for (const std::size_t wrong : {0U, 2U}) {
    refuses(1, wrong, 1, 1);
    refuses(1, 1, wrong, 1);
    refuses(1, 1, 1, wrong);
  }
  refuses(2, 1, 1, 1);
  refuses(0, 1, 1, 1);
  refuses(2, 2, 2, 2);
  for (const std::size_t wrong : {0U, 2U})
    CHECK_THROWS_AS(frames.tare(std::span<const std::uint16_t>(counts).first(wrong)), std::invalid_argument);
}

}  // namespace

TEST_CASE("edges: frames of ELAM and dynamic ones refuse each wrong length alone, and a wrong size of a count") {
  check_lengths<FrameCompensator<double>>(frame_of_one_line());
  check_lengths<DynamicFrameCompensator<double>>(straight_setup(0.001));
  const auto dynamic = [](auto change) {
    DynamicSetup setup = straight_setup(0.001);
    change(setup);
    const DynamicFrameCompensator<double> frames(setup);
  };
  for (const double bad : {0.0, -1.0, std::numeric_limits<double>::infinity(), std::nan("")})
    CHECK_THROWS_WITH(dynamic([&](DynamicSetup& setup) { setup.volts_per_count = bad; }),
                      Catch::Contains("volts_per_count"));
  for (const double bad : {-std::numeric_limits<double>::denorm_min(), std::nan("")})
    CHECK_THROWS_WITH(dynamic([&](DynamicSetup& setup) { setup.tare_share = bad; }), Catch::Contains("tare_share"));
  CHECK_THROWS_WITH(dynamic([](DynamicSetup& setup) { setup.longest_gap = -1; }), Catch::Contains("longest_gap"));
  CHECK_THROWS_AS(dynamic([](DynamicSetup& setup) { setup.taxels.clear(); }), std::invalid_argument);
  CHECK_NOTHROW(dynamic([](DynamicSetup& setup) {
    setup.tare_share = 0.0;
    setup.longest_gap = 0;
  }));
}

TEST_CASE("edges: creep that takes exactly nine tenths, and an output exactly at its divider's end, are taken") {
  const auto taken = [](double share, double scale) {
    DynamicSetup setup = straight_setup();
    setup.dynamics.creep_share = {share, 0.0, 0.0};
    setup.taxels.front().creep_scale = scale;
    try {
      check_setup(setup);
      check_taxel(setup, setup.taxels.front());
    } catch (const std::invalid_argument&) {
      return false;
    }
    return true;
  };
  CHECK(taken(0.9, 1.0));
  CHECK(taken(0.45, 2.0));
  CHECK_FALSE(taken(std::nextafter(0.9, 1.0), 0.5));
  CHECK_FALSE(taken(0.45, std::nextafter(2.0, 3.0)));
  DynamicSetup setup = straight_setup();
  DynamicTaxel& taxel = setup.taxels.front();
  taxel.divider = {0.0, 1.0};  // an output of 1 V at most, 0.995 V are taken
  const double end = taxel.divider.linear_end();
  REQUIRE(taxel.divider.output(end) == 0.995);
  taxel.everett = {0.0, end, 0.0};
  CHECK_NOTHROW(check_taxel(setup, taxel));
  taxel.everett = {0.0, end + 1e-9, 0.0};
  CHECK_THROWS_AS(check_taxel(setup, taxel), std::invalid_argument);
}

TEST_CASE("edges: pieces of a curve from exactly a hundredth of the range are not resized where ends are exact") {
  const std::vector<double> x{0.0, 50.0, 100.0};
  const ElamModel model{PatternCurve(x, std::vector<double>{0.0, 1.0, 3.0}, 0.0, 3.0),
                        PatternCurve(x, std::vector<double>{0.0, 2.5, 3.0}, 0.0, 3.0),
                        {0.5, 0.5, 0.0, 0.5, 0.5},
                        {true}};
  const ElamPieces pieces{{1.0}, {-1.0}, {1.0}, {-1.0}};
  const auto resized = [&](bool ascending, double turn, double y) {
    const ElamCurve plain(model, ascending, turn, y);
    const ElamPiecedCurve pieced(model, pieces, ascending, turn, y);
    double most = 0.0;
    for (double at = 2.0; at < 99.0; at += 1.0) most = std::max(most, std::abs(plain.output(at) - pieced.output(at)));
    return most > 0.01;
  };
  CHECK_FALSE(resized(true, 1.0, 0.02));
  CHECK(resized(true, 1.001, 0.02));
  CHECK_FALSE(resized(false, 99.0, 2.99));
  CHECK(resized(false, 98.999, 2.99));
}

TEST_CASE("edges: a stream that is reset knows its history, whatever it was before") {
  const PreisachModel model(0.0, 60.0, 0.0, {0.0, 3.0, 0.0});
  InverseStream stream(model, 0.01), other(model, 0.01);
  stream.reset_unknown();
  CHECK(stream.step(1.5) < other.step(1.5));
  stream.reset();
  other.reset();
  for (const double output : {1.5, 1.7, 1.2}) {
    CHECK(stream.reads(output) == other.reads(output));
    CHECK(stream.step(output) == other.step(output));
  }
}

TEST_CASE("edges: a still output that turns slowly, and at once turns again, is read by frames as by the plain form") {
  const DynamicSetup setup = straight_setup(0.01);
  const DynamicSetup rounded = with_rounding(setup);
  DynamicSetup at_rest = setup;
  at_rest.start_unknown = false;
  for (int step_mv = 2; step_mv <= 16; ++step_mv) {
    DynamicFrameCompensator<double> frames(at_rest);
    DynamicTaxelCompensator plain(rounded, 0);
    const auto both_read = [&](double volts) {
      double psi = 0.0, doubt = 0.0;
      std::uint16_t status = 0;
      frames.frame(std::span<const double>(&volts, 1), {{&psi, 1}, {&doubt, 1}, {&status, 1}});
      const Compensated one = plain.step(volts, 0.0);
      CAPTURE(step_mv, volts);
      CHECK(psi == Approx(one.pressure_psi).margin(1e-9));
      CHECK(doubt == Approx(one.uncertainty_psi).margin(1e-6));
    };
    double volts = 3.5;
    for (int i = 0; i < 60; ++i) both_read(volts);
    for (int turn = 0; turn < 6; ++turn) {
      const bool rises = plain.ascending();
      for (int i = 0; i < 40 && plain.ascending() == rises; ++i) both_read(volts += (rises ? -0.001 : 0.001) * step_mv);
    }
  }
}
