// What `verify` calls equal, and what it names first.
#include "analysis/identify/stored/fit_rows.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

FitRows example_rows() {
  FitRows rows;
  rows.fit.patterns_json = R"({"rows":1,"columns":1,"pressure_psi":[0,30,60],"full_scale_v":3.5,"falling":false})";
  rows.fit.summary_json = R"({"j_v2":0.5,"taxels":{"fitted":1}})";
  for (const int taxel : {-1, 0}) {
    db::FitTaxelRecord& row = rows.taxels.emplace_back();
    row.taxel = taxel;
    row.status = "fitted";
    row.parameters = {0.1, 0.2, -0.003, 0.4, 0.5};
    row.ascending_v = {0.0, 1.0, 2.0};
    row.descending_v = {0.0, 1.5, 2.0};
    row.noise_v = 1e-3;
  }
  return rows;
}

}  // namespace

TEST_CASE("numbers are equal bit for bit, or within the tolerance that is given") {
  CHECK(same_number(0.1 + 0.2, 0.1 + 0.2, 0.0));
  CHECK_FALSE(same_number(0.1 + 0.2, 0.3, 0.0));
  CHECK(same_number(0.1 + 0.2, 0.3, kRelativeTolerance));
  CHECK_FALSE(same_number(1.0, 1.0 + 1e-11, kRelativeTolerance));
  CHECK_FALSE(same_number(0.0, 1e-300, kRelativeTolerance));
  CHECK(same_number(0.0, -0.0, 0.0));
  CHECK(same_number(std::nan(""), -std::nan(""), 0.0));
  CHECK_FALSE(same_number(std::nan(""), 1.0, 1.0));
  CHECK_FALSE(same_number(INFINITY, 1.0, kRelativeTolerance));
}

TEST_CASE("the first thing in which a stored fit differs is named") {
  const FitRows rows = example_rows();
  CHECK(first_difference(rows, rows, 0.0).empty());
  const auto named = [&](auto change, double tolerance = 0.0) {
    FitRows stored = example_rows();
    change(stored);
    return first_difference(stored, rows, tolerance);
  };
  using Catch::StartsWith;
  const auto nudge = [](FitRows& r) { r.taxels[1].parameters[2] *= 1.0 + 1e-15; };
  CHECK_THAT(named(nudge), StartsWith("taxel 0, alpha_a1: stored -0.003"));
  CHECK(named(nudge, kRelativeTolerance).empty());
  CHECK_THAT(named([](FitRows& r) { r.taxels[0].descending_v[1] = 1.6; }),
             StartsWith("mean taxel, descending_v[1]: stored 1.6"));
  CHECK_THAT(named([](FitRows& r) { r.taxels[1].ascending_v.pop_back(); }),
             StartsWith("taxel 0, ascending_v: 2 numbers"));
  CHECK_THAT(named([](FitRows& r) { r.taxels[1].parameters.clear(); }), StartsWith("taxel 0, parameters: 0 numbers"));
  CHECK_THAT(named([](FitRows& r) { r.taxels[1].status = "dead"; }), StartsWith("taxel 0, status: stored 'dead'"));
  CHECK_THAT(named([](FitRows& r) { r.taxels[1].noise_v = NAN; }), StartsWith("taxel 0, noise_v: stored nan"));
  CHECK_THAT(named([](FitRows& r) { r.taxels[1].at_bound = 4; }), StartsWith("taxel 0, at_bound"));
  CHECK(named([](FitRows& r) { r.taxels.pop_back(); }) == "taxel 0: not stored");
  CHECK_THAT(named([](FitRows& r) { r.taxels.back().taxel = 7; }), StartsWith("taxel 0: not stored"));
  CHECK_THAT(named([](FitRows& r) { r.taxels.emplace_back().taxel = 7; }), StartsWith("taxel 7: stored, but"));
  CHECK_THAT(named([](FitRows& r) { r.fit.summary_json = R"({"j_v2":0.25,"taxels":{"fitted":1}})"; }),
             StartsWith("summary.j_v2: stored 0.25"));
  CHECK_THAT(named([](FitRows& r) { r.fit.summary_json = "{"; }), StartsWith("summary: what is stored cannot be read"));
  CHECK_THAT(named([](FitRows& r) { r.fit.patterns_json = R"({"rows":1})"; }),
             StartsWith("grid and full scale.columns: stored 'nothing'"));
  // Stores of older programs did not keep whether the output falls.
  CHECK(named([](FitRows& r) {
          r.fit.patterns_json = R"({"rows":1,"columns":1,"pressure_psi":[0,30,60],"full_scale_v":3.5})";
        }).empty());
}

TEST_CASE("verdicts are compared word by word and number by number") {
  db::VerdictRecord verdict;
  verdict.criterion = "mean_compensation_error";
  verdict.scope = "array";
  verdict.value = 0.5;
  verdict.limit = 1.0;
  verdict.verdict = "pass";
  const std::vector<db::VerdictRecord> own = {verdict};
  CHECK(first_difference(own, own, 0.0).empty());
  verdict.verdict = "fail";
  CHECK(first_difference({verdict}, own, 0.0) ==
        "verdict on mean_compensation_error (array): stored 'fail', recomputed 'pass'");
  verdict.value = 0.25;
  CHECK_THAT(first_difference({verdict}, own, 0.0), Catch::Contains("value: stored 0.25, recomputed 0.5"));
  verdict.scope = "40 psi";
  CHECK_THAT(first_difference({verdict}, own, 0.0), Catch::StartsWith("verdict 1: stored"));
  CHECK(first_difference(std::vector<db::VerdictRecord>{}, own, 0.0) == "0 verdicts stored, 1 recomputed");
}

TEST_CASE("the program that made a fit is read from its options, and damaged options are refused") {
  db::FitRecord fit;
  fit.options_json = R"({"exact_outer":true,"made_by":"commit abc"})";
  CHECK(made_by(fit) == "commit abc");
  CHECK(options_of(fit).exact_outer);
  fit.options_json = R"({"exact_outer":false})";
  CHECK(made_by(fit).empty());
  for (const char* damaged : {"", "{", "[]", R"({"exact_outer":"x","made_by":7})"}) {
    fit.options_json = damaged;
    CHECK(made_by(fit).empty());
    CHECK_THROWS_AS(options_of(fit), AnalysisError);
  }
}
