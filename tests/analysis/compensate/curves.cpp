// The curves of the compensator: pieces are correct for all of their outputs, ELAM's curves equal the paper's.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/compensate/curves.h"
#include "analysis/compensate/turning.h"
#include "tests/analysis/compensate/kinds.h"

using namespace synthetic;

namespace {

std::shared_ptr<const PreisachCurve::Film> film_table(const PreisachModel& model, double per_amplitude) {
  auto film = std::make_shared<PreisachCurve::Film>();
  *film = {model.x_low(), model.x_high(), model.intervals(), {0.0, per_amplitude}, {}};
  const auto at = [&](std::size_t i) {
    return model.x_low() + (model.x_high() - model.x_low()) * static_cast<double>(i) / static_cast<double>(film->n);
  };
  for (std::size_t i = 0; i <= film->n; ++i)
    for (std::size_t j = 0; j <= i; ++j) film->everett.push_back(model.everett(at(i), at(j)));
  return film;
}

// Along drawn turns, of which many close loops: what a piece says of any of its outputs, asked for or gone to, is what
// the curve says there.
template <class Curve>
void check_pieces(Curve curve, unsigned seed) {
  Random draw(seed);
  const double top = curve.top(), span = curve.x_high() - curve.x_low();
  bool rises = true;
  double from = 0.0;
  std::vector<double> turns(4, 0.0);
  curve.start(false);
  for (int turn = 0; turn < 400; ++turn) {
    double furthest = from;
    Curve gone_on = curve;
    CurvePiece kept;
    for (int i = 0; i < 12; ++i) {
      const double share = 0.1 * i * draw(0.2, 1.0);
      double y = rises ? from + share * (1.02 * top - from) : from * (1 - share);
      // Exactly where a loop closes.
      const double earlier = turns[turns.size() - 1 - static_cast<std::size_t>(draw(0.0, 3.999))];
      if (i % 3 == 2 && (rises ? earlier > from : earlier < from)) y = earlier;
      const double u = curve.place(y);
      const CurvePiece piece = curve.piece(u);
      REQUIRE(piece.holds(u));
      // Ahead: behind may lie a loop that closed on the way.
      const double ahead =
          rises ? std::min(piece.high, curve.place(1.1 * top)) : std::max(piece.low, curve.place(-0.1 * top));
      const double other = u + draw(0.0, 1.0) * (ahead - u);
      INFO("turn " << turn << ", " << (rises ? "rising" : "falling") << " from " << from << ": the piece of " << y);
      REQUIRE(curve.piece(other).along(other) == Approx(piece.along(other)).margin(1e-7 * span));
      const double x = curve.input(piece.along(u));
      REQUIRE((x >= curve.x_low() - 1e-9 * span && x <= curve.x_high() + 1e-9 * span));
      if (rises ? y < furthest : y > furthest) continue;
      // As a stream walks: it goes where its kept piece ends, and a jump lands on the same.
      furthest = y;
      if (!kept.holds(u)) {
        gone_on.go(u);
        kept = gone_on.piece(u);
      }
      REQUIRE(kept.along(u) == Approx(piece.along(u)).margin(1e-7 * span));
    }
    curve = gone_on;
    curve.turn(curve.back_from(curve.place(furthest), curve.piece(curve.place(furthest))));
    turns.push_back(from = furthest);
    rises = !rises;
    if (rises ? from < 0.001 * top : from > 0.999 * top) {  // at an end it does not turn again at once
      curve.start(rises ? false : true);
      from = rises ? 0.0 : top;
    }
  }
}

}  // namespace

TEST_CASE("curve pieces: equal the curve up to the end of their branch, along nested loops that close") {
  for (const unsigned seed : {1U, 2U, 3U})
    for (const Kind& kind : kinds()) {
      if (kind.in_time) continue;
      INFO(kind.name << ", seed " << seed);
      check_pieces(StateCurve(*kind.truth, 0.0), seed);
      if (kind.name == "elam") check_pieces(ElamStack(dynamic_cast<const ElamHysteresis&>(*kind.model).elam()), seed);
    }
  for (const unsigned seed : {1U, 2U, 3U})
    for (const double per_amplitude : {0.0, 0.13}) {
      INFO("table, seed " << seed);
      check_pieces(PreisachCurve(film_table(film_of(seed, 20), per_amplitude)), seed);
      check_pieces(PreisachCurve(film_table(random_preisach(seed, 30), 0.0)), seed);
    }
}

TEST_CASE("ElamStack: branches that leave the external loop equal the paper's curves") {
  ArrayOptions options;
  options.rows = options.columns = 3;
  for (ElamModel model : Array(options).taxels)
    for (const bool exact : {false, true}) {
      model.options.exact_outer = exact;
      const double y0 = model.y0(), yu = model.yu();
      ElamStack stack(model);
      const auto compare = [&](const ElamCurve& paper, double y) {
        REQUIRE(stack.piece(y - y0).along(y - y0) == Approx(paper.input(y)).margin(1e-9));
      };
      const ElamCurve up(model, true, model.x0(), y0), down(model, false, model.xu(), yu);
      for (int i = 0; i <= 60; ++i) {
        // Rising to x, and down from there: Eqs (31) to (34), but not where the drift's allowance moves the split.
        const double y = y0 + (yu - y0) * i / 60.0, x = up.input(y);
        stack.start(false);
        compare(up, y);
        stack.turn(stack.back_from(y - y0, stack.piece(y - y0)));
        if (yu - y > 2.0 * ElamStack::kDriftShare * (yu - y0) || i == 60)
          for (int k = 0; k <= 40; ++k)
            compare(i == 60 ? down : ElamCurve(model, false, x, y), y0 + (y - y0) * k / 40.0);
        // Falling from the top, and up from there: Eqs (35) to (38).
        stack.start(true);
        compare(down, y);
        stack.turn(stack.back_from(y - y0, stack.piece(y - y0)));
        if (i > 0 && i < 60)
          for (int k = 0; k <= 40; ++k) compare(ElamCurve(model, true, down.input(y), y), y + (yu - y) * k / 40.0);
      }
    }
}

TEST_CASE("TurningCompensator: cached curve pieces and an uncached curve give the same readings on noisy holds") {
  const PreisachModel film = film_of(1, 60);  // a state's pieces have no length: nothing is kept of it
  const double top = film.everett(film.x_high(), film.x_low());
  CompensatorSetup setup;
  setup.zero = film.y_low();
  setup.noise = 0.02 * top;
  TurningCompensator<PreisachCurve> kept(PreisachCurve(film_table(film, 0.0)), setup);
  TurningCompensator<StateCurve> asked(StateCurve(film, 0.0), setup);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, setup.noise);
  for (const double level : {0.3, 0.7, 0.5, 0.2, 0.6})
    for (int i = 0; i < 400; ++i) {
      const double output = setup.zero + top * level + noise(random);
      const Compensated a = kept.step(output, 0.0), b = asked.step(output, 0.0);
      REQUIRE(a.pressure_psi == Approx(b.pressure_psi).margin(1e-6 * (film.x_high() - film.x_low())));
      REQUIRE(a.uncertainty_psi == Approx(b.uncertainty_psi).epsilon(1e-6));
    }
}
