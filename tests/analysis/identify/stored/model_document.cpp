// A model's document member by member: what is written, what is read, what is refused; and what streaming takes of it.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "analysis/error.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/models/monotone.h"
#include "tests/analysis/identify/refusals.h"
#include "tests/analysis/support/straight_array.h"
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

using namespace tactbench::analysis;

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
  for (const auto& [member, low, high] : {std::tuple{"creep_scale", 0.0, 10.0}, {"lag_share", 0.0, 0.9}}) {
    CAPTURE(member);
    CHECK(taxel_taken(member, low));
    CHECK(taxel_taken(member, high));
    CHECK_FALSE(taxel_taken(member, low - 0.01));
    CHECK_FALSE(taxel_taken(member, high + 0.01));
  }
  CHECK(taxel_taken("residual_psi", 0.0));
  CHECK(taxel_taken("residual_psi", 1e9));
  CHECK_FALSE(taxel_taken("residual_psi", -0.01));
  CHECK_FALSE(taxel_taken("residual_psi", 1.1e9));
}
