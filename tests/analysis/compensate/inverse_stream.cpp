// Any model's inverse along a stream whose history is not known: by hand on a film of three cells.
#include "analysis/compensate/inverse_stream.h"

#include <catch2/catch.hpp>

#include "analysis/models/preisach.h"

using namespace tactbench::analysis;

TEST_CASE("stream by hand: of an unknown start one way rises and the other falls, each with a dead band of its own") {
  // Up 0, 1, 3 at 0, 30, 60; down from the top 3, 2, 0.
  const PreisachModel film(0.0, 60.0, 0.0, {1, 1, 1});
  InverseStream stream(film, 0.2);
  stream.reset_unknown();
  // 2 is 45 psi for the one that rose and 30 psi for the one that fell from the top.
  CHECK(stream.step(2.0) == Approx(37.5));
  // A tenth back is within the band. The one that rose reads the way back, 42 psi, and remembers nothing; the one that
  // fell goes on to 28.5 psi.
  CHECK(stream.step(1.9) == Approx(0.5 * (42.0 + 28.5)));
  // Up again it is at 45 psi; the other one comes by 1.95 at 30 psi to 2 at 31.5 psi.
  CHECK(stream.step(2.0) == Approx(0.5 * (45.0 + 31.5)));
}
