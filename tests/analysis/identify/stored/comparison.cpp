// What `verify` calls equal, and what it names first.
#include "analysis/identify/stored/comparison.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

const char* const kDocument = R"({"model":"elam","list":[1,2],"taxels":[
  {"taxel":4,"status":"fitted","noise":0.001,"model":{"x":[0.0,60.0],"parameters":{"alpha_d":-0.003}}},
  {"taxel":-1,"status":"dead","noise":null}]})";

std::string differs(const char* pointer, const nlohmann::json& stored, double tolerance = 0.0) {
  nlohmann::json changed = nlohmann::json::parse(kDocument);
  changed[nlohmann::json::json_pointer(pointer)] = stored;
  return first_difference(changed.dump(), kDocument, tolerance);
}

}  // namespace

TEST_CASE("numbers are equal within the tolerance that is given, which is of the larger one") {
  const double infinite = INFINITY, none = std::nan("");
  struct Row {
    double a, b, tolerance;
    bool same;
  };
  for (const Row& row : std::vector<Row>{{0.1 + 0.2, 0.1 + 0.2, 0.0, true},
                                         {0.1 + 0.2, 0.3, 0.0, false},
                                         {0.1 + 0.2, 0.3, kRelativeTolerance, true},
                                         {1.0, 1.0 + 1e-11, kRelativeTolerance, false},
                                         {0.0, 1e-300, kRelativeTolerance, false},
                                         {0.0, -0.0, 0.0, true},
                                         {-100.0, -75.0, 0.25, true},
                                         {74.0, 100.0, 0.25, false},
                                         {-0.5, 0.5, 0.9, false},
                                         {none, -none, 0.0, true},
                                         {none, 1.0, 1.0, false},
                                         {infinite, infinite, 0.0, true},
                                         {infinite, -infinite, 1.0, false},
                                         {infinite, 1.0, 1.0, false}}) {
    CAPTURE(row.a, row.b, row.tolerance);
    CHECK(same_number(row.a, row.b, row.tolerance) == row.same);
    CHECK(same_number(row.b, row.a, row.tolerance) == row.same);
  }
}

TEST_CASE("of two documents the first member that differs is named, those of a taxel with its number") {
  CHECK(first_difference(std::string(kDocument), kDocument, 0.0).empty());
  struct Row {
    const char* pointer;
    nlohmann::json stored;
    const char* named;
  };
  for (const Row& row : std::vector<Row>{{"/model", "gpi", "model.model"},
                                         {"/model", 7, "model.model"},
                                         {"/list/1", 3, "model.list[1]"},
                                         {"/list", nlohmann::json{1}, "model.list"},
                                         {"/more", true, "model.more"},
                                         {"/taxels/0/noise", 0.002, "taxel 4.noise"},
                                         {"/taxels/0/noise", nullptr, "taxel 4.noise"},
                                         {"/taxels/0/model/x/1", 61.0, "taxel 4.model.x[1]"},
                                         {"/taxels/0/model/parameters/alpha_d", 0.0, "alpha_d"},
                                         {"/taxels/1/status", "fitted", "mean taxel.status"},
                                         {"/taxels/0/taxel", 5, "taxel 4.taxel"}}) {
    CAPTURE(row.pointer);
    CHECK_THAT(differs(row.pointer, row.stored), Catch::Contains(row.named));
  }
  CHECK_FALSE(first_difference(std::string("{"), kDocument, 0.0).empty());
  CHECK_THAT(first_difference(std::string("{}"), kDocument, 0.0), Catch::Contains("model."));
}

TEST_CASE("documents are compared by the bits of their numbers, or within a tolerance") {
  const char* const parameter = "/taxels/0/model/parameters/alpha_d";
  CHECK_FALSE(differs(parameter, std::nextafter(-0.003, 0.0)).empty());
  CHECK(differs(parameter, std::nextafter(-0.003, 0.0), kRelativeTolerance).empty());
  CHECK_FALSE(differs("/taxels/0/model/x/0", -0.0).empty());
  CHECK(differs("/taxels/0/model/x/0", -0.0, kRelativeTolerance).empty());
}

TEST_CASE("verdicts are compared member by member") {
  db::VerdictRecord own;
  own.criterion = "mpe";
  own.value = 1.0;
  own.limit = 2.0;
  own.verdict = "pass";
  const auto named = [&](const std::function<void(db::VerdictRecord&)>& change, double tolerance = 0.0) {
    db::VerdictRecord stored = own;
    change(stored);
    return first_difference({own, stored}, {own, own}, tolerance);
  };
  using V = db::VerdictRecord;
  CHECK(named([](V&) {}).empty());
  CHECK_THAT(named([](V& v) { v.criterion = "d"; }), Catch::StartsWith("verdict 2"));
  for (const auto member : {&V::scope_kind, &V::direction})
    CHECK_THAT(named([&](V& v) {
                 v.scope_kind = "level";
                 v.*member = "t";
               }),
               Catch::StartsWith("verdict 2"));
  CHECK_FALSE(named([](V& v) { v.expanded = 0.5; }).empty());
  V with_u = own;
  with_u.expanded = 0.5;
  CHECK(first_difference({with_u}, {own}, 0.0, false).empty());
  CHECK_THAT(named([](V& v) { v.value = 3; }), Catch::Contains("value"));
  CHECK_THAT(named([](V& v) { v.limit = 3; }), Catch::Contains("limit"));
  CHECK_THAT(named([](V& v) { v.unit = "V"; }), Catch::Contains("unit"));
  CHECK_THAT(named([](V& v) { v.rule = ">"; }), Catch::Contains("rule"));
  CHECK_THAT(named([](V& v) { v.verdict = "fail"; }), Catch::Contains("'fail'"));
  CHECK_THAT(named([](V& v) { v.limits_sha256 = "cd"; }), Catch::Contains("'cd'"));
  CHECK(named([](V& v) { v.value = 1.0 + 1e-13; }, kRelativeTolerance).empty());
  CHECK_FALSE(first_difference(std::vector<V>{}, std::vector<V>{own}, 0.0).empty());
}
