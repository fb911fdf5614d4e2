// The model document as JSON.

#include "analysis/identify/stored/model_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/counted.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/elam/elam.h"
#include "analysis/identify/histories.h"
#include "analysis/identify/residuals.h"
#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "analysis/models/model_json.h"
#include "analysis/read_whole_file.h"
#include "db/run_store.h"

namespace tactbench::analysis {
namespace {

using Json = nlohmann::ordered_json;
constexpr const char* kSchema = "tactbench.model";

Json range_json(const std::optional<Range>& range) {
  return range ? Json{{"low", range->low}, {"high", range->high}} : Json(nullptr);
}

std::optional<Range> range_from(const Json& json, const std::string& name) {
  const Json& range = json_member(json, name);
  if (range.is_null()) return std::nullopt;
  return Range{json_number(range, "low"), json_number(range, "high")};
}

std::string text_from(const Json& json, const std::string& name) {
  const Json& value = json_member(json, name);
  if (!value.is_string()) throw std::invalid_argument("\"" + name + "\" is not a text");
  return value.get<std::string>();
}

int integer_from(const Json& json, const std::string& name) {
  const double value = json_number(json, name);
  if (value != std::floor(value) || std::abs(value) > 1e9)
    throw std::invalid_argument("\"" + name + "\" is not a whole number");
  return static_cast<int>(value);
}

Json loop_json(const ModelTaxel& taxel) {
  const auto list = [](const PatternCurve& curve) { return std::vector<double>(curve.y().begin(), curve.y().end()); };
  return {{"ascending", list(taxel.ascending)}, {"descending", list(taxel.descending)}};
}

std::vector<double> numbers_from(const Json& json, const std::string& name) {
  const Json& list = json_member(json, name);
  if (!list.is_array() || !std::ranges::all_of(list, [](const Json& value) { return value.is_number(); }))
    throw std::invalid_argument("\"" + name + "\" is not a list of numbers");
  return list.get<std::vector<double>>();
}

// Of ELAM its patterns; of others what the document holds.
void read_loop(const Json& json, const std::vector<double>& inputs, ModelTaxel& taxel) {
  if (const ElamModel* const elam = elam_of(taxel)) {
    taxel.fit.at_bound = bounds_met(*elam);
    set_loop(taxel, elam->ascending.x(), elam->ascending.y(), elam->descending.y());
    return;
  }
  const Json& loop = json_member(json, "loop");
  const std::vector<double> up = numbers_from(loop, "ascending"), down = numbers_from(loop, "descending");
  if (up.size() != inputs.size() || down.size() != inputs.size() || inputs.size() < 2)
    throw std::invalid_argument("\"loop\" has not as many outputs as \"loop_inputs\" has inputs");
  taxel.ascending = PatternCurve(inputs, up, up.front(), up.back());
  taxel.descending = PatternCurve(inputs, down, down.front(), down.back());
}

Json taxel_json(const ModelTaxel& taxel, bool dynamic) {
  Json json = {{"taxel", taxel.taxel}, {"status", to_string(taxel.status)}, {"noise", taxel.noise}};
  if (!taxel.reason.empty()) json["reason"] = taxel.reason;
  if (taxel.fit.model == nullptr) return json;
  json["dead_band"] = kBandInNoises * taxel.noise;
  json["loop_low"] = taxel.loop_low;
  json["zero"] = taxel.zero;
  json["gain"] = taxel.gain;
  json["figures"] = {JSON_FIELDS(taxel.fit, j, mean_error, max_error, full_scale, samples, starts)};
  Json at_bound = Json::array();
  for (const ModelParameter& parameter : taxel.fit.model->parameters())
    if (parameter.at_bound()) at_bound.push_back(parameter.name);
  json["at_bound"] = at_bound;
  if (elam_of(taxel) == nullptr && !taxel.ascending.x().empty()) json["loop"] = loop_json(taxel);
  if (!taxel.fit.undetermined.empty()) json["undetermined"] = taxel.fit.undetermined;
  if (dynamic)
    add_taxel_dynamics(taxel, json);
  else if (taxel.residual_psi > 0.0)
    json["residual_psi"] = taxel.residual_psi;
  json["model"] = model_json(*taxel.fit.model);
  return json;
}

// What was computed and came to no number is null.
double figure_from(const Json& json, const std::string& name) {
  return json_member(json, name).is_null() ? std::nan("") : json_number(json, name);
}

ModelTaxel taxel_from(const Json& json, const std::vector<double>& inputs, bool dynamic) {
  ModelTaxel taxel;
  taxel.taxel = integer_from(json, "taxel");
  if (const std::string status = text_from(json, "status"); !status_from(status, taxel.status))
    throw std::invalid_argument("\"status\" is \"" + status + "\"");
  if (json.contains("reason")) taxel.reason = text_from(json, "reason");
  if (taxel.fitted() && !json.contains("model")) throw std::invalid_argument("\"model\" of a fitted taxel is missing");
  taxel.noise = taxel.fitted() ? json_number(json, "noise") : figure_from(json, "noise");
  if (taxel.noise < 0.0) throw std::invalid_argument("\"noise\" is negative");
  if (!json.contains("model")) return taxel;
  taxel.loop_low = json_number(json, "loop_low");
  taxel.zero = json_number(json, "zero");
  taxel.gain = json_number(json, "gain");
  if (taxel.gain <= 0.0) throw std::invalid_argument("\"gain\" is not positive");
  const Json& figures = json_member(json, "figures");
  taxel.fit.j = figure_from(figures, "j");
  taxel.fit.mean_error = figure_from(figures, "mean_error");
  taxel.fit.max_error = figure_from(figures, "max_error");
  taxel.fit.full_scale = figure_from(figures, "full_scale");
  taxel.fit.samples = integer_from(figures, "samples");
  taxel.fit.starts = integer_from(figures, "starts");
  for (const Json& name : json.value("undetermined", Json::array()))
    taxel.fit.undetermined.push_back(name.get<std::string>());
  if (dynamic)
    read_taxel_dynamics(json, taxel);
  else if (json.contains("residual_psi"))
    taxel.residual_psi = json_number(json, "residual_psi");
  if (taxel.residual_psi < 0.0) throw std::invalid_argument("\"residual_psi\" is negative");
  taxel.fit.model = model_from_json(json.at("model"));
  read_loop(json, inputs, taxel);
  return taxel;
}

SensorModel document_from(const Json& json) {
  if (text_from(json, "schema") != kSchema) throw std::invalid_argument("\"schema\" is not \"tactbench.model\"");
  const int version = integer_from(json, "version");
  if (version != kModelDocumentVersion)
    throw std::invalid_argument(
        fmt::format("it is of version {}, and this program reads version {}", version, kModelDocumentVersion));
  SensorModel document;
  document.model = text_from(json, "model");
  const Json& options = json_member(json, "options");
  document.options.free_run = text_from(options, "mode") == "free-run";
  document.options.exact_outer = json_flag(options, "exact_outer");
  document.options.genetic = json_flag(options, "genetic");
  document.options.memory = json_flag(options, "memory");
  document.options.splits = integer_from(options, "splits");
  document.options.starts = integer_from(options, "starts");
  document.options.linearise = options.contains("linearise") && json_flag(options, "linearise");
  document.input_unit = text_from(json_member(json, "input"), "unit");
  document.output_unit = text_from(json_member(json, "output"), "unit");
  document.falling = json_flag(json_member(json, "output"), "falling");
  document.scans = integer_from(json_member(json, "output"), "scans");
  const Json& source = json_member(json, "source");
  document.source = text_from(source, "name");
  document.origin = text_from(source, "origin");
  document.content_sha256 = text_from(source, "content_sha256");
  for (const Json& sequence : json_member(source, "sequences"))
    document.sequences.push_back(sequence.get<std::string>());
  const Json& sensor = json_member(json, "sensor");
  document.sensor_serial = text_from(sensor, "serial");
  document.scanner_serial = text_from(sensor, "scanner_serial");
  document.rows = integer_from(sensor, "rows");
  document.columns = integer_from(sensor, "columns");
  const Json& validity = json_member(json, "validity");
  document.validity = {range_from(validity, "input"), range_from(validity, "hold_s"),
                       range_from(validity, "rate"),  range_from(validity, "temperature_c"),
                       text_from(validity, "mount"),  text_from(validity, "interface_material")};
  const Json& parent = json_member(json, "parent");
  document.parent_sha256 = text_from(parent, "sha256");
  document.adjustment = text_from(parent, "adjustment");
  document.program_version = text_from(json, "program_version");
  if (json.contains("dynamics")) document.dynamics = dynamics_from(json.at("dynamics"));
  if (json.contains("loop_inputs")) document.pressure_psi = numbers_from(json, "loop_inputs");
  for (const Json& taxel : json_member(json, "taxels"))
    document.taxels.push_back(taxel_from(taxel, document.pressure_psi, document.dynamics.has_value()));
  if (document.taxels.empty()) throw std::invalid_argument("\"taxels\" is empty");
  for (const ModelTaxel& taxel : document.taxels) {
    if (!document.pressure_psi.empty() || taxel.fit.model == nullptr) continue;
    document.pressure_psi.assign(taxel.ascending.x().begin(), taxel.ascending.x().end());
  }
  return document;
}

Json to_json(const SensorModel& document) {
  Json json = {{"schema", kSchema}, {"version", kModelDocumentVersion}, {"model", document.model}};
  json["options"] = {{"mode", document.options.free_run ? "free-run" : "paper"},
                     JSON_FIELDS(document.options, exact_outer, genetic, memory, splits, starts)};
  if (document.options.linearise) json["options"]["linearise"] = true;
  json["input"] = {{"unit", document.input_unit}};
  json["output"] = {{"unit", document.output_unit}, JSON_FIELDS(document, falling, scans)};
  json["source"] = {{"name", document.source}, JSON_FIELDS(document, origin, content_sha256, sequences)};
  json["sensor"] = {{"serial", document.sensor_serial}, JSON_FIELDS(document, scanner_serial, rows, columns)};
  json["validity"] = {{"input", range_json(document.validity.input)},
                      {"hold_s", range_json(document.validity.hold_s)},
                      {"rate", range_json(document.validity.rate)},
                      {"temperature_c", range_json(document.validity.temperature_c)},
                      JSON_FIELDS(document.validity, mount, interface_material)};
  json["parent"] = {{"sha256", document.parent_sha256}, {"adjustment", document.adjustment}};
  json["program_version"] = document.program_version;
  // Of ELAM its patterns say so, but where they are of the linearised output.
  if (document.model != kElamFit || document.options.linearise) json["loop_inputs"] = document.pressure_psi;
  if (document.dynamics) json["dynamics"] = dynamics_json(*document.dynamics);
  json["taxels"] = Json::array();
  for (const ModelTaxel& taxel : document.taxels)
    json["taxels"].push_back(taxel_json(taxel, document.dynamics.has_value()));
  return json;
}

}  // namespace

std::string to_text(const SensorModel& document) { return to_json(document).dump(1) + "\n"; }
std::string to_line(const SensorModel& document) { return to_json(document).dump(); }

std::string sha256_of(const SensorModel& document) { return db::sha256_hex(to_text(document)); }

SensorModel document_from_text(const std::string& text, const std::string& file) {
  const auto refuse = [&](const std::string& what) -> AnalysisError {
    return {"TB-MODEL-DOCUMENT", fmt::format("{} is no model: {}", file, what),
            "give a file that tactbench fit -o or model export wrote"};
  };
  try {
    return document_from(parse_ordered_json(text));
  } catch (const nlohmann::json::exception& error) {
    throw refuse(error.what());
  } catch (const std::invalid_argument& error) {
    throw refuse(error.what());
  }
}

// Fits to and from the run store and MODEL of the command line.

namespace {

std::optional<std::int64_t> number_from(std::string_view text) {
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

// Whether reports and compensation of the whole array may rest on it where no fit is named.
bool is_default_fit(const SensorModel& fit, const std::string& label) {
  if (fit.dynamics) return label == kDynamicModel;
  return label == kElamFit && fit.origin != "imported" && fit.all_sequences && fit.parent_sha256.empty() &&
         fit.array().size() == static_cast<std::size_t>(fit.rows) * static_cast<std::size_t>(fit.columns);
}

// Each taxel of the array in its place.
bool is_whole(const SensorModel& fit) {
  const std::span<const ModelTaxel> array = fit.array();
  if (fit.rows <= 0 || fit.columns <= 0 || std::ssize(array) != std::int64_t{fit.rows} * fit.columns) return false;
  for (std::size_t i = 0; i < array.size(); ++i)
    if (array[i].taxel != static_cast<int>(i)) return false;
  return true;
}

[[noreturn]] void malformed(const db::FitRecord& record, const std::string& what) {
  throw AnalysisError(
      "TB-MODEL-STORED", fmt::format("fit {} of run {} cannot be read: {}", record.fit, record.run, what),
      fmt::format("fit the run again: tactbench fit {}; tactbench verify lists what else is damaged", record.run));
}

}  // namespace

std::string label_of(const SensorModel& document) {
  std::string label = document.model;
  if (document.options.free_run) label += ", free run";
  if (document.options.genetic && document.model == kElamFit) label += ", genetic";
  if (document.options.linearise && !document.dynamics) label += ", linearised";
  if (document.options.memory) label += ", memory";
  if (document.options.exact_outer) label += ", exact outer";
  if (document.options.splits > 1) label += fmt::format(", {} splits", document.options.splits);
  return label;
}

std::int64_t store_fit(db::RunStore& store, const SensorModel& model, const std::string& program_version,
                       const std::string& utc, const std::string& made_by) {
  SensorModel own = model;
  own.program_version = program_version;
  if (own.content_sha256.empty()) own.content_sha256 = store.run(own.run).content_sha256;
  db::FitRecord record;
  record.run = own.run;
  record.model = label_of(own);
  record.stands = is_default_fit(own, record.model);
  record.fitted = static_cast<int>(own.fitted().size());
  record.document = to_line(own);
  record.made_by = made_by;
  record.program_version = program_version;
  record.created_utc = utc;
  return store.add_fit(record);
}

SensorModel document_of(const db::FitRecord& record) {
  try {
    SensorModel fit = document_from_text(record.document, "what is stored");
    if (record.stands && !is_whole(fit)) malformed(record, "a taxel is missing");
    return fit;
  } catch (const AnalysisError& error) {
    if (error.id() == "TB-MODEL-STORED") throw;
    malformed(record, error.what());
  }
}

SensorModel load_fit(const db::FitRecord& record) {
  SensorModel fit = document_of(record);
  fit.run = record.run;
  fit.fit = record.fit;
  fit.all_sequences = record.stands;
  if (fit.origin != "imported") fit.source = fmt::format("run {}", record.run);
  return fit;
}

SensorModel load_fit(const db::Models& store, std::int64_t run) {
  const std::optional<db::FitRecord> record = store.default_fit(run);
  if (!record)
    throw AnalysisError("TB-ANALYSIS-NO-FIT", fmt::format("run {} has no stored fit", run),
                        fmt::format("make one: tactbench fit {}", run));
  return load_fit(*record);
}

SensorModel load_model(const std::string& model, const db::Models* store) {
  const auto colon = model.find(':');
  const auto run = number_from(std::string_view(model).substr(0, colon));
  if (!run) {
    return document_from_text(
        read_whole_file(model, {kMaxJsonBytes}, "TB-MODEL-OPEN",
                        "MODEL is the path of a .json file, or RUN or RUN:FIT of the store (--db)"),
        model);
  }
  if (store == nullptr)
    throw AnalysisError("TB-MODEL-OPEN", fmt::format("{} names a run, and no store is given", model), "add --db FILE");
  if (colon != std::string::npos) {
    const auto fit = number_from(std::string_view(model).substr(colon + 1));
    if (fit && store->fit(*fit).run == *run) return load_fit(store->fit(*fit));
    throw AnalysisError("TB-MODEL-OPEN", fmt::format("run {} has no fit \"{}\"", *run, model.substr(colon + 1)),
                        "tactbench runs show RUN lists its fits");
  }
  return load_fit(*store, *run);
}

namespace {

double within(const Json& json, const std::string& name, double low, double high) {
  const double value = json_number(json, name);
  if (value < low || value > high)
    throw std::invalid_argument("\"" + name + "\" is not within " + std::to_string(low) + " and " +
                                std::to_string(high));
  return value;
}

std::array<double, kCreepElements> elements_from(const Json& json, const std::string& name) {
  const std::vector<double> list = json_numbers(json, name);
  if (list.size() != kCreepElements || std::ranges::any_of(list, [](double value) { return value < 0.0; }))
    throw std::invalid_argument("\"" + name + "\" is not a list of three numbers from 0 on");
  std::array<double, kCreepElements> elements;
  std::ranges::copy(list, elements.begin());
  return elements;
}

Json source_json(const SensorDynamics::Source& source) { return {JSON_FIELDS(source, run, content_sha256)}; }

SensorDynamics::Source source_from(const Json& json, const std::string& name) {
  const Json& source = json_member(json, name);
  const double run = json_number(source, "run");
  const Json& hash = json_member(source, "content_sha256");
  if (run != std::floor(run) || std::abs(run) > 1e15 || !hash.is_string())
    throw std::invalid_argument("\"" + name + "\" names no run");
  return {static_cast<std::int64_t>(run), hash.get<std::string>()};
}

}  // namespace

nlohmann::ordered_json dynamics_json(const SensorDynamics& dynamics) {
  const Dynamics& d = dynamics.shared;
  return {JSON_FIELDS(d, creep_s, creep_share, creep_half, lag_s, lag_share),
          {"residual_shape", dynamics.residual_shape},
          {"rate", source_json(dynamics.rate)},
          {"creep", source_json(dynamics.creep)}};
}

SensorDynamics dynamics_from(const nlohmann::ordered_json& json) {
  SensorDynamics dynamics;
  Dynamics& d = dynamics.shared;
  d.creep_s = elements_from(json, "creep_s");
  if (std::ranges::find(d.creep_s, 0.0) != d.creep_s.end()) throw std::invalid_argument("a \"creep_s\" is 0");
  d.creep_share = elements_from(json, "creep_share");
  d.creep_half = within(json, "creep_half", 1e-9, 1e9);
  d.lag_s = within(json, "lag_s", 1e-9, 1e9);
  d.lag_share = within(json, "lag_share", 0.0, 0.9);
  dynamics.residual_shape = json_numbers(json, "residual_shape");
  if (std::ranges::any_of(dynamics.residual_shape, [](double value) { return value < 0.0; }))
    throw std::invalid_argument("\"residual_shape\" has a negative number");
  dynamics.rate = source_from(json, "rate");
  dynamics.creep = source_from(json, "creep");
  return dynamics;
}

void add_taxel_dynamics(const ModelTaxel& taxel, nlohmann::ordered_json& json) {
  json["creep_scale"] = taxel.creep_scale;
  json["lag_share"] = taxel.lag_share;
  json["residual_psi"] = taxel.residual_psi;
}

void read_taxel_dynamics(const nlohmann::ordered_json& json, ModelTaxel& taxel) {
  taxel.creep_scale = within(json, "creep_scale", 0.0, 10.0);
  taxel.lag_share = within(json, "lag_share", 0.0, 0.9);
  taxel.residual_psi = within(json, "residual_psi", 0.0, 1e9);
}

namespace {

std::string differing(const std::string& what, double stored, double recomputed) {
  return fmt::format("{}: stored {:.17g}, recomputed {:.17g}", what, stored, recomputed);
}

std::string differing_text(const std::string& what, const std::string& stored, const std::string& recomputed) {
  return fmt::format("{}: stored '{}', recomputed '{}'", what, stored, recomputed);
}

std::string compare_json(const std::string& what, const nlohmann::json& stored, const nlohmann::json& recomputed,
                         double tolerance);

// The elements of a model's "taxels" are named by their number.
std::string name_of_element(const std::string& what, std::size_t i, const nlohmann::json& element) {
  if (!element.is_object() || !element.contains("taxel") || !element["taxel"].is_number_integer())
    return fmt::format("{}[{}]", what, i);
  const int taxel = element["taxel"].get<int>();
  return taxel == kMeanTaxel ? "mean taxel" : fmt::format("taxel {}", taxel);
}

std::string compare_arrays(const std::string& what, const nlohmann::json& stored, const nlohmann::json& recomputed,
                           double tolerance) {
  if (stored.size() != recomputed.size())
    return fmt::format("{}: {} stored, {} recomputed", what, counted(stored.size(), "element"), recomputed.size());
  for (std::size_t i = 0; i < stored.size(); ++i) {
    std::string found = compare_json(name_of_element(what, i, recomputed[i]), stored[i], recomputed[i], tolerance);
    if (!found.empty()) return found;
  }
  return {};
}

std::string compare_objects(const std::string& what, const nlohmann::json& stored, const nlohmann::json& recomputed,
                            double tolerance) {
  for (const auto& [key, value] : stored.items()) {
    const std::string name = fmt::format("{}.{}", what, key);
    if (!recomputed.contains(key)) return differing_text(name, json_line(value), "nothing");
    std::string found = compare_json(name, value, recomputed[key], tolerance);
    if (!found.empty()) return found;
  }
  for (const auto& [key, value] : recomputed.items())
    if (!stored.contains(key)) return differing_text(fmt::format("{}.{}", what, key), "nothing", json_line(value));
  return {};
}

std::string compare_json(const std::string& what, const nlohmann::json& stored, const nlohmann::json& recomputed,
                         double tolerance) {
  if (stored.is_number() && recomputed.is_number()) {
    const auto a = stored.get<double>(), b = recomputed.get<double>();
    const bool same = tolerance > 0.0 ? same_number(a, b, tolerance)
                                      : std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
    return same ? std::string() : differing(what, a, b);
  }
  if (stored.is_array() && recomputed.is_array()) return compare_arrays(what, stored, recomputed, tolerance);
  if (stored.is_object() && recomputed.is_object()) return compare_objects(what, stored, recomputed, tolerance);
  return stored == recomputed ? std::string() : differing_text(what, json_line(stored), json_line(recomputed));
}

std::string scope_named(const db::VerdictRecord& v) {
  if (v.scope_kind == "array") return "verdict on " + v.criterion;
  return fmt::format("verdict on {} ({}, {:g} to {:g} psi, {}, share {:g})", v.criterion, v.scope_kind, v.low_psi,
                     v.high_psi, v.direction, v.share);
}

}  // namespace

bool same_number(double a, double b, double tolerance) {
  if (std::isnan(a) || std::isnan(b)) return std::isnan(a) && std::isnan(b);
  if (std::isinf(a) || std::isinf(b)) return a == b;
  return a == b || std::abs(a - b) <= tolerance * std::max(std::abs(a), std::abs(b));
}

std::string first_difference(const std::string& stored, const std::string& recomputed, double tolerance) {
  const nlohmann::json a = try_json(stored), b = try_json(recomputed);
  if (a.is_discarded()) return "model: what is stored cannot be read";
  return compare_json("model", a, b, tolerance);
}

std::string first_difference(const std::vector<db::VerdictRecord>& stored,
                             const std::vector<db::VerdictRecord>& recomputed, double tolerance, bool with_u) {
  if (stored.size() != recomputed.size()) {
    return fmt::format("{} stored, {} recomputed", counted(stored.size(), "verdict"), recomputed.size());
  }
  for (std::size_t i = 0; i < stored.size(); ++i) {
    const db::VerdictRecord &a = stored[i], &b = recomputed[i];
    const std::string name = scope_named(b);
    if (scope_named(a) != name) return differing_text(fmt::format("verdict {}", i + 1), scope_named(a), name);
    if (!same_number(a.value, b.value, tolerance)) return differing(fmt::format("{}, value", name), a.value, b.value);
    if (with_u && !same_number(a.expanded, b.expanded, tolerance))
      return differing(fmt::format("{}, U", name), a.expanded, b.expanded);
    if (!same_number(a.limit, b.limit, tolerance)) return differing(fmt::format("{}, limit", name), a.limit, b.limit);
    if (a.unit != b.unit) return differing_text(fmt::format("{}, unit", name), a.unit, b.unit);
    if (a.rule != b.rule) return differing_text(fmt::format("{}, rule", name), a.rule, b.rule);
    if (a.verdict != b.verdict) return differing_text(name, a.verdict, b.verdict);
    if (a.limits_sha256 != b.limits_sha256) {
      return differing_text("limits, SHA-256", a.limits_sha256, b.limits_sha256);
    }
  }
  return {};
}

}  // namespace tactbench::analysis
