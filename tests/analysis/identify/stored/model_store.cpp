// Fits in a store, and MODEL of the command line as a run or a fit of it.
#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/stored/comparison.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/models/elam_hysteresis.h"
#include "tests/analysis/identify/refusals.h"
#include "tests/analysis/support/straight_array.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace straight_array;

namespace {

SensorModel fit_of_stored_run(std::int64_t run) {
  SensorModel fit = straight_fit();
  fit.model = kElamFit;
  fit.run = run;
  fit.source = "run " + std::to_string(run);
  fit.pressure_psi = {0.0, 60.0};
  fit.input_unit = "psi";
  fit.output_unit = "V";
  return fit;
}

}  // namespace

TEST_CASE("load_model: a run number loads the run's default fit, run:fit the named one") {
  const tests::TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("s.db"));
  const std::int64_t run = tests::store_example(store);
  CHECK(id_of_refusal([&] { return load_model("1", &store); }) == "TB-ANALYSIS-NO-FIT");
  CHECK(id_of_refusal([&] { return load_fit(store, run); }) == "TB-ANALYSIS-NO-FIT");
  CHECK(store_fit(store, fit_of_stored_run(run), "9.9", tests::kUtc, "commit abc") == 1);
  const SensorModel first = load_model("1", &store);
  CHECK((first.run == 1 && first.fit == 1 && first.program_version == "9.9"));
  CHECK(load_model("1:1", &store).sequences == first.sequences);
  SensorModel part = fit_of_stored_run(run);
  part.all_sequences = false;
  part.sequences = {"down"};
  part.scans = 7;
  part.content_sha256 = "abc";
  CHECK(store_fit(store, part, "9.9", tests::kUtc, "") == 2);
  const SensorModel second = load_model("1:2", &store);
  CHECK((second.fit == 2 && second.run == 1 && second.scans == 7 && second.content_sha256 == "abc"));
  CHECK(second.sequences == std::vector<std::string>{"down"});
  CHECK_FALSE(second.all_sequences);
  CHECK(load_model("1", &store).fit == 1);  // a part does not stand for the run
  for (const std::string model : {"1:x", "1:", "2:1", "1:2x"})
    CHECK(id_of_refusal([&] { return load_model(model, &store); }) == "TB-MODEL-OPEN");
  CHECK_THROWS_AS(load_model("1:3", &store), db::StoreError);
}

TEST_CASE("stored fits: dynamic models and paper-mode ELAM of the whole array become the run's default") {
  const tests::TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("s.db"));
  const std::int64_t run = tests::store_example(store);
  struct Row {
    const char* label;
    bool stands;
    std::function<void(SensorModel&)> change;
  };
  for (const Row& row :
       std::vector<Row>{{"elam", true, [](SensorModel&) {}},
                        {"elam", false, [](SensorModel& fit) { fit.origin = "imported"; }},
                        {"elam", false, [](SensorModel& fit) { fit.all_sequences = false; }},
                        {"elam", false, [](SensorModel& fit) { fit.parent_sha256 = "abc"; }},
                        {"elam", false, [](SensorModel& fit) { fit.rows = 2; }},
                        {"elam", false, [](SensorModel& fit) { fit.taxels = {fit.mean_taxel()}; }},
                        {"elam, exact outer", false, [](SensorModel& fit) { fit.options.exact_outer = true; }},
                        {"elam, free run", false, [](SensorModel& fit) { fit.options.free_run = true; }},
                        {"elam, genetic", false, [](SensorModel& fit) { fit.options.genetic = true; }},
                        {"elam, memory", false, [](SensorModel& fit) { fit.options.memory = true; }},
                        {"elam, linearised", false, [](SensorModel& fit) { fit.options.linearise = true; }},
                        {"elam, 2 splits", false, [](SensorModel& fit) { fit.options.splits = 2; }},
                        {"dynamic", true, [](SensorModel& fit) {
                           fit.model = kDynamicModel;
                           fit.dynamics.emplace();
                         }}}) {
    CAPTURE(row.label);
    SensorModel fit = fit_of_stored_run(run);
    row.change(fit);
    const db::FitRecord stored = store.fit(store_fit(store, fit, "9.9", tests::kUtc));
    CHECK(stored.model == row.label);
    CHECK(stored.stands == row.stands);
    CHECK(stored.fitted == static_cast<int>(fit.fitted().size()));
  }
}

TEST_CASE("load_fit: a damaged document, or a default fit that lacks a taxel, is refused by error id") {
  const tests::TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("s.db"));
  const std::int64_t run = tests::store_example(store);
  const db::FitRecord good = store.fit(store_fit(store, fit_of_stored_run(run), "9.9", tests::kUtc));
  CHECK_NOTHROW(load_fit(good));
  const auto refused = [&](const std::function<void(nlohmann::ordered_json&)>& change) {
    nlohmann::ordered_json json = nlohmann::ordered_json::parse(good.document);
    change(json);
    db::FitRecord record = good;
    record.document = json.dump();
    return id_of_refusal([&] { return load_fit(record); });
  };
  using Json = nlohmann::ordered_json;
  for (const std::function<void(Json&)>& change : std::vector<std::function<void(Json&)>>{
           [](Json& json) { json = Json::object(); }, [](Json& json) { json["sensor"]["rows"] = 2; },
           [](Json& json) { json["sensor"]["rows"] = 0; }, [](Json& json) { json["sensor"]["columns"] = -3; },
           [](Json& json) { json["taxels"][2]["taxel"] = 3; }, [](Json& json) { json["taxels"][1]["taxel"] = 0; },
           [](Json& json) { json["taxels"].erase(0); }, [](Json& json) { json["taxels"][0]["status"] = "well"; },
           [](Json& json) { json["taxels"][2]["status"] = "fitted"; },
           [](Json& json) { json["taxels"][0]["noise"] = -0.5; },
           [](Json& json) { json["taxels"][0]["noise"] = nullptr; },
           [](Json& json) { json["taxels"][0]["model"]["parameters"].erase("beta_a"); },
           [](Json& json) { json["taxels"][0]["model"]["parameters"]["beta_a"] = nullptr; },
           [](Json& json) { json["taxels"][0]["model"]["ascending"].erase(0); },
           [](Json& json) { json["taxels"][0]["model"]["descending"][0] = 0.5; }})
    CHECK(refused(change) == "TB-MODEL-STORED");
  CHECK(refused([](Json& json) { json["taxels"][2]["noise"] = nullptr; }).empty());  // dead: nothing is known of it
}

TEST_CASE("stored fit: every class of double is read back bit for bit, and its hash stays valid") {
  const tests::TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("s.db"));
  const std::int64_t run = tests::store_example(store);
  const double denormal = std::numeric_limits<double>::denorm_min(), none = std::nan("");
  SensorModel fit = fit_of_stored_run(run);
  const std::vector<double> x{-0.0, 60.0}, up{-0.0, 3.0}, down{-0.0, std::nextafter(3.0, 4.0)};
  ModelTaxel& taxel = fit.taxels[0];
  taxel.fit.model =
      std::make_shared<ElamHysteresis>(ElamModel{PatternCurve(x, up, -0.0, down[1]),
                                                 PatternCurve(x, down, -0.0, down[1]),
                                                 {0.1, 1.0 / 3.0, -0.0, denormal, std::numeric_limits<double>::max()},
                                                 {}});
  taxel.noise = denormal;
  taxel.zero = -0.0;
  taxel.fit.j = none;
  taxel.fit.mean_error = -0.0;
  taxel.fit.max_error = std::numeric_limits<double>::min() / 3.0;
  taxel.fit.full_scale = 0.1 + 0.2;
  fit.taxels[2].noise = none;
  const std::int64_t number = store_fit(store, fit, "9.9", tests::kUtc);
  const SensorModel back = load_fit(store.fit(number));
  const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value); };
  const ModelTaxel& read = back.taxels[0];
  CHECK((bits(read.noise) == bits(denormal) && bits(read.zero) == bits(-0.0) && std::isnan(read.fit.j)));
  CHECK((bits(read.fit.mean_error) == bits(-0.0) && bits(read.fit.max_error) == bits(taxel.fit.max_error)));
  CHECK((bits(read.fit.full_scale) == bits(0.1 + 0.2) && std::isnan(back.taxels[2].noise)));
  const ElamModel &was = *elam_of(taxel), &is = *elam_of(read);
  const auto numbers = [](const ElamModel& model) {
    const ElamParameters& p = model.parameters;
    std::vector<double> all{p.alpha_d, p.beta_d, p.alpha_a1, p.alpha_a0, p.beta_a};
    for (const PatternCurve* curve : {&model.ascending, &model.descending})
      for (const auto& values : {curve->x(), curve->y()}) all.insert(all.end(), values.begin(), values.end());
    return all;
  };
  CHECK(std::ranges::equal(numbers(was), numbers(is), {}, bits, bits));
  CHECK(std::signbit(is.ascending.x().front()));
  CHECK(store.check_seals(run).empty());
  CHECK(store_fit(store, back, "9.9", tests::kUtc) == number + 1);
  CHECK(store.fit(number + 1).document == store.fit(number).document);
}

// What `verify` calls equal, and what it names first.

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

TEST_CASE("model comparison: numbers are equal within a tolerance relative to the larger one") {
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

TEST_CASE("model comparison: the first member that differs is named, for a taxel with its number") {
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

TEST_CASE("model comparison: numbers are compared bit by bit, or within a tolerance") {
  const char* const parameter = "/taxels/0/model/parameters/alpha_d";
  CHECK_FALSE(differs(parameter, std::nextafter(-0.003, 0.0)).empty());
  CHECK(differs(parameter, std::nextafter(-0.003, 0.0), kRelativeTolerance).empty());
  CHECK_FALSE(differs("/taxels/0/model/x/0", -0.0).empty());
  CHECK(differs("/taxels/0/model/x/0", -0.0, kRelativeTolerance).empty());
}

TEST_CASE("verdict comparison: each member of the verdicts is compared") {
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
