// A model's document member by member: what is written, what is read, what is refused; and what streaming takes of it.
#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "analysis/error.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/models/elam.h"
#include "analysis/models/monotone.h"
#include "tests/analysis/support/fit_samples.h"
#include "tests/analysis/support/straight_array.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace straight_array;
using DocumentJson = nlohmann::ordered_json;

namespace {

SensorModel whole_document() {
  SensorModel model;
  model.model = "monotone";
  model.source = "run 3";
  model.origin = "simulated";
  model.content_sha256 = "abc";
  model.sequences = {"a", "b"};
  model.sensor_serial = "S";
  model.scanner_serial = "C";
  model.input_unit = "psi";
  model.output_unit = "V";
  model.program_version = "9.9";
  model.rows = 1;
  model.columns = 1;
  model.scans = 2;
  model.options.starts = 7;
  model.validity.input = Range{0.0, 60.0};
  model.validity.hold_s = Range{1.0, 2.0};
  model.validity.temperature_c = Range{20.0, 21.0};
  model.validity.mount = "M";
  model.validity.interface_material = "foam";
  model.parent_sha256 = "def";
  model.adjustment = "zero by run 4";
  model.pressure_psi = {0.0, 30.0, 60.0};
  const std::vector<double> x{0.0, 60.0}, y{1.0, 7.0}, up{1.0, 3.0, 7.0}, down{1.0, 5.0, 7.0};
  ModelTaxel taxel;
  taxel.taxel = 0;
  taxel.status = TaxelStatus::kFitted;
  taxel.noise = 0.5;
  taxel.loop_low = 1.0;
  taxel.zero = 0.25;
  taxel.gain = 2.0;
  taxel.residual_psi = 0.75;
  taxel.fit.model = std::make_unique<MonotoneModel>(PatternCurve(x, y, 1.0, 7.0));
  taxel.fit.j = 11;
  taxel.fit.mean_error = 12;
  taxel.fit.max_error = 13;
  taxel.fit.full_scale = 14;
  taxel.fit.samples = 15;
  taxel.fit.starts = 16;
  taxel.fit.undetermined = {"weights"};
  taxel.ascending = PatternCurve(model.pressure_psi, up, 1.0, 7.0);
  taxel.descending = PatternCurve(model.pressure_psi, down, 1.0, 7.0);
  ModelTaxel dead;
  dead.taxel = 1;
  dead.status = TaxelStatus::kUnfit;
  dead.reason = "why not";
  model.taxels = {taxel, dead};
  return model;
}

DocumentJson written() { return DocumentJson::parse(to_text(whole_document())); }

std::string refused_document(const DocumentJson& json) {
  try {
    (void)document_from_text(json.dump(), "m.json");
  } catch (const AnalysisError& error) {
    CHECK(error.id() == "TB-MODEL-DOCUMENT");
    const std::string what = error.what();
    CHECK_THAT(what, Catch::StartsWith("m.json"));
    return what.substr(what.find(": "));
  }
  return {};
}

std::string refused_with_member(const char* pointer, const DocumentJson& value) {
  DocumentJson json = written();
  json[DocumentJson::json_pointer(pointer)] = value;
  return refused_document(json);
}

}  // namespace

TEST_CASE("model document: each member is read back as it was written") {
  const SensorModel back = document_from_text(to_text(whole_document()), "m.json"), was = whole_document();
  CHECK(to_text(back) == to_text(was));
  CHECK((back.model == "monotone" && back.source == "run 3" && back.origin == "simulated"));
  CHECK((back.content_sha256 == "abc" && back.sequences == was.sequences && back.program_version == "9.9"));
  CHECK((back.sensor_serial == "S" && back.scanner_serial == "C" && back.rows == 1 && back.columns == 1));
  CHECK((back.input_unit == "psi" && back.output_unit == "V" && back.scans == 2 && !back.falling));
  CHECK((back.options.starts == 7 && back.options.splits == 1 && !back.options.free_run && !back.options.linearise));
  CHECK((back.validity.input->high == 60.0 && back.validity.hold_s->low == 1.0 && !back.validity.rate));
  CHECK((back.validity.temperature_c->high == 21.0 && back.validity.mount == "M"));
  CHECK((back.parent_sha256 == "def" && back.adjustment == "zero by run 4" && back.pressure_psi == was.pressure_psi));
  REQUIRE(back.taxels.size() == 2);
  const ModelTaxel& taxel = back.taxels[0];
  CHECK((taxel.fitted() && taxel.noise == 0.5 && taxel.loop_low == 1.0 && taxel.zero == 0.25 && taxel.gain == 2.0));
  CHECK((taxel.fit.j == 11 && taxel.fit.mean_error == 12 && taxel.fit.max_error == 13 && taxel.fit.full_scale == 14));
  CHECK((taxel.fit.samples == 15 && taxel.fit.starts == 16 && taxel.residual_psi == 0.75));
  CHECK(taxel.fit.undetermined == std::vector<std::string>{"weights"});
  CHECK((taxel.ascending(30) == 3.0 && taxel.descending(30) == 5.0));
  CHECK((back.taxels[1].status == TaxelStatus::kUnfit && back.taxels[1].reason == "why not"));
  SensorModel modes = whole_document();
  modes.falling = modes.options.free_run = modes.options.exact_outer = modes.options.memory = true;
  modes.options.genetic = modes.options.linearise = true;
  modes.options.splits = 3;
  const SensorModel as = document_from_text(to_text(modes), "m.json");
  CHECK((as.falling && as.options.free_run && as.options.exact_outer && as.options.memory && as.options.genetic));
  CHECK((as.options.linearise && as.options.splits == 3));
  CHECK(written()["taxels"][0]["dead_band"] == 3.0);  // six noises
  CHECK_FALSE(written()["options"].contains("linearise"));
}

TEST_CASE("model document: each invalid or missing member is refused by name") {
  CHECK(refused_document(written()).empty());
  CHECK(refused_with_member("/options/splits", -1e9).empty());
  CHECK(refused_with_member("/taxels/0/noise", 0.0).empty());
  struct Row {
    const char* pointer;
    DocumentJson value;
    const char* named;
  };
  for (const Row& row : std::vector<Row>{{"/schema", "x", "\"schema\""},
                                         {"/schema", 7, "\"schema\""},
                                         {"/version", 2, "version"},
                                         {"/version", 1.5, "\"version\""},
                                         {"/options/memory", 1, "\"memory\""},
                                         {"/options/exact_outer", "no", "\"exact_outer\""},
                                         {"/options/linearise", 1, "\"linearise\""},
                                         {"/options/splits", 1.1e9, "\"splits\""},
                                         {"/output/falling", 0, "\"falling\""},
                                         {"/sensor/serial", 5, "\"serial\""},
                                         {"/loop_inputs", "x", "\"loop_inputs\""},
                                         {"/loop_inputs", DocumentJson{0, "x"}, "\"loop_inputs\""},
                                         {"/loop_inputs", DocumentJson{1}, "loop"},
                                         {"/taxels", DocumentJson::array(), "\"taxels\""},
                                         {"/taxels/0/noise", -0.1, "\"noise\""},
                                         {"/taxels/0/gain", -1.0, "\"gain\""},
                                         {"/taxels/0/gain", 0.0, "\"gain\""},
                                         {"/taxels/0/residual_psi", -0.1, "\"residual_psi\""},
                                         {"/taxels/0/taxel", 0.5, "\"taxel\""},
                                         {"/taxels/0/model/x", "none", "\"x\""},
                                         {"/taxels/0/loop/ascending", DocumentJson{1, 7}, "\"loop\""},
                                         {"/taxels/0/loop/descending", DocumentJson{1, 3, 5, 7}, "\"loop\""},
                                         {"/taxels/0/loop/ascending", DocumentJson{1, "x", 7}, "\"ascending\""},
                                         {"/taxels/0/status", "too short", "too short"},
                                         {"/taxels/1/status", "fitted", "model"}}) {  // it has none
    CAPTURE(row.pointer);
    CHECK_THAT(refused_with_member(row.pointer, row.value), Catch::Contains(row.named));
  }
  for (const char* pointer : {"/schema", "/version", "/model", "/options", "/output", "/source", "/validity", "/taxels",
                              "/loop_inputs", "/taxels/0/loop", "/taxels/0/noise", "/taxels/0/figures"}) {
    CAPTURE(pointer);
    DocumentJson json = written();
    const DocumentJson::json_pointer at(pointer);
    json[at.parent_pointer()].erase(at.back());
    CHECK_THAT(refused_document(json), Catch::Contains(pointer == std::string("/loop_inputs") ? "loop" : at.back()));
  }
  CHECK_FALSE(refused_document(DocumentJson::array()).empty());
  CHECK(id_of_refusal([] { return document_from_text("{", "m.json"); }) == "TB-MODEL-DOCUMENT");
}

TEST_CASE("load_model: reads a file by its path, and refuses a run number without a store") {
  SensorModel model = whole_document();
  CHECK(label_of(model) == "monotone");
  model.options.free_run = model.options.genetic = model.options.linearise = true;
  model.options.memory = model.options.exact_outer = true;
  model.options.splits = 2;
  CHECK(label_of(model) != "monotone");
  const tests::TemporaryFolder folder;
  tests::write_file(folder.path("m.json"), to_text(whole_document()));
  CHECK(load_model(folder.path("m.json"), nullptr).source == "run 3");
  for (const std::string& named : {std::string("17"), std::string("17x"), folder.path("none.json")})
    CHECK(id_of_refusal([&] { return load_model(named, nullptr); }) == "TB-MODEL-OPEN");
}

// Lag and creep as a document has them: each number at its bounds and beyond.

namespace {

SensorDynamics stored_dynamics() {
  SensorDynamics dynamics;
  dynamics.shared.creep_s = {2.0, 20.0, 200.0};
  dynamics.shared.creep_share = {0.03, 0.0, 0.01};
  dynamics.shared.creep_half = 7.0;
  dynamics.shared.lag_s = 1.5;
  dynamics.shared.lag_share = 0.05;
  dynamics.residual_shape = {1.0, 0.0, 2.0, 3.0};
  dynamics.rate = {5, "ab"};
  dynamics.creep = {6, "cd"};
  return dynamics;
}

// What is said of a document with another value of a member; empty where it is taken.
std::string refused_dynamics(const std::string& member, const nlohmann::ordered_json& value) {
  nlohmann::ordered_json json = dynamics_json(stored_dynamics());
  json[nlohmann::ordered_json::json_pointer("/" + member)] = value;
  return why_invalid([&] { return dynamics_from(json); });
}

bool taxel_taken(const std::string& member, double value) {
  ModelTaxel taxel;
  nlohmann::ordered_json json;
  add_taxel_dynamics(taxel, json);
  json[member] = value;
  return why_invalid([&] { read_taxel_dynamics(json, taxel); }).empty();
}

}  // namespace

TEST_CASE("dynamics JSON: lag and creep are read back as they were written") {
  const SensorDynamics back = dynamics_from(dynamics_json(stored_dynamics()));
  CHECK(back.shared.creep_s == stored_dynamics().shared.creep_s);
  CHECK(back.shared.creep_share == stored_dynamics().shared.creep_share);
  CHECK((back.shared.creep_half == 7.0 && back.shared.lag_s == 1.5 && back.shared.lag_share == 0.05));
  CHECK(back.residual_shape == stored_dynamics().residual_shape);
  CHECK((back.rate.run == 5 && back.rate.content_sha256 == "ab"));
  CHECK((back.creep.run == 6 && back.creep.content_sha256 == "cd"));
  ModelTaxel taxel, read;
  taxel.creep_scale = 1.25;
  taxel.lag_share = 0.5;
  taxel.residual_psi = 0.75;
  nlohmann::ordered_json json;
  add_taxel_dynamics(taxel, json);
  read_taxel_dynamics(json, read);
  CHECK((read.creep_scale == 1.25 && read.lag_share == 0.5 && read.residual_psi == 0.75));
}

TEST_CASE("dynamics JSON: lag and creep beyond their bounds are refused by name") {
  for (const char* const member : {"creep_half", "lag_s"}) {
    CHECK(refused_dynamics(member, 1e-9).empty());
    CHECK(refused_dynamics(member, 1e9).empty());
    CHECK_THAT(refused_dynamics(member, 0.9e-9), Catch::Contains(member));
    CHECK_THAT(refused_dynamics(member, 1.1e9), Catch::Contains(member));
  }
  CHECK(refused_dynamics("lag_share", 0.0).empty());
  CHECK(refused_dynamics("lag_share", 0.9).empty());
  CHECK(refused_dynamics("creep_share", {0.0, 0.0, 0.0}).empty());
  CHECK(refused_dynamics("residual_shape", {0.0, 1.0}).empty());
  struct Row {
    const char* member;
    nlohmann::ordered_json value;
  };
  for (const Row& row : std::vector<Row>{{"lag_share", -0.01},
                                         {"lag_share", 0.91},
                                         {"creep_share", {0.0, 0.0}},
                                         {"creep_share", {0.0, 0.0, 0.0, 0.0}},
                                         {"creep_share", {0.1, -0.01, 0.0}},
                                         {"creep_s", {1.0, 2.0}},
                                         {"creep_s", {1.0, 2.0, 3.0, 4.0}},
                                         {"creep_s", {1.0, 0.0, 3.0}},
                                         {"residual_shape", {1.0, -0.01}}}) {
    CAPTURE(row.member, row.value.dump());
    CHECK_THAT(refused_dynamics(row.member, row.value), Catch::Contains("\"" + std::string(row.member) + "\""));
  }
  CHECK(refused_dynamics("rate/run", -1e15).empty());
  for (const std::string run : {"rate", "creep"}) {
    CHECK(refused_dynamics(run + "/run", 1e15).empty());
    const auto named = Catch::Contains("\"" + run + "\"");
    CHECK_THAT(refused_dynamics(run + "/run", 1.1e15), named);
    CHECK_THAT(refused_dynamics(run + "/run", 1.5), named);
    CHECK_THAT(refused_dynamics(run + "/content_sha256", 7), named);
  }
  for (const auto& [member, low, high] :
       {std::tuple{"creep_scale", 0.0, 10.0}, {"lag_share", 0.0, 0.9}, {"residual_psi", 0.0, 1e9}}) {
    CAPTURE(member);
    CHECK(taxel_taken(member, low));
    CHECK(taxel_taken(member, high));
    CHECK_FALSE(taxel_taken(member, low - 0.01));
    CHECK_FALSE(taxel_taken(member, high + 0.01));
  }
}

// Fits in a store, and MODEL of the command line as a run or a fit of it.

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
