// Pressures typed with a unit: as text, and as --set of recipes.
#include "sequences/pressure_text.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "sequences/recipe.h"

using namespace tactbench::sequences;

namespace {

constexpr const char* kRecipe =
    "schema = 1\nname = \"r\"\nunit = \"kPa\"\nturning_points = [0, 400, 0]\nstep = \"$step\"\n"
    "[conditioning]\ncycles = 1\npeak = 300\n"
    "[parameters.step]\ndefault = 100\nlow = 10\nhigh = 400\nunit = \"kPa\"\n";

Recipe with(const std::vector<Override>& overrides) {
  return parse_recipe(TomlDocument::from_text(kRecipe, "r.toml"), overrides);
}

}  // namespace

TEST_CASE("a typed pressure has a number and a unit, in any case") {
  CHECK(*typed_pressure_psi("3 psi") == 3.0);
  CHECK(*typed_pressure_psi("413.6854375901kPa") == Approx(60.0));
  CHECK(*typed_pressure_psi(" 2BAR ") == Approx(29.0075475));
  CHECK(*typed_pressure_psi("-0.5 psi") == -0.5);
  for (const char* other : {"", "3", "kPa", "3 mbar", "3 psi 4", "nan psi", "0x3 psi", "3psi/s"})
    CHECK_FALSE(typed_pressure_psi(other).has_value());
  // Blanks before, between and behind, as many as there are.
  for (const char* blanks : {"3 psi ", " 3 psi", " 3psi ", "  3  psi  ", "\t 3 \t psi \t"})
    CHECK(typed_pressure_psi(blanks) == 3.0);
  for (const char* none : {" ", " \t ", "\n3 psi", "3\npsi"}) CHECK_FALSE(typed_pressure_psi(none).has_value());
  const std::string_view digit = std::string_view("25 psi").substr(0, 1);  // what lies behind it is no part of it
  CHECK_FALSE(typed_pressure_psi(digit).has_value());
  CHECK(as_number_in("kPa", "2 bar") == "200");
  CHECK(as_number_in("psi", "12.5") == "12.5");    // a bare number keeps the unit of its key
  CHECK(as_number_in("s", "20 kPa") == "20 kPa");  // a time is no pressure: the key's own error follows
}

TEST_CASE("recipe: a parameter and a key of pressure take other units, a bare number the recipe's") {
  CHECK(with({{"step", "0.5bar"}}).step.value() == Approx(50.0 / 6.894757293168));
  CHECK(with({{"step", "50"}}).step.value() == Approx(50.0 / 6.894757293168));
  CHECK(with({{"conditioning.peak", "30 psi"}}).conditioning.peak.value() == Approx(30.0));
  CHECK(with({{"step", "50"}, {"unit", "psi"}, {"turning_points", "[0, 50, 0]"}, {"conditioning.peak", "200kPa"}})
            .conditioning.peak.value() == Approx(200.0 / 6.894757293168));
  // The unit that is typed counts for all, wherever it stands.
  const Recipe psi = with({{"turning_points", "[0, 50, 0]"}, {"step", "25"}, {"unit", "psi"}});
  CHECK((psi.turning_points[1].value() == 50.0 && psi.step.value() == 25.0));
  CHECK(psi.conditioning.peak.value() == 300.0);
  CHECK_THROWS_WITH(with({{"step", "5kPa"}}), Catch::Contains("5kPa") && Catch::Contains("10 to 400"));
  CHECK_THROWS_AS(with({{"step", "20psi"}, {"step", "5"}}), FileError);
  CHECK_THROWS_AS(with({{"step", "5"}}), FileError);
  CHECK_THROWS_AS(with({{"dwell_s", "2kPa"}}), FileError);
}
