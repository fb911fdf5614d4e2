// The dump valve opens at its time on the plant's grid, whether somebody has looked before or not.
#include <catch2/catch.hpp>
#include <chrono>

#include "tests/bench/simulation/small_plant.h"

using namespace tactbench;
using namespace tactbench::tests;
using namespace std::chrono_literals;

TEST_CASE("plant: a look at the pressure before the dump valve opens or closes changes nothing") {
  SmallPlant looked, unseen;
  for (SmallPlant* bed : {&looked, &unseen}) {
    bed->drive(3.0);
    bed->at(257ms);
    if (bed == &looked) (void)bed->plant.true_pressure();
    bed->plant.dump(true);
    bed->at(304ms);
    if (bed == &looked) (void)bed->plant.true_pressure();
    bed->plant.dump(false);
    bed->at(420ms);
  }
  CHECK(looked.plant.true_pressure().value() > 1.0);
  CHECK(looked.plant.true_pressure().value() == unseen.plant.true_pressure().value());
}
