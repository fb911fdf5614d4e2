// What `verify` compares of a fit and of verdicts, column by column: each is looked at, and named when it differs.
#include <catch2/catch.hpp>
#include <limits>
#include <string>
#include <vector>

#include "analysis/identify/stored/fit_rows.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

FitRows compared_rows() {
  FitRows rows;
  rows.fit.patterns_json = R"({"rows":1,"list":[1,2,{"deep":3}],"falling":false})";
  rows.fit.summary_json = R"({"j_v2":0.5})";
  db::FitTaxelRecord& row = rows.taxels.emplace_back();
  row.taxel = 4;
  row.status = "fitted";
  row.parameters = {1, 2, 3, 4, 5};
  row.ascending_v = {0, 1};
  row.descending_v = {0, 2};
  row.noise_v = 6;
  row.j_v2 = 7;
  row.mean_error_v = 8;
  row.max_error_v = 9;
  row.full_scale_v = 10;
  row.at_bound = 11;
  return rows;
}

template <class Change>
std::string differs(const Change& change, double tolerance = 0.0) {
  FitRows stored = compared_rows();
  change(stored);
  return first_difference(stored, compared_rows(), tolerance);
}

std::string patterns_differ(const std::string& stored, const std::string& recomputed) {
  FitRows a = compared_rows(), b = compared_rows();
  a.fit.patterns_json = stored;
  b.fit.patterns_json = recomputed;
  return first_difference(a, b, 0.0);
}

std::string documents_differ(const std::string& stored, const std::string& recomputed) {
  FitRows a, b;
  a.fit.patterns_json = stored;
  b.fit.patterns_json = recomputed;
  a.fit.summary_json = "{";  // of a document it is not looked at
  return first_difference(a, b, 0.0);
}

db::VerdictRecord compared_verdict() {
  db::VerdictRecord verdict;
  verdict.criterion = "c";
  verdict.scope = "s";
  verdict.value = 1;
  verdict.limit = 2;
  verdict.unit = "psi";
  verdict.rule = "<=";
  verdict.verdict = "pass";
  verdict.limits_sha256 = "ab";
  return verdict;
}

template <class Change>
std::string verdict_differs(const Change& change, double tolerance = 0.0) {
  db::VerdictRecord stored = compared_verdict();
  change(stored);
  return first_difference({compared_verdict(), stored}, {compared_verdict(), compared_verdict()}, tolerance);
}

}  // namespace

TEST_CASE("columns of a stored fit: each one is compared, and named") {
  CHECK(differs([](FitRows&) {}).empty());
  const char* const names[] = {"alpha_d", "beta_d", "alpha_a1", "alpha_a0", "beta_a"};
  for (std::size_t k = 0; k < 5; ++k) {
    const std::string at = std::to_string(k + 1);
    CHECK(differs([&](FitRows& r) { r.taxels[0].parameters[k] = 0.5; }) ==
          "taxel 4, " + std::string(names[k]) + ": stored 0.5, recomputed " + at);
  }
  CHECK(differs([](FitRows& r) { r.taxels[0].ascending_v[1] = 3; }) ==
        "taxel 4, ascending_v[1]: stored 3, recomputed 1");
  CHECK(differs([](FitRows& r) { r.taxels[0].descending_v[0] = 3; }) ==
        "taxel 4, descending_v[0]: stored 3, recomputed 0");
  CHECK(differs([](FitRows& r) { r.taxels[0].descending_v.push_back(3); }) ==
        "taxel 4, descending_v: 3 numbers stored, 2 recomputed");
  CHECK(differs([](FitRows& r) { r.taxels[0].parameters.resize(1); }) ==
        "taxel 4, parameters: 1 number stored, 5 recomputed");
  CHECK(differs([](FitRows& r) { r.taxels[0].noise_v = 0.5; }) == "taxel 4, noise_v: stored 0.5, recomputed 6");
  CHECK(differs([](FitRows& r) { r.taxels[0].j_v2 = 0.5; }) == "taxel 4, j_v2: stored 0.5, recomputed 7");
  CHECK(differs([](FitRows& r) { r.taxels[0].mean_error_v = 0.5; }) ==
        "taxel 4, mean_error_v: stored 0.5, recomputed 8");
  CHECK(differs([](FitRows& r) { r.taxels[0].max_error_v = 0.5; }) == "taxel 4, max_error_v: stored 0.5, recomputed 9");
  CHECK(differs([](FitRows& r) { r.taxels[0].full_scale_v = 0.5; }) ==
        "taxel 4, full_scale_v: stored 0.5, recomputed 10");
  CHECK(differs([](FitRows& r) { r.taxels[0].at_bound = 1; }) == "taxel 4, at_bound: stored 1, recomputed 11");
  CHECK(differs([](FitRows& r) { r.taxels[0].status = "unfit"; }) ==
        "taxel 4, status: stored 'unfit', recomputed 'fitted'");
  CHECK(differs([](FitRows& r) { r.taxels.clear(); }) == "taxel 4: not stored");
  CHECK(differs([](FitRows& r) {
          r.taxels.emplace_back().taxel = 6;
          r.taxels.emplace_back().taxel = 5;
        }) == "taxel 5: stored, but the run has no such taxel");
  CHECK(differs([](FitRows& r) { r.taxels.emplace_back().taxel = -1; }) ==
        "mean taxel: stored, but the run has no such taxel");
  CHECK(differs([](FitRows& r) { r.taxels[0].j_v2 = 7.0 + 6e-12; }, 1e-12).empty());
  CHECK_FALSE(differs([](FitRows& r) { r.taxels[0].j_v2 = 7.0 + 8e-12; }, 1e-12).empty());
}

TEST_CASE("columns of a stored fit: its documents are compared member by member, as deep as they go") {
  const std::string whole = compared_rows().fit.patterns_json, grid = "grid and full scale";
  CHECK(patterns_differ(whole, whole).empty());
  CHECK(patterns_differ(R"({"rows":1,"list":[1,2,{"deep":4}],"falling":false})", whole) ==
        grid + ".list[2].deep: stored 4, recomputed 3");
  CHECK(patterns_differ(R"({"rows":1,"list":[1,2],"falling":false})", whole) ==
        grid + R"(.list: stored '[1,2]', recomputed '[1,2,{"deep":3}]')");
  CHECK(patterns_differ(R"({"rows":"1","list":[1,2,{"deep":3}],"falling":false})", whole) ==
        grid + R"(.rows: stored '"1"', recomputed '1')");
  CHECK(patterns_differ(R"({"rows":1,"x":2})", R"({"rows":1})") == grid + ".x: stored '2', recomputed 'nothing'");
  CHECK(patterns_differ(R"({"rows":1})", R"({"rows":1,"x":2})") == grid + ".x: stored 'nothing', recomputed '2'");
  // What older programs did not keep is looked at only where it is stored.
  for (const char* const name : {"residual_psi", "undetermined"}) {
    const std::string one = std::string(R"({")") + name + R"(":[1]})", two = std::string(R"({")") + name + R"(":[2]})";
    CHECK(patterns_differ("{}", one).empty());
    CHECK(patterns_differ(one, one).empty());
    CHECK(patterns_differ(two, one) == grid + "." + name + "[0]: stored 2, recomputed 1");
    CHECK(patterns_differ(one, "{}") == grid + "." + name + ": stored '[1]', recomputed 'nothing'");
  }
  CHECK(patterns_differ("{}", R"({"falling":false})").empty());
  CHECK(patterns_differ("{}", R"({"falling":true})") == grid + ".falling: stored 'nothing', recomputed 'true'");
  CHECK(patterns_differ("{}", R"({"other":false})") == grid + ".other: stored 'nothing', recomputed 'false'");
  CHECK(patterns_differ("", whole) == grid + ": what is stored cannot be read");
  CHECK(documents_differ(R"({"a":{"b":1}})", R"({"a":{"b":1}})").empty());
  CHECK(documents_differ(R"({"a":{"b":1}})", R"({"a":{"b":2}})") == "model.a.b: stored 1, recomputed 2");
  CHECK(documents_differ("x", "{}") == "model: what is stored cannot be read");
}

TEST_CASE("columns of verdicts: each one is compared, and named") {
  CHECK(verdict_differs([](db::VerdictRecord&) {}).empty());
  CHECK(verdict_differs([](db::VerdictRecord& v) { v.criterion = "d"; }) ==
        "verdict 2: stored 'd (s)', recomputed 'c (s)'");
  CHECK(verdict_differs([](db::VerdictRecord& v) { v.scope = "t"; }) ==
        "verdict 2: stored 'c (t)', recomputed 'c (s)'");
  CHECK(verdict_differs([](db::VerdictRecord& v) { v.value = 3; }) ==
        "verdict on c (s), value: stored 3, recomputed 1");
  CHECK(verdict_differs([](db::VerdictRecord& v) { v.limit = 3; }) ==
        "verdict on c (s), limit: stored 3, recomputed 2");
  CHECK(verdict_differs([](db::VerdictRecord& v) { v.value = 1.0 + 1e-13; }, 1e-12).empty());
  CHECK(verdict_differs([](db::VerdictRecord& v) { v.unit = "V"; }) ==
        "verdict on c (s), unit: stored 'V', recomputed 'psi'");
  CHECK(verdict_differs([](db::VerdictRecord& v) { v.rule = ">"; }) ==
        "verdict on c (s), rule: stored '>', recomputed '<='");
  CHECK(verdict_differs([](db::VerdictRecord& v) { v.verdict = "fail"; }) ==
        "verdict on c (s): stored 'fail', recomputed 'pass'");
  CHECK(verdict_differs([](db::VerdictRecord& v) { v.limits_sha256 = "cd"; }) ==
        "limits, SHA-256: stored 'cd', recomputed 'ab'");
  const std::vector<db::VerdictRecord> one{compared_verdict()}, two{compared_verdict(), compared_verdict()};
  CHECK(first_difference(one, two, 0.0) == "1 verdict stored, 2 recomputed");
  CHECK(first_difference(two, one, 0.0) == "2 verdicts stored, 1 recomputed");
}

TEST_CASE("numbers of a stored fit: infinite ones equal themselves alone, and the tolerance is of the larger one") {
  const double most = std::numeric_limits<double>::infinity();
  CHECK(same_number(most, most, 0.0));
  CHECK_FALSE(same_number(most, -most, 1.0));
  CHECK_FALSE(same_number(1.0, most, 1.0));
  CHECK_FALSE(same_number(1.0, std::numeric_limits<double>::quiet_NaN(), 1.0));
  CHECK(same_number(-100.0, -75.0, 0.25));
  CHECK(same_number(75.0, 100.0, 0.25));
  CHECK_FALSE(same_number(74.0, 100.0, 0.25));
  CHECK_FALSE(same_number(-0.5, 0.5, 0.9));
}
