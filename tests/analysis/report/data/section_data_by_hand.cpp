// The data behind sections by hand: studies, objects, models compared, traces, the indication; member by member.
#include <catch2/catch.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "analysis/report/data/section_data.h"
#include "analysis/report/parts.h"
#include "tests/analysis/support/judged_figures.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

constexpr double kNoDatum = std::numeric_limits<double>::quiet_NaN();

using ReadJson = nlohmann::json;

// `text` as it must be, but for spaces and order.
void check_same(const ReadJson& is, const char* text) {
  const ReadJson wanted = ReadJson::parse(text);
  INFO(is.dump() << "\nmust be\n" << wanted.dump());
  CHECK(is == wanted);
}

ErrorSum summed(double sum, double max, int samples) {
  ErrorSum error;
  error.sum = sum;
  error.max = max;
  error.samples = samples;
  return error;
}

}  // namespace

TEST_CASE("data of studies by hand: crosstalk, rate and hold, mounts and uniformity") {
  ReportInput input;
  Studies& studies = input.more.studies;
  Crosstalk& c = studies.crosstalk;
  c.not_assessed.clear();
  c.positions = 25;
  c.force_n = 5.5;
  c.reach_pitches = 2.5;
  c.row = {0.01, 0.002, 0.03, 4};
  c.column = {0.02, 0.003, 0.04, 5};
  c.elsewhere = {0.03, 0.004, 0.05, 6};
  c.ghost_rows = {{3, 0.25}, {4, 0.5}};
  c.ghost_columns = {{7, 0.125}};
  c.distance_pitches = {0.0, 1.23456789};
  c.along_row_share = {1.0, 0.5};
  c.along_column_share = {1.0, kNoDatum};
  studies.rate_hold.not_assessed.clear();
  studies.rate_hold.runs = {{16, "hold", summed(3.0, 1.5, 4), {{1.0, 2.0, summed(1.0, 0.75, 2)}}, {}, 0.1, 0.05},
                            {17, "rate", summed(0.5, 0.5, 1), {}, {{5.0, 10.0, summed(0.5, 0.5, 1)}}, 0.0, 0.0}};
  Remount& r = studies.remount;
  r.not_assessed.clear();
  r.runs = {12, 13, 14};
  r.pressure_psi = {20.0, 40.0};
  r.within_psi = {0.1, 0.2};
  r.between_psi = {0.3, 0.4};
  r.mean_between_psi = {0.5, 0.6};
  r.taxel_between_psi = {0.7, kNoDatum};
  r.within_share = 0.01;
  r.s_share = 0.02;
  r.degrees = 2;
  Uniformity& u = studies.uniformity;
  u.not_assessed.clear();
  u.angles_deg = {0, 90};
  u.pressure_psi = {20.0};
  u.u_psi = {0.1};
  u.residual_psi = {0.2};
  u.chamber_share = {0.3};
  u.chamber_psi = {0.4};
  u.sensor_share = {0.5};
  u.u_share = 0.6;
  u.u_offset_psi = 0.7;
  u.residual_rms_psi = 0.8;
  u.residual_other_sense_psi = 0.9;
  u.undetermined = 3;
  check_same(ReadJson::parse(studies_json(input)), R"({
    "crosstalk":{"positions":25,"force_n":5.5,"reach_pitches":2.5,
      "row":{"mean_share":0.01,"u_share":0.002,"max_share":0.03,"samples":4},
      "column":{"mean_share":0.02,"u_share":0.003,"max_share":0.04,"samples":5},
      "elsewhere":{"mean_share":0.03,"u_share":0.004,"max_share":0.05,"samples":6},
      "ghost_rows":[{"line":3,"mean_share":0.25},{"line":4,"mean_share":0.5}],
      "ghost_columns":[{"line":7,"mean_share":0.125}],
      "distance_pitches":[0,1.234568],"along_row_share":[1,0.5],"along_column_share":[1,null]},
    "rate_hold":[{"sequence":"hold","mean_psi":0.75,"max_psi":1.5,"samples":4,"output_max_share":0.1,
      "output_mean_share":0.05,"by_hold_s":[{"low":1.0,"high":2.0,"samples":2,"mean_psi":0.5,"max_psi":0.75}],
      "by_rate_psi_per_s":[]},
      {"sequence":"rate","mean_psi":0.5,"max_psi":0.5,"samples":1,"output_max_share":0.0,"output_mean_share":0.0,
      "by_hold_s":[],"by_rate_psi_per_s":[{"low":5.0,"high":10.0,"samples":1,"mean_psi":0.5,"max_psi":0.5}]}],
    "remount":{"mounts":3,"pressure_psi":[20,40],"within_psi":[0.1,0.2],"between_psi":[0.3,0.4],
      "mean_between_psi":[0.5,0.6],"taxel_between_psi":[0.7,null],"within_share":0.01,"s_share":0.02,"degrees":2},
    "uniformity":{"angles_deg":[0,90],"pressure_psi":[20],"u_psi":[0.1],"residual_psi":[0.2],"chamber_share":[0.3],
      "chamber_psi":[0.4],"sensor_share":[0.5],"u_share":0.6,"u_offset_psi":0.7,"residual_rms_psi":0.8,
      "residual_other_sense_psi":0.9,"undetermined":3}})");
  c.not_assessed = r.not_assessed = u.not_assessed = studies.rate_hold.not_assessed = "no run";
  check_same(ReadJson::parse(studies_json(input)),
             R"({"crosstalk":{"not_assessed":"no run"},"rate_hold":{"not_assessed":"no run"},
                 "remount":{"not_assessed":"no run"},"uniformity":{"not_assessed":"no run"}})");
}

TEST_CASE("data of objects by hand: a press with its levels, distances and the budget of the force sensor") {
  ReportInput input;
  CHECK(objects_json(input) == "[]");
  ContactResult contact;
  contact.sequence = "ring";
  contact.object = "a ring";
  contact.force_traceability = "measured";
  contact.positions = 1;
  contact.repeats = 3;
  contact.geometry = {2.5, 6.25};
  contact.full_scale_v = 4.0;
  contact.full_scale_psi = 40.0;
  contact.raw_mean_error_n = 0.1;
  contact.raw_max_error_n = 0.2;
  contact.compensated_mean_error_n = 0.3;
  contact.compensated_max_error_n = 0.4;
  contact.raw_distance = {0.5, kNoDatum};
  contact.compensated_distance = {0.25, kNoDatum};
  InstrumentRow told{"certificate", "normal", 0.06, 2.0, {}}, inside{"input", "", 0.0, 1.0, {"", "in it"}},
      missing{"drift", "", 0.0, 1.0, {"no date", ""}};
  contact.force_uncertainty.unit = "N";
  contact.force_uncertainty.rows = {told, inside, missing};
  ContactLevel level;
  level.target_n = 2.0;
  level.rising = false;
  level.frames = 3;
  level.force_n = 2.1;
  level.torque_nmm = 1.5;
  level.raw = {3.0, 0.1, 0.2, 0.3, 0.4, 64.5, 0.5};
  level.compensated = {2.0, 0.6, 0.7, 0.8, 0.9, 51.5, 1.5};
  level.raw_force_error_n = 0.9;
  level.compensated_force_error_n = 0.1;
  level.raw_place_error_mm = 1.1;
  level.compensated_place_error_mm = kNoDatum;
  level.raw_wander_mm = 1.2;
  level.compensated_wander_mm = 1.3;
  level.clamped_taxels = 1.4;
  level.raw_std = 0.01;
  level.compensated_std = 0.02;
  level.raw_v = {1.234567, 0.5};
  level.compensated_psi = {12.34567, kNoDatum};
  contact.levels = {level};
  input.more.contacts = {contact, {}};
  const ReadJson data = ReadJson::parse(objects_json(input));
  REQUIRE(data.size() == 2);
  check_same(data[0], R"({"sequence":"ring","object":"a ring","force_traceability":"measured",
    "force_uncertainty":{"unit":"N","certificate_covers":"not stated","rows":[
      {"source":"certificate","width":0.06,"distribution":"normal","divisor":2.0,"u":0.03},
      {"source":"input","contained":"in it"},{"source":"drift","not_assessed":"no date"}],
      "expanded":0.06,"factor":2.0,"complete":false},
    "positions":1,"repeats":3,"registered":false,"pitch_mm":2.5,"taxel_area_mm2":6.25,"full_scale_v":4.0,
    "full_scale_psi":40.0,"raw_mean_error_n":0.1,"raw_max_error_n":0.2,"compensated_mean_error_n":0.3,
    "compensated_max_error_n":0.4,"raw_distance_fs":[0.5,null],"compensated_distance_fs":[0.25,null],
    "levels":[{"target_n":2.0,"rising":false,"frames":3,"force_n":2.1,"torque_nmm":1.5,
      "raw":{"force_n":3.0,"x_mm":0.1,"y_mm":0.2,"moment_x_nmm":0.3,"moment_y_nmm":0.4,"area_mm2":64.5,
        "threshold_psi":0.5},
      "compensated":{"force_n":2.0,"x_mm":0.6,"y_mm":0.7,"moment_x_nmm":0.8,"moment_y_nmm":0.9,"area_mm2":51.5,
        "threshold_psi":1.5},
      "raw_force_error_n":0.9,"compensated_force_error_n":0.1,"raw_place_error_mm":1.1,
      "compensated_place_error_mm":null,"raw_wander_mm":1.2,"compensated_wander_mm":1.3,"clamped_taxels":1.4,
      "raw_std_fs":0.01,"compensated_std_fs":0.02,"raw_v":[1.2346,0.5],"compensated_psi":[12.346,null]}]})");
  CHECK(data[1]["levels"].empty());
  input.more.contacts[0].mount_run = 1;
  CHECK(ReadJson::parse(objects_json(input))[0]["registered"] == true);
}

TEST_CASE("data of models compared by hand: figures, parameters at a bound or fixed, curves with five digits") {
  ReportInput input;
  ComparedModel model;
  model.model = "gpi";
  model.joint = true;
  model.j_v2 = 0.1;
  model.mean_error_v = 0.2;
  model.max_error_v = 0.3;
  model.mean_running_v = 0.4;
  model.max_running_v = 0.5;
  model.samples = 7;
  model.operations_per_sample = 9;
  model.parameters = {{"a", 1.0, "y", 0.0, 1.0}, {"b", 0.5, "1", 0.0, 1.0, true}};
  model.model_v = {1.234567};
  ComparedModel failed;
  failed.model = "mpi";
  failed.failed = "no play";
  input.more.models.taxels = {{{7, "worst taxel"}, 2.5, {{"up", {12.34567}, {0.1234567}, {model, failed}}}}};
  check_same(ReadJson::parse(models_json(input)), R"([{"taxel":7,"title":"worst taxel","full_scale_v":2.5,"sequences":[
    {"sequence":"up","pressure_psi":[12.346],"measured_v":[0.12346],"models":[
      {"model":"gpi","joint":true,"j_v2":0.1,"mean_error_v":0.2,"max_error_v":0.3,"mean_free_running_v":0.4,
       "max_free_running_v":0.5,"samples":7,"operations_per_sample":9,"parameters":[
         {"name":"a","value":1.0,"unit":"y","at_bound":true,"fixed":false},
         {"name":"b","value":0.5,"unit":"1","at_bound":false,"fixed":true}],"model_v":[1.2346]},
      {"model":"mpi","failed":"no play"}]}]}])");
}

TEST_CASE("data of single taxels by hand: the straight line, usable ranges, traces, and the models before") {
  ReportInput input;
  ReportResults& more = input.more;
  more.straight = {0.1, 0.2, 0.3};
  more.usable.options = {4.5, 2.5, 0.9};
  more.usable.pressure_psi = {0.0, 60.0};
  more.usable.loading = {{0.1, 0.2}, {0.3, 0.4}, {0.5, 0.6}, {0.7, 0.8}, 1.0, 2.0, 3.0, 4.0};
  more.usable.unloading = {{0.9}, {1.1}, {1.2}, {1.3}, kNoDatum, kNoDatum, 7.0, 8.0};
  more.traces = {{{3, "best taxel"}, "up", {12.34567}, {0.1234567}, {0.2}, {0.3}}};
  ReadJson data = ReadJson::parse(compensation_json(input));
  check_same(data["straight_line"], R"({"mean_error_psi":0.1,"max_error_psi":0.2,"worst_taxel_mean_error_psi":0.3})");
  CHECK(data["as_found"].is_null());
  check_same(data["usable"], R"({"in_noises":4.5,"most_psi":2.5,"least_share":0.9,"pressure_psi":[0,60],
    "loading":{"resolved_share":[0.1,0.2],"usable_share":[0.3,0.4],"median_psi":[0.5,0.6],"worst_psi":[0.7,0.8],
      "resolved_low_psi":3.0,"resolved_high_psi":4.0,"low_psi":1.0,"high_psi":2.0},
    "unloading":{"resolved_share":[0.9],"usable_share":[1.1],"median_psi":[1.2],"worst_psi":[1.3],
      "resolved_low_psi":7.0,"resolved_high_psi":8.0,"low_psi":null,"high_psi":null}})");
  check_same(data["traces"], R"([{"taxel":3,"sequence":"up","pressure_psi":[12.346],"measured_v":[0.12346],
                                 "model_v":[0.2],"estimate_psi":[0.3]}])");
  more.previous = AsFound{"before.json", {}, 253, {}, "in doubt"};
  more.previous->evaluation.mean_error_psi = 0.7;
  more.previous->judgement =
      by_hand::judgement_of({by_hand::judged_figure(12, Criterion::kMismatch, 0.1, 0.2, Verdict::kPass),
                             by_hand::judged_figure(12, Criterion::kMpe, 0.1, 0.2, Verdict::kFail)});
  data = ReadJson::parse(compensation_json(input))["as_found"];
  CHECK((data["fitted_taxels"] == 253 && data["mean_error_psi"] == 0.7 && data["levels"].empty()));
  CHECK((data["overall"] == "fail" && data["doubt"] == "in doubt" && data["verdicts"].size() == 2));
  CHECK((data["verdicts"][0]["criterion"] == "mismatch" && data["verdicts"][1]["verdict"] == "fail"));
}

TEST_CASE("data of the indication by hand: loops, traces, repeatability, zero deviation and creep") {
  ReportInput input;
  Behaviour& b = input.behaviour;
  b.taxels = {0, 2};
  b.pressure_psi = {0.0, 60.0};
  b.full_scale_v = 2.5;
  b.loops = {{"mean", -1, 2.5, 0.25, 0.1, {0.0, 2.5}, {0.1, 2.5}}, {"worst", 2, 2.0, 0.5, 0.2, {0.0}, {0.2}}};
  b.hysteresis_max = {0.25, kNoDatum};
  b.hysteresis_mean = {0.1, kNoDatum};
  b.traces = {{"up", {0.0, 60.0}, {0.0, 2.5}}};
  b.equilibration_psi = 40.0;
  b.gain = {0.9, kNoDatum, 1.1};
  b.repeats = 5;
  b.repeatability = {{20.0, 0.001, 0.002, 0.003, 0.004}};
  b.zero_returns = {{"loop", 3, 0.1, 0.2, 0.3, 2}};
  b.creep = {{20, "hold", 40.0, 2.0, 602.0, 2.1, 2.2, 0.01, 0.001, 301, true},
             {20, "hold", 30.0, 2.0, 602.0, 2.1, 2.2, 0.01, 0.001, 301, false}};
  check_same(ReadJson::parse(behaviour_json(input)), R"({"taxels":[0,2],"pressure_psi":[0,60],"full_scale_v":2.5,
    "loops":[{"name":"mean","taxel":-1,"full_scale_v":2.5,"hysteresis_max_fs":0.25,"hysteresis_mean_fs":0.1,
        "up_v":[0,2.5],"down_v":[0.1,2.5]},
      {"name":"worst","taxel":2,"full_scale_v":2.0,"hysteresis_max_fs":0.5,"hysteresis_mean_fs":0.2,"up_v":[0],
        "down_v":[0.2]}],
    "hysteresis_max_fs":[0.25,null],"hysteresis_mean_fs":[0.1,null],
    "traces":[{"sequence":"up","pressure_psi":[0,60],"output_v":[0,2.5]}],"equilibration_psi":40.0,
    "gain":[0.9,null,1.1],"repeats":5,
    "repeatability":[{"pressure_psi":20.0,"mean_up_v":0.001,"mean_down_v":0.002,"taxel_up_v":0.003,
      "taxel_down_v":0.004}],
    "zero_return":[{"sequence":"loop","repeats":3,"mean_v":0.1,"largest_v":0.2,"worst_taxel_v":0.3,"worst_taxel":2}],
    "creep":[{"sequence":"hold","pressure_psi":40.0,"branch":"up","from_s":2.0,"to_s":602.0,"first_v":2.1,
        "last_v":2.2,"per_decade":0.01,"per_decade_u":0.001,"samples":301},
      {"sequence":"hold","pressure_psi":30.0,"branch":"down","from_s":2.0,"to_s":602.0,"first_v":2.1,
        "last_v":2.2,"per_decade":0.01,"per_decade_u":0.001,"samples":301}]})");
}

TEST_CASE("data of the sensor's health by hand: each finding and each pair of lines") {
  ReportInput input;
  Health& health = input.health;
  health.options = {0.07, 3.5, 0.2, 0.8};
  health.low_v = {0.125, 0.25};
  health.high_v = {2.125, 3.25};
  health.noise_v = {0.009, kNoDatum};
  health.median_noise_v = 0.001234;
  health.findings = {{3, "noisy", "9 mV", false}, {5, "unfit", "12 %", true}};
  health.swaps_assessed = true;
  health.swaps = {{true, 3, 7, 0.125, 0.75}, {false, 0, 15, 0.25, 0.875}};
  check_same(ReadJson::parse(health_json(input)), R"({"dead_v":0.07,"noisy_factor":3.5,"median_noise_v":0.001234,
    "low_v":[0.125,0.25],"high_v":[2.125,3.25],"noise_v":[0.009,null],"swaps_assessed":true,
    "findings":[{"taxel":3,"state":"noisy","reason":"9 mV","excluded":false},
      {"taxel":5,"state":"unfit","reason":"12 %","excluded":true}],
    "swaps":[{"lines":"rows","first":3,"second":7,"correlation_as_is":0.125,"correlation_exchanged":0.75},
      {"lines":"columns","first":0,"second":15,"correlation_as_is":0.25,"correlation_exchanged":0.875}]})");
}
