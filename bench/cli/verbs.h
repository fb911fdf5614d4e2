// Every verb, listed here and defined in a file of its own: adds itself below `above`.
#pragma once

#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
}

namespace tactbench::bench {

struct Session;
using AddVerb = void(CLI::App& above, Session& session);

AddVerb add_demo, add_init, add_calibrate, add_page, add_status, add_report, add_runs, add_plan, add_run, add_live,
    add_devices, add_simulate, add_control, add_fit, add_judge, add_compare, add_predict, add_model, add_sensors,
    add_verify, add_db, add_fleet, add_trend, add_nightly, add_config, add_selfcheck;
AddVerb add_run_remarks, add_run_export, add_import, add_run_copy, add_run_merge, add_run_diff, add_reports_list,
    add_rig_check, add_calibrate_reference, add_model_export, add_db_prune, add_fleet_push, add_fleet_status,
    add_fleet_readers, add_baseline;
AddVerb add_key_reference, add_dead_man, add_error_reference;  // not in the help

// By their group in the help.
inline const std::vector<std::pair<const char*, std::vector<AddVerb*>>> kVerbs = {
    {"Every day", {add_demo, add_init, add_calibrate, add_page, add_status, add_report, add_runs}},
    {"Measure", {add_plan, add_run, add_live, add_devices, add_simulate}},
    {"A live run", {add_control}},
    {"Models", {add_fit, add_judge, add_compare, add_predict, add_model}},
    {"Store", {add_sensors, add_verify, add_db, add_fleet}},
    {"Laboratory", {add_trend, add_nightly, add_config, add_selfcheck}},
    {"", {add_key_reference, add_dead_man, add_error_reference}}};

// By the verb that they stand below, which adds them.
inline const std::map<std::string, std::vector<AddVerb*>> kSubverbs = {
    {"runs", {add_run_remarks, add_run_export, add_import, add_run_copy, add_run_merge, add_run_diff}},
    {"report", {add_reports_list}},
    {"devices", {add_rig_check, add_calibrate_reference}},
    {"model", {add_model_export}},
    {"db", {add_db_prune}},
    {"fleet", {add_fleet_push, add_fleet_status, add_fleet_readers}},
    {"trend", {add_baseline}}};
void add_subverbs(CLI::App& verb, Session& session);

// They talk to instruments, or to a run that uses them.
inline constexpr std::array kDeviceVerbs{"run",   "calibrate", "resume", "devices",  "live",    "demo",
                                         "pause", "stop",      "panic",  "simulate", "dead-man"};

}  // namespace tactbench::bench
