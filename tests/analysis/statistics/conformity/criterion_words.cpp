// Criteria and scopes as people read them.
#include "analysis/statistics/conformity/criterion_words.h"

#include <catch2/catch.hpp>

using namespace tactbench::analysis;

TEST_CASE("criteria in words, each of the six, and one that is not known without its underlines") {
  CHECK(criterion_in_words("mean_compensation_error") == "mean absolute error");
  CHECK(criterion_in_words("worst_taxel_error") == "worst taxel's mean error");
  CHECK(criterion_in_words("distance_of_mean") == "hysteresis of the mean");
  CHECK(criterion_in_words("unfit_taxels") == "taxels not modelled");
  CHECK(criterion_in_words("mismatch") == "non-uniformity");
  CHECK(criterion_in_words("mpe") == "maximum permissible error");
  CHECK(criterion_in_words("a_new_one") == "a new one");
  CHECK(criterion_in_words("").empty());
}

TEST_CASE("scopes in words: the branch spelled out at the end alone, pressures in the reader's unit") {
  CHECK(scope_in_words("40 psi up", PressureUnit::kPsi) == "40 psi increasing");
  CHECK(scope_in_words("40 psi down", PressureUnit::kPsi) == "40 psi decreasing");
  CHECK(scope_in_words("array", PressureUnit::kPsi) == "array");
  CHECK(scope_in_words("up there", PressureUnit::kPsi) == "up there");
  CHECK(scope_in_words("0-60 psi 95 %", PressureUnit::kPsi) == "0-60 psi 95 %");
  CHECK(scope_in_words("40 psi up", PressureUnit::kKilopascal) == "275.8 kPa increasing");
  CHECK(scope_in_both_units("40 psi down", PressureUnit::kKilopascal) == "275.8 kPa (40 psi) decreasing");
}
