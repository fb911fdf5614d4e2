#include "analysis/report/data/data.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "analysis/documents/run_json.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "analysis/models/model_json.h"
#include "analysis/report/data/conformity.h"
#include "analysis/report/data/reading_figures.h"
#include "analysis/report/data/traceability.h"
#include "analysis/report/report_facts.h"
#include "db/run_store.h"

namespace tactbench::analysis {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kAroundDigits = 8;  // sign, point, "0.000" before a number or its exponent, comma

// As printf's %.<digits>g. Returns the end; there is room for it before `last`.
char* write_significant(char* to, char* last, double number, int digits) {
  if (!std::isfinite(number)) return std::copy_n("null", 4, to);
  return std::to_chars(to, last, number, std::chars_format::general, digits).ptr;
}

void append_string(std::string& text, const std::string& value) {
  const auto plain = [](char c) { return c >= ' ' && c <= '~' && c != '"' && c != '\\'; };
  if (std::ranges::all_of(value, plain)) {
    text += '"';
    text += value;
    text += '"';
  } else {
    text += Json(value).dump(-1, ' ', true, Json::error_handler_t::replace);
  }
}

void append_json(const Json& json, std::string& text) {
  const auto between = [&](bool& first) {
    if (!first) text += ',';
    first = false;
  };
  bool first = true;
  if (json.is_object()) {
    text += '{';
    for (const auto& [key, value] : json.items()) {
      between(first);
      append_string(text, key);
      text += ':';
      append_json(value, text);
    }
    text += '}';
  } else if (json.is_array()) {
    text += '[';
    for (const Json& value : json) {
      between(first);
      append_json(value, text);
    }
    text += ']';
  } else if (json.is_binary()) {
    const auto& finished = json.get_binary();
    text.append(reinterpret_cast<const char*>(finished.data()), finished.size());
  } else if (json.is_string()) {
    append_string(text, json.get_ref<const std::string&>());
  } else if (json.is_number_float()) {
    const auto number = json.get<double>();
    if (std::isfinite(number))
      fmt::format_to(std::back_inserter(text), "{}",
                     number);  // the fewest digits that distinguish it from its neighbours
    else
      text += "null";
  } else if (json.is_number_integer()) {
    const auto digits = json.is_number_unsigned() ? fmt::format_int(json.get<std::uint64_t>())
                                                  : fmt::format_int(json.get<std::int64_t>());
    text.append(digits.data(), digits.size());
  } else {
    text += json.is_boolean() ? (json.get<bool>() ? "true" : "false") : "null";
  }
}

}  // namespace

Json number_list(std::span<const double> values, int digits) {
  std::vector<std::uint8_t> text((static_cast<std::size_t>(digits) + kAroundDigits) * values.size() + 2);
  char* const begin = reinterpret_cast<char*>(text.data());
  char* const last = begin + text.size();
  char* to = begin;
  *to++ = '[';
  for (const double value : values) {
    if (to != begin + 1) *to++ = ',';
    to = write_significant(to, last, value, digits);
  }
  *to++ = ']';
  text.resize(static_cast<std::size_t>(to - begin));
  return Json::binary(std::move(text));
}

std::string json_text(const Json& json) {
  std::string text;
  append_json(json, text);
  return text;
}

namespace {

Json level_json(const LevelFigures& level, int fitted) {
  return {
      JSON_FIELDS(level, pressure_psi, up_psi, down_psi),
      {"raw_std_up_fs", level.raw_std_up},
      {"raw_std_down_fs", level.raw_std_down},
      {"raw_distance_fs", level.raw_distance},
      {"raw_mean_distance_fs", level.raw_mean_distance},
      {"comp_std_up_fs", level.comp_std_up},
      {"comp_std_down_fs", level.comp_std_down},
      {"comp_distance_fs", level.comp_distance},
      {"comp_mean_distance_fs", level.comp_mean_distance},
      {"comp_distance_observable_fs", observable(level, &LevelFigures::comp_distance_observable, fitted)},
      {"worst_taxel_distance_fs", level.worst_taxel_distance},
      {"worst_taxel_distance_observable_fs", observable(level, &LevelFigures::worst_taxel_distance_observable, fitted)},
      JSON_FIELDS(level, made_worse, flat_taxels)};
}

// Parameters in the order of "parameter_names"; patterns on "pressure_psi".
Json taxel_json(const ModelTaxel& taxel, int index) {
  Json out = {{"taxel", index}, {"status", to_string(taxel.status)}, {"noise_v", taxel.noise}};
  if (!taxel.fitted()) return out;
  out["parameters"] = Json::array();
  for (const ModelParameter& parameter : taxel.fit.model->parameters()) out["parameters"].push_back(parameter.value);
  out["at_bound"] = taxel.fit.at_bound;
  out["j_v2"] = taxel.fit.j;
  out["mean_error_v"] = taxel.fit.mean_error;
  out["max_error_v"] = taxel.fit.max_error;
  out["full_scale_v"] = taxel.full_scale();
  out["ascending_v"] = number_list(taxel.ascending.y());
  out["descending_v"] = number_list(taxel.descending.y());
  return out;
}

// Those of the mean taxel: Preisach's weights may be of another number in a taxel.
Json parameter_names(const SensorModel& fit) {
  Json names = Json::array();
  if (fit.taxels.empty() || fit.mean_taxel().fit.model == nullptr) return kElamParameterNames;
  for (const ModelParameter& parameter : fit.mean_taxel().fit.model->parameters()) names.push_back(parameter.name);
  return names;
}

// Lag and creep of a dynamic model, and the runs from which they were fitted, are included only if the model has them.
Json model_json(const SensorModel& fit) {
  const bool none = fit.taxels.empty();
  Json taxels = Json::array();
  for (std::size_t i = 0; i < fit.array().size(); ++i) {
    taxels.push_back(taxel_json(fit.taxels[i], static_cast<int>(i)));
    if (fit.dynamics && fit.taxels[i].fitted()) add_taxel_dynamics(fit.taxels[i], taxels.back());
  }
  Json json = {{"name", none ? "elam" : label_of(fit)},
               JSON_FIELDS(fit, rows, columns),
               {"parameter_names", parameter_names(fit)},
               {"full_scale_v", none ? 0.0 : fit.full_scale_v()},
               {"pressure_psi", number_list(fit.pressure_psi)}};
  if (fit.dynamics) json["dynamics"] = dynamics_json(*fit.dynamics);
  json["mean_taxel"] = taxel_json(none ? ModelTaxel{} : fit.mean_taxel(), -1);
  json["taxels"] = std::move(taxels);
  return json;
}

Json laboratory_json(const Laboratory& l) {
  Json instruments = Json::array();
  for (const InstrumentNote& note : l.instruments)
    instruments.push_back({JSON_FIELDS(note, serial, certificate, calibrated_by, calibrated_on, due, note)});
  return {JSON_FIELDS(l, laboratory, address, city, postcode, country, signer_function, place, accreditation, customer,
                      customer_address, order, received, condition, cable, mounting, medium, environment, deviations,
                      remarks, valid_until, recalibrate_after_months),
          {"instruments", instruments},
          {"sha256", l.sha256}};
}

Json run_log_json(const RunLog& history) {
  Json events = Json::array(), voids = Json::array(), surroundings = Json::array(), checks = Json::array();
  for (const RunLogEvent& event : history.events) events.push_back({JSON_FIELDS(event, time_s, kind, text)});
  for (const VoidBranch& branch : history.voids)
    voids.push_back({JSON_FIELDS(branch, sequence, repeat, branch, attempt, reason)});
  for (const EnvironmentRange& range : history.surroundings)
    surroundings.push_back({JSON_FIELDS(range, quantity, low, high, readings)});
  for (const db::CheckRecord& check : history.checks)
    checks.push_back({JSON_FIELDS(check, kind, verdict), {"detail", ordered_json_or_null(check.detail_json)}});
  return {JSON_FIELDS(history, frames, flagged, flags, void_frames),
          {"voids", voids},
          {"events", events},
          {"surroundings", surroundings},
          {"checks", checks}};
}

// Omits later remarks on a run (tags, notes), so that they do not change a report's bytes.
Json reported_run(const db::RunRecord& run, const Laboratory& laboratory) {
  Json json = run_json(run, laboratory.instruments);
  for (const char* said : {"tags", "notes"}) json.erase(said);
  for (std::size_t i = 0; i < run.devices.size(); ++i)
    json["devices"][i]["calibration"] = ordered_json_or_null(without_placeholders(run.devices[i].calibration_json));
  return json;
}

Json judged_json(const ReportInput& input, const JudgedFigure& figure) {
  Json json;
  json["on"] = title_of_judged(input, figure.run);
  json.update(figure_json(figure));
  return json;
}

// Runs are named by titles: the store's numbers are not part of a report's content.
void name_runs(const ReportInput& input, Json& json) {
  if (json.is_object() && json.contains("run")) {
    json["on"] = title_of_judged(input, json["run"].get<std::int64_t>());
    for (const char* number : {"run", "model_run"}) json.erase(number);
  }
  if (json.is_structured())
    for (Json& member : json) name_runs(input, member);
}

Json judgement_of(const ReportInput& input) {
  Json json = judgement_json(input.judgement);
  name_runs(input, json);
  for (Json& run : json["decided_by"]) run = title_of_judged(input, run.get<std::int64_t>());
  return json;
}

}  // namespace

Json whole_evaluation_json(const Evaluation& evaluation, int fitted) {
  Json json = evaluation_json(evaluation), levels = Json::array();
  for (const LevelFigures& level : evaluation.levels) levels.push_back(level_json(level, fitted));
  if (evaluation.max_error_taxel >= 0)
    json["largest_error"] = {{"error_psi", evaluation.max_error_psi},
                             {"taxel", evaluation.max_error_taxel},
                             {"pressure_psi", evaluation.max_error_at_psi}};
  json["levels"] = std::move(levels);
  return json;
}

std::string approvals_json(const ReportInput& input) {
  Json approvals = Json::array();
  for (const db::ReportRecord& approval : input.approvals)
    approvals.push_back({JSON_FIELDS(approval, number, approved_by, approved_utc, replaces, reason)});
  return json_text(approvals);
}

std::string identification_json(const ReportInput& input) {
  Json held_out = Json::array(), further = Json::array();
  for (const db::RunRecord& run : input.further) further.push_back(reported_run(run, input.laboratory));
  for (const HeldOut& run : input.held_out) {
    held_out.push_back(reported_run(run.run, input.laboratory));
    held_out.back()["title"] = run.title;
  }
  return json_text({{"simulated", is_simulated(input)},
                    {"independent_pressure_reference", has_reference(input.run)},
                    {"report_program_version", input.program_version},
                    {"frame_count", input.frame_count},
                    {"traceability", parse_ordered_json(traceability_json(input))},
                    {"method", input.method},
                    {"run", reported_run(input.run, input.laboratory)},
                    {"sensor", input.sensor ? sensor_json(*input.sensor) : Json()},
                    {"held_out", held_out},
                    {"further", further},
                    {"history", run_log_json(input.history)},
                    {"laboratory", laboratory_json(input.laboratory)},
                    {"models_sha256", input.fit.taxels.empty() ? "" : model_sha256(input.fit)},
                    {"approvals", parse_ordered_json(approvals_json(input))}});
}

std::string results_json(const ReportInput& input) {
  const Evaluation& e = input.evaluation;
  Json frames = Json::array(), applied = Json::array(), traces = Json::array(), verdicts = Json::array(),
       held_out = Json::array();
  for (const LevelFigures& level : e.levels) {
    frames.push_back({{"pressure_psi", level.pressure_psi},
                      {"raw_up_v", number_list(level.raw_up_v)},
                      {"raw_down_v", number_list(level.raw_down_v)},
                      {"comp_up_psi", number_list(level.comp_up_psi)},
                      {"comp_down_psi", number_list(level.comp_down_psi)}});
  }
  for (const Trace& trace : e.traces)
    traces.push_back({{"sequence", trace.sequence},
                      {"pressure_psi", number_list(trace.pressure_psi)},
                      {"measured_v", number_list(trace.measured_v)},
                      {"model_v", number_list(trace.model_v)},
                      {"compensated_psi", number_list(trace.compensated_psi)}});
  for (const AppliedPressures& own : input.applied)
    applied.push_back({JSON_FIELDS(own, title, verification, repeats),
                       {"time_s", number_list(own.time_s, 5)},
                       {"pressure_psi", number_list(own.pressure_psi, 5)}});
  for (const JudgedFigure& figure : input.judgement.figures) verdicts.push_back(judged_json(input, figure));
  for (const HeldOut& run : input.held_out) {
    held_out.push_back(
        {{"title", run.title}, {"evaluation", whole_evaluation_json(run.evaluation, fitted_taxels(input.fit))}});
  }
  const std::optional<ReadingFigures> readings = reading_figures(input);
  return json_text({{"verdicts", verdicts},
                    {"readings", readings ? reading_figures_json(*readings) : Json()},
                    {"judgement", judgement_of(input)},
                    {"evaluation", whole_evaluation_json(e, fitted_taxels(input.fit))},
                    {"taxel_mean_error_psi", number_list(e.taxel_mean_error_psi)},
                    {"held_out", std::move(held_out)},
                    {"applied", std::move(applied)},
                    {"traces", std::move(traces)},
                    {"model", model_json(input.fit)},
                    {"frames", std::move(frames)}});
}

// The output before correction and the sensor's health as data, and the hash of models.

std::string behaviour_json(const ReportInput& input) {
  const Behaviour& b = input.behaviour;
  nlohmann::ordered_json loops = nlohmann::ordered_json::array(), traces = nlohmann::ordered_json::array(),
                         repeatability = nlohmann::ordered_json::array(), zero = nlohmann::ordered_json::array(),
                         creep = nlohmann::ordered_json::array();
  for (const RawLoop& loop : b.loops)
    loops.push_back({JSON_FIELDS(loop, name, taxel, full_scale_v),
                     {"hysteresis_max_fs", loop.hysteresis_max},
                     {"hysteresis_mean_fs", loop.hysteresis_mean},
                     {"up_v", number_list(loop.up_v)},
                     {"down_v", number_list(loop.down_v)}});
  for (const RawTrace& trace : b.traces)
    traces.push_back({{"sequence", trace.sequence},
                      {"pressure_psi", number_list(trace.pressure_psi)},
                      {"output_v", number_list(trace.output_v)}});
  for (const LevelRepeatability& level : b.repeatability)
    repeatability.push_back({JSON_FIELDS(level, pressure_psi, mean_up_v, mean_down_v, taxel_up_v, taxel_down_v)});
  for (const ZeroReturn& z : b.zero_returns)
    zero.push_back({JSON_FIELDS(z, sequence, repeats, mean_v, largest_v, worst_taxel_v, worst_taxel)});
  for (const Creep& c : b.creep)
    creep.push_back({JSON_FIELDS(c, sequence, pressure_psi),
                     {"branch", c.up ? "up" : "down"},
                     JSON_FIELDS(c, from_s, to_s, first_v, last_v, per_decade, per_decade_u, samples)});
  return json_text({{"taxels", b.taxels},
                    {"pressure_psi", number_list(b.pressure_psi)},
                    {"full_scale_v", b.full_scale_v},
                    {"loops", loops},
                    {"hysteresis_max_fs", number_list(b.hysteresis_max)},
                    {"hysteresis_mean_fs", number_list(b.hysteresis_mean)},
                    {"traces", traces},
                    {"equilibration_psi", b.equilibration_psi},
                    {"gain", number_list(b.gain)},
                    {"repeats", b.repeats},
                    {"repeatability", repeatability},
                    {"zero_return", zero},
                    {"creep", creep}});
}

std::string health_json(const ReportInput& input) {
  const Health& health = input.health;
  nlohmann::ordered_json findings = nlohmann::ordered_json::array(), swaps = nlohmann::ordered_json::array();
  for (const TaxelHealth& finding : health.findings)
    findings.push_back({JSON_FIELDS(finding, taxel, state, reason, excluded)});
  for (const SwappedLines& swap : health.swaps)
    swaps.push_back({{"lines", swap.rows ? "rows" : "columns"},
                     JSON_FIELDS(swap, first, second),
                     {"correlation_as_is", swap.as_is},
                     {"correlation_exchanged", swap.exchanged}});
  return json_text({JSON_FIELDS(health.options, dead_v, noisy_factor),
                    {"median_noise_v", health.median_noise_v},
                    {"low_v", number_list(health.low_v)},
                    {"high_v", number_list(health.high_v)},
                    {"noise_v", number_list(health.noise_v)},
                    {"findings", findings},
                    {"swaps_assessed", health.swaps_assessed},
                    {"swaps", swaps}});
}

std::string model_sha256(const SensorModel& fit) {
  std::string bytes;
  const bool is_elam = paper_elam_of(fit.mean_taxel()) != nullptr;
  const auto add = [&](std::span<const double> values) {
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  };
  const auto add_taxel = [&](const ModelTaxel& taxel) {
    bytes += to_string(taxel.status);
    if (const ElamModel* const elam = paper_elam_of(taxel)) {
      const ElamParameters& p = elam->parameters;
      add(std::array{p.alpha_d, p.beta_d, p.alpha_a1, p.alpha_a0, p.beta_a});
    } else if (taxel.fit.model != nullptr) {
      bytes += model_json(*taxel.fit.model).dump();
    } else if (is_elam) {
      add(std::array{0.5, 0.5, 0.0, 0.5, 0.5});  // the numbers that reports have for a taxel without a model
    }
    for (const PatternCurve* curve : {&taxel.ascending, &taxel.descending}) add(curve->y());
    if (fit.dynamics) add(std::array{taxel.creep_scale, taxel.lag_share, taxel.residual_psi});
  };
  bytes.reserve((fit.array().size() + 1) * 32 * (fit.pressure_psi.size() + 3));
  add(fit.pressure_psi);
  add_taxel(fit.mean_taxel());
  for (const ModelTaxel& taxel : fit.array()) add_taxel(taxel);
  if (fit.dynamics) {
    const Dynamics& d = fit.dynamics->shared;
    add(d.creep_s);
    add(d.creep_share);
    add(std::array{d.creep_half, d.lag_s, d.lag_share});
    add(fit.dynamics->residual_shape);
  }
  return db::sha256_hex(bytes);
}

// The determined effects of creep and temperature, as JSON.

namespace {

using EffectJson = nlohmann::ordered_json;

EffectJson change_json(const OutputChange& change) { return {JSON_FIELDS(change, share, zero_v)}; }

}  // namespace

EffectJson creep_effect_json(const CreepEffect& creep) {
  EffectJson levels = EffectJson::array();
  for (const HeldLevel& level : creep.levels) {
    levels.push_back({JSON_FIELDS(level, sequence, pressure_psi),
                      {"branch", level.up ? "up" : "down"},
                      JSON_FIELDS(level, from_s, to_s, median_share),
                      {"taxel_share", number_list(level.share, 5)}});
  }
  return {{"read_after_s", creep.read_after_s},
          {"covered_to_s", creep.to_s},
          {"levels", std::move(levels)},
          {"carried_back", creep.extrapolated_back},
          {"basis", creep.display_text()}};
}

EffectJson temperature_effect_json(const TemperatureEffect& effect) {
  EffectJson runs = EffectJson::array();
  for (std::size_t i = 0; i < effect.temperature_c.size(); ++i)
    runs.push_back({{"temperature_c", effect.temperature_c[i]}, {"change", change_json(effect.change[i])}});
  return {{"per_kelvin", change_json(effect.per_kelvin)},
          {"u", change_json(effect.u)},
          {"dof", effect.dof},
          {"taxel_deviation", change_json(effect.deviation)},
          {"half_width_c", effect.half_width_c()},
          {"resolution_c", effect.resolution_c},
          {"runs", std::move(runs)},
          {"basis", effect.display_text()}};
}

}  // namespace tactbench::analysis
