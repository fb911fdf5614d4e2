#include <nlohmann/json.hpp>

#include "analysis/report/data.h"
#include "analysis/report/page.h"

namespace tactbench::analysis {
namespace {

using Json = nlohmann::ordered_json;

Json level_json(const LevelFigures& level, int fitted) {
  const LevelJudgement worse = judge_level(level);
  return {
      {"pressure_psi", level.pressure_psi},
      {"up_psi", level.up_psi},
      {"down_psi", level.down_psi},
      {"raw_std_up", level.raw_std_up},
      {"raw_std_down", level.raw_std_down},
      {"raw_distance", level.raw_distance},
      {"raw_mean_distance", level.raw_mean_distance},
      {"comp_std_up", level.comp_std_up},
      {"comp_std_down", level.comp_std_down},
      {"comp_distance", level.comp_distance},
      {"comp_mean_distance", level.comp_mean_distance},
      {"comp_distance_observable", observable(level, &LevelFigures::comp_distance_observable, fitted)},
      {"worst_taxel_distance", level.worst_taxel_distance},
      {"worst_taxel_distance_observable", observable(level, &LevelFigures::worst_taxel_distance_observable, fitted)},
      {"made_worse", worse.distance},
      {"std_up_made_worse", worse.std_up},
      {"std_down_made_worse", worse.std_down},
      {"flat_taxels", level.flat_taxels}};
}

Json evaluation_json(const Evaluation& e, int fitted) {
  Json levels = Json::array();
  for (const LevelFigures& level : e.levels) levels.push_back(level_json(level, fitted));
  return {{"full_scale_v", e.full_scale_v},
          {"full_scale_psi", e.full_scale_psi},
          {"hysteresis_max_fs", e.hysteresis_max_fs},
          {"hysteresis_mean_fs", e.hysteresis_mean_fs},
          {"mean_error_psi", e.mean_error_psi},
          {"max_error_psi", e.max_error_psi},
          {"mean_error_observable_psi", e.mean_error_observable_psi},
          {"max_error_observable_psi", e.max_error_observable_psi},
          {"worst_taxel_mean_error_psi", e.worst_taxel_mean_error_psi},
          {"worst_taxel", e.worst_taxel},
          {"raw_distance", e.raw_distance},
          {"comp_distance_of_mean", e.comp_distance_of_mean},
          {"comp_distance", e.comp_distance},
          {"comp_distance_observable", e.comp_distance_observable},
          {"worst_taxel_distance", e.worst_taxel_distance},
          {"worst_taxel_distance_observable", e.worst_taxel_distance_observable},
          {"flat_share", e.flat_share},
          {"frames", e.frames},
          {"levels", levels}};
}

// Parameters in the order of "parameter_names"; patterns on "pressure_psi".
Json taxel_json(const TaxelFit& taxel, int index) {
  const ElamParameters& p = taxel.fit.model.parameters;
  Json out = {{"taxel", index}, {"status", to_string(taxel.status)}, {"noise_v", taxel.noise_v}};
  if (taxel.status != TaxelStatus::kFitted) return out;
  out["parameters"] = {p.alpha_d, p.beta_d, p.alpha_a1, p.alpha_a0, p.beta_a};
  out["at_bound"] = taxel.fit.at_bound;
  out["j_v2"] = taxel.fit.j_v2;
  out["mean_error_v"] = taxel.fit.mean_error_v;
  out["max_error_v"] = taxel.fit.max_error_v;
  out["full_scale_v"] = taxel.fit.full_scale_v;
  out["ascending_v"] = number_list(taxel.fit.model.ascending.y());
  out["descending_v"] = number_list(taxel.fit.model.descending.y());
  return out;
}

Json laboratory_json(const Laboratory& l) {
  Json instruments = Json::array();
  for (const InstrumentNote& note : l.instruments)
    instruments.push_back({{"serial", note.serial},
                           {"certificate", note.certificate},
                           {"calibrated_by", note.calibrated_by},
                           {"calibrated_on", note.calibrated_on},
                           {"due", note.due},
                           {"note", note.note}});
  return {{"laboratory", l.laboratory}, {"address", l.address},
          {"place", l.place},           {"accreditation", l.accreditation},
          {"customer", l.customer},     {"customer_address", l.customer_address},
          {"order", l.order},           {"received", l.received},
          {"condition", l.condition},   {"cable", l.cable},
          {"mounting", l.mounting},     {"environment", l.environment},
          {"deviations", l.deviations}, {"remarks", l.remarks},
          {"instruments", instruments}, {"sha256", l.sha256}};
}

Json history_json(const RunHistory& history) {
  Json events = Json::array(), voids = Json::array(), surroundings = Json::array(), checks = Json::array();
  for (const HistoryEvent& event : history.events)
    events.push_back({{"time_s", event.time_s}, {"kind", event.kind}, {"text", event.text}});
  for (const VoidBranch& branch : history.voids)
    voids.push_back({{"sequence", branch.sequence},
                     {"repeat", branch.repeat},
                     {"branch", branch.branch},
                     {"attempt", branch.attempt},
                     {"reason", branch.reason}});
  for (const SurroundingsRange& range : history.surroundings)
    surroundings.push_back(
        {{"quantity", range.quantity}, {"low", range.low}, {"high", range.high}, {"readings", range.readings}});
  for (const db::CheckRecord& check : history.checks)
    checks.push_back({{"kind", check.kind}, {"verdict", check.verdict}, {"detail", check.detail_json}});
  return {{"frames", history.frames},
          {"flagged", history.flagged},
          {"flags", history.flags},
          {"void_frames", history.void_frames},
          {"voids", voids},
          {"events", events},
          {"surroundings", surroundings},
          {"checks", checks}};
}

Json run_json(const db::RunRecord& run) {
  Json devices = Json::array(), sequences = Json::array();
  for (const db::DeviceRecord& device : run.devices) {
    devices.push_back({{"role", device.role},
                       {"model", device.model},
                       {"serial", device.serial},
                       {"firmware", device.firmware},
                       {"origin", device.origin},
                       {"calibration", device.calibration_json}});
  }
  for (const db::SequenceRecord& sequence : run.sequences) {
    sequences.push_back({{"name", sequence.name},
                         {"repeats", sequence.repeats},
                         {"frames_per_repeat", sequence.frames_per_repeat},
                         {"recipe_sha256", sequence.recipe_sha256}});
  }
  return {{"run", run.run},
          {"uuid", run.uuid},
          {"origin", run.origin},
          {"outcome", db::to_string(run.outcome)},
          {"reason", run.reason},
          {"safe_state", db::to_string(run.safe_state)},
          {"operator", run.operator_name},
          {"purpose", run.purpose},
          {"sensor_serial", run.sensor_serial},
          {"scanner_serial", run.scanner_serial},
          {"bench_id", run.bench_id},
          {"bench_sha256", run.bench_sha256},
          {"sensor_sha256", run.sensor_sha256},
          {"content_sha256", run.content_sha256},
          {"overrides", run.overrides_json},
          {"seed", run.seed},
          {"sensor_seed", run.sensor_seed},
          {"program_version", run.program_version},
          {"git_commit", run.git_commit},
          {"git_dirty", run.git_dirty},
          {"build_id", run.build_id},
          {"host", run.host},
          {"started_utc", run.started_utc},
          {"ended_utc", run.ended_utc},
          {"devices", devices},
          {"sequences", sequences}};
}

}  // namespace

std::string identification_json(const ReportInput& input) {
  Json held_out = Json::array(), further = Json::array(), approvals = Json::array();
  for (const db::RunRecord& run : input.further) further.push_back(run_json(run));
  for (const db::ReportRecord& approval : input.approvals)
    approvals.push_back({{"number", approval.number},
                         {"approved_by", approval.approved_by},
                         {"approved_utc", approval.approved_utc},
                         {"replaces", approval.replaces}});
  for (const HeldOut& run : input.held_out) {
    held_out.push_back(run_json(run.run));
    held_out.back()["title"] = run.title;
  }
  Json sensor;
  if (input.sensor) {
    sensor = {{"serial", input.sensor->serial},
              {"type", input.sensor->type},
              {"type_sha256", input.sensor->type_sha256},
              {"scanner_serial", input.sensor->scanner_serial},
              {"note", input.sensor->note}};
  }
  return json_text({{"simulated", is_simulated(input)},
                    {"independent_pressure_reference", has_reference(input.run)},
                    {"report_program_version", input.program_version},
                    {"frame_count", input.frame_count},
                    {"run", run_json(input.run)},
                    {"sensor", sensor},
                    {"held_out", held_out},
                    {"further", further},
                    {"history", history_json(input.history)},
                    {"laboratory", laboratory_json(input.laboratory)},
                    {"models_sha256", input.fit.taxels.empty() ? "" : model_sha256(input.fit)},
                    {"approvals", approvals}});
}

std::string results_json(const ReportInput& input) {
  const Evaluation& e = input.evaluation;
  Json frames = Json::array(), traces = Json::array(), taxels = Json::array(), verdicts = Json::array(),
       held_out = Json::array();
  for (const LevelFigures& level : e.levels) {
    frames.push_back({{"pressure_psi", level.pressure_psi},
                      {"raw_up_v", number_list(level.raw_up_v)},
                      {"raw_down_v", number_list(level.raw_down_v)},
                      {"comp_up_psi", number_list(level.comp_up_psi)},
                      {"comp_down_psi", number_list(level.comp_down_psi)}});
  }
  for (const Trace& trace : e.traces) {
    traces.push_back({{"sequence", trace.sequence},
                      {"pressure_psi", number_list(trace.pressure_psi)},
                      {"measured_v", number_list(trace.measured_v)},
                      {"model_v", number_list(trace.model_v)},
                      {"compensated_psi", number_list(trace.compensated_psi)}});
  }
  for (std::size_t i = 0; i < input.fit.taxels.size(); ++i) {
    taxels.push_back(taxel_json(input.fit.taxels[i], static_cast<int>(i)));
  }
  for (const db::VerdictRecord& verdict : input.verdicts) {
    verdicts.push_back({{"criterion", verdict.criterion},
                        {"scope", verdict.scope},
                        {"value", verdict.value},
                        {"limit", verdict.limit},
                        {"unit", verdict.unit},
                        {"rule", verdict.rule},
                        {"verdict", verdict.verdict},
                        {"limits_sha256", verdict.limits_sha256}});
  }
  for (const HeldOut& run : input.held_out) {
    held_out.push_back(
        {{"title", run.title}, {"evaluation", evaluation_json(run.evaluation, fitted_taxels(input.fit))}});
  }
  return json_text({{"verdicts", verdicts},
                    {"evaluation", evaluation_json(e, fitted_taxels(input.fit))},
                    {"taxel_mean_error_psi", number_list(e.taxel_mean_error_psi)},
                    {"held_out", std::move(held_out)},
                    {"traces", std::move(traces)},
                    {"model",
                     {{"name", "elam"},
                      {"rows", input.fit.rows},
                      {"columns", input.fit.columns},
                      {"parameter_names", kElamParameterNames},
                      {"full_scale_v", input.fit.full_scale_v},
                      {"pressure_psi", number_list(input.fit.pressure_psi)},
                      {"mean_taxel", taxel_json(input.fit.mean_taxel, -1)},
                      {"taxels", std::move(taxels)}}},
                    {"frames", std::move(frames)}});
}

}  // namespace tactbench::analysis
