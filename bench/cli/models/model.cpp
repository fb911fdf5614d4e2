// `model show`, `model adjust`, `model diff`, `fit --check`.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "analysis/counted.h"
#include "analysis/error.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/json_fields.h"
#include "analysis/statistics/sensor/drift.h"
#include "bench/cli/models/fit_models.h"
#include "bench/cli/models/model_table.h"
#include "bench/cli/runs/source.h"
#include "bench/cli/session.h"
#include "bench/common/build_info.h"
#include "bench/common/output_file.h"

namespace tactbench::bench {

namespace {

using analysis::ModelParameter;
using analysis::ModelTaxel;
using analysis::SensorModel;

// The displayed unit of a model's inputs, and the factor from the model's own unit to it. Only pressures are converted.
struct ShownInput {
  std::string unit;
  double factor = 1.0;
};

ShownInput shown_input(const SensorModel& model, analysis::PressureUnit unit) {
  if (model.input_unit != "psi") return {model.input_unit};
  return {unit.symbol(), unit.of(1.0)};
}

// "1/x" becomes "1/psi" if the model has the units of its input x and its output y.
std::string parameter_unit(const std::string& unit, const SensorModel& model, const ShownInput& input) {
  std::string text;
  for (const char c : unit) {
    const bool known = (c == 'x' && !input.unit.empty()) || (c == 'y' && !model.output_unit.empty());
    text += known ? (c == 'x' ? input.unit : model.output_unit) : std::string(1, c);
  }
  return text;
}

// The factor by which a parameter with the unit "x", "1/x" or "y/x^3" is multiplied for display.
double parameter_factor(const std::string& unit, const ShownInput& input) {
  const std::size_t at = unit.find('x');
  if (at == std::string::npos) return 1.0;
  const int power = unit.compare(at, 2, "x^") == 0 ? std::stoi(unit.substr(at + 2)) : 1;
  return std::pow(input.factor, unit.find('/') < at ? -power : power);
}

// Largest and mean difference of each parameter over the taxels that both models have.
// Prints the differences of the parameters of two models (names as `model diff` takes them) and sets the exit code: 1
// if they differ. Throws TB-MODEL-DIFF for models of different kinds.
void diff_models(const std::string& first, const std::string& second, Session& session) {
  const SensorModel a = load_model(first, session), b = load_model(second, session);
  if (a.model != b.model)
    throw Error("TB-MODEL-DIFF", fmt::format("one is {}, the other {}", a.model, b.model), "model diff");
  struct Line {
    std::string name, unit;
    double sum = 0.0, worst = 0.0;
    int count = 0, worst_taxel = 0;
    std::string other_unit;  // of the second model, if it differs
  };
  const ShownInput input = shown_input(a, session.unit()), other_input = shown_input(b, session.unit());
  std::vector<Line> lines;
  // By name: a taxel may lack a weight of Preisach's that another has.
  std::map<std::string, std::size_t, std::less<>> places;
  const auto add = [&](const std::string& name, const std::string& unit, double off, int taxel) {
    const auto [place, fresh] = places.try_emplace(name, lines.size());
    if (fresh) lines.push_back({name, unit, 0.0, 0.0, 0, 0, {}});
    Line& line = lines[place->second];
    line.sum += off;
    ++line.count;
    if (std::abs(off) > std::abs(line.worst)) {
      line.worst = off;
      line.worst_taxel = taxel;
    }
  };
  int only = 0;
  for (const ModelTaxel& own : a.taxels) {
    const auto other = std::ranges::find(b.taxels, own.taxel, &ModelTaxel::taxel);
    if (other == b.taxels.end() || !own.fit.model || !other->fit.model) {
      only += own.fit.model != nullptr ? 1 : 0;
      continue;
    }
    add("zero", a.output_unit, other->zero - own.zero, own.taxel);
    add("gain", "1", other->gain - own.gain, own.taxel);
    if (a.dynamics && b.dynamics) {
      add("creep_scale", "1", other->creep_scale - own.creep_scale, own.taxel);
      add("lag_share", "1", other->lag_share - own.lag_share, own.taxel);
    }
    // A parameter that a model does not have, c or a weight, counts as 0.
    const auto p = own.fit.model->parameters(), q = other->fit.model->parameters();
    for (const ModelParameter& mine : p) {
      const auto theirs = std::ranges::find(q, mine.name, &ModelParameter::name);
      add(mine.name, parameter_unit(mine.unit, a, input),
          parameter_factor(mine.unit, input) * ((theirs == q.end() ? 0.0 : theirs->value) - mine.value), own.taxel);
      if (theirs == q.end()) continue;
      const std::string unit = parameter_unit(theirs->unit, b, other_input);
      if (Line& line = lines[places.find(mine.name)->second]; line.unit != unit) line.other_unit = unit;
    }
    for (const ModelParameter& theirs : q)
      if (std::ranges::find(p, theirs.name, &ModelParameter::name) == p.end())
        add(theirs.name, parameter_unit(theirs.unit, b, other_input),
            parameter_factor(theirs.unit, other_input) * theirs.value, own.taxel);
  }
  const bool same = analysis::to_text(a) == analysis::to_text(b);
  session.code = same ? ExitCode::kPass : ExitCode::kCriterionFailed;
  if (session.json) {
    auto json = nlohmann::ordered_json::array();
    for (const Line& line : lines) {
      const auto figure = [&](double value) {  // null: of unlike quantities
        return line.other_unit.empty() ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
      };
      json.push_back({JSON_FIELDS(line, name, unit),
                      {"unit_of_second", line.other_unit.empty() ? line.unit : line.other_unit},
                      {"mean", figure(line.sum / line.count)},
                      {"largest", figure(line.worst)},
                      {"taxel", line.worst_taxel}});
    }
    print_json("model.diff", {{"same", same}, {"taxels_of_first_alone", only}, {"parameters", json}});
    return;
  }
  tty::print("{} against {}: {}\n", second, first, same ? "the same, byte for byte" : "not the same");
  if (only > 0) tty::print("{} fitted only in the first\n", analysis::counted(only, "taxel is", "taxels are"));
  analysis::doc::Table table{
      .columns = {{"parameter"}, {"mean difference", true}, {"largest", true}, {"taxel", true}, {"unit"}}};
  for (const Line& line : lines)
    if (line.other_unit.empty())
      table.rows.push_back({{line.name, fmt::format("{:.4g}", line.sum / line.count), fmt::format("{:.4g}", line.worst),
                             std::to_string(line.worst_taxel), line.unit}});
    else
      table.rows.push_back(
          {{line.name, "-", "-", "-",
            fmt::format("not compared: {} in the first, {} in the second", line.unit, line.other_unit)}});
  if (!lines.empty()) print_table(std::move(table));
}

std::string range_text(const std::optional<analysis::Range>& range, const std::string& unit, double factor = 1.0) {
  return range ? fmt::format("{:.4g} .. {:.4g} {}", factor * range->low, factor * range->high, unit) : "not known";
}

// The streams' residual, for the uncertainty; empty if it is not known.
std::string residual_text(const SensorModel& model, const ShownInput& input) {
  std::vector<double> residuals;
  for (const ModelTaxel& taxel : model.taxels)
    if (taxel.fitted() && taxel.residual_psi > 0.0 && (taxel.taxel != analysis::kMeanTaxel || model.taxels.size() == 1))
      residuals.push_back(taxel.residual_psi);
  if (residuals.empty()) return {};
  std::ranges::sort(residuals);
  return fmt::format("{:.3g} {} (median taxel; worst {:.3g}), by level and direction in the uncertainty",
                     input.factor * residuals[residuals.size() / 2], input.unit, input.factor * residuals.back());
}

void show(const std::string& name, const Session& session) {
  const SensorModel model = load_model(name, session);
  if (session.json) {
    tty::print("{}", analysis::to_text(model));
    return;
  }
  const ShownInput input = shown_input(model, session.unit());
  namespace doc = analysis::doc;
  std::vector<std::pair<std::string, doc::Phrase>> lines;
  const auto line = [&](const char* what, const std::string& value) {
    lines.emplace_back(what, value.empty() ? "not stated" : one_line(value, kMaxTextLength));
  };
  tty::print("{} of {} ({}), sha256 {}\n", analysis::label_of(model), one_line(model.source), one_line(model.origin),
             analysis::sha256_of(model).substr(0, 12));
  line("fitted on", fmt::format("{}", fmt::join(model.sequences, ", ")));
  line("content", model.content_sha256);
  line("sensor", fmt::format("{}, scanner {}", analysis::or_not_stated(model.sensor_serial),
                             analysis::or_not_stated(model.scanner_serial)));
  line("units", fmt::format("{} to {}{}", analysis::or_not_stated(model.input_unit),
                            analysis::or_not_stated(model.output_unit), model.falling ? ", falling" : ""));
  line("valid for",
       fmt::format("input {}; hold {}; rate {}; temperature {}",
                   range_text(model.validity.input, input.unit, input.factor), range_text(model.validity.hold_s, "s"),
                   range_text(model.validity.rate, input.unit + "/s", input.factor),
                   range_text(model.validity.temperature_c, "degC")));
  line("mount", model.validity.mount);
  line("interface", model.validity.interface_material);
  if (const std::string linearised = linearised_text(model); !linearised.empty()) line("output", linearised);
  if (const std::string dynamics = dynamics_text(model); !dynamics.empty()) line("in time", dynamics);
  if (!model.parent_sha256.empty())
    line("parent", fmt::format("{}: {}", model.parent_sha256.substr(0, 12), model.adjustment));
  std::map<std::string, int> statuses;
  const bool alone = model.taxels.size() == 1;
  bool with_mean = false;
  for (const ModelTaxel& taxel : model.taxels) {
    const bool mean = taxel.taxel == analysis::kMeanTaxel;
    with_mean = with_mean || mean;
    if (!mean || alone)
      ++statuses[alone && taxel.status == analysis::TaxelStatus::kUnfit ? "unfit (" + taxel.why() + ")"
                 : taxel.reason.empty()                                 ? analysis::to_string(taxel.status)
                                                                        : taxel.reason];
  }
  std::vector<std::string> counts;
  for (const auto& [status, count] : statuses) counts.push_back(fmt::format("{} {}", count, status));
  line("taxels", fmt::format("{}{}", fmt::join(counts, ", "), with_mean && !alone ? "; and the mean taxel" : ""));
  if (const std::string open = undetermined_text(model); !open.empty())
    line("left open", open.substr(0, open.size() - 1));
  if (const std::string left = residual_text(model, input); !left.empty()) line("stream leaves", left);
  print_table(doc::pairs({}, std::move(lines)));
  const ModelTaxel& shown = model.taxels.back();
  if (shown.fit.model == nullptr) return;
  tty::print("\n{}: J {:.6g}, mean error {:.3f} % FS, max {:.3f} % FS, full scale {:.4g} {}, noise {:.3g} {}\n",
             shown.taxel == analysis::kMeanTaxel ? "mean taxel" : fmt::format("taxel {}", shown.taxel), shown.fit.j,
             100.0 * shown.fit.mean_error / shown.fit.full_scale, 100.0 * shown.fit.max_error / shown.fit.full_scale,
             shown.fit.full_scale, model.output_unit, shown.noise, model.output_unit);
  const auto parameters = shown.fit.model->parameters();
  constexpr std::size_t kMost = 24;  // Preisach has hundreds: --json has them all
  doc::Table table{.columns = {{"parameter"}, {"value", true}, {"unit"}, {}}};
  for (std::size_t i = 0; i < std::min(kMost, parameters.size()); ++i)
    table.rows.push_back(
        {{parameters[i].name, fmt::format("{:.6g}", parameter_factor(parameters[i].unit, input) * parameters[i].value),
          parameter_unit(parameters[i].unit, model, input),
          parameters[i].fixed        ? "set by convention, not identified"
          : parameters[i].at_bound() ? "at its bound"
                                     : ""}});
  print_table(std::move(table));
  if (parameters.size() > kMost) tty::print("  and {} more (--json)\n", parameters.size() - kMost);
}

nlohmann::ordered_json drift_json(const analysis::Drift& drift) {
  auto taxels = nlohmann::ordered_json::array();
  for (const analysis::TaxelDrift& t : drift.taxels)
    taxels.push_back({{"taxel", t.taxel},
                      {"zero", t.zero_alone},
                      {"zero_with_gain", t.zero},
                      JSON_FIELDS(t, zero_u, gain, gain_u),
                      {"as_is_fs", t.as_is},
                      {"zeroed_fs", t.zeroed},
                      {"adjusted_fs", t.adjusted}});
  return {{"verdict", analysis::to_string(drift.verdict)},
          {"tolerance_fs", drift.tolerance},
          {"as_is_fs", drift.as_is},
          {"zeroed_fs", drift.zeroed},
          {"adjusted_fs", drift.adjusted},
          {"taxels", taxels}};
}

struct AdjustOptions {
  std::string model, by, output;
  bool zero = false, gain = false;
  TableOptions table;
};

void adjust(const AdjustOptions& options, const Session& session) {
  if (!options.zero && !options.gain)
    throw Error("TB-USAGE", "neither --zero nor --gain is given", "model adjust", "add --zero or --gain");
  check_output(options.output, kModelFile, session.replace);
  const SensorModel parent = load_model(options.model, session);
  const analysis::Histories by = read_source(options.by, options.table, session);
  const analysis::Drift drift = analysis::drift_of(parent, by);
  SensorModel child = analysis::adjusted(load_model(options.model, session), drift, by, options.gain);
  child.program_version = build_info().version;
  write_output(options.output, analysis::to_text(child), session.replace);
  if (session.json) {
    print_json("model.adjust", {{"parent_sha256", child.parent_sha256},
                                {"sha256", analysis::sha256_of(child)},
                                {"path", options.output},
                                {"drift", drift_json(drift)}});
    return;
  }
  tty::print("{}: {}\n  mean residual on {}: {:.3f} % FS before, {:.3f} after; parent {}\n", options.output,
             child.adjustment, by.source, 100.0 * drift.as_is, 100.0 * (options.gain ? drift.adjusted : drift.zeroed),
             child.parent_sha256.substr(0, 12));
}

}  // namespace

void check_model(const std::string& name, const FitModelsOptions& options, Session& session) {
  const SensorModel model = load_model(name, session);
  const analysis::Histories histories = read_source(options.source, options.table, session);
  const analysis::Drift drift = analysis::drift_of(model, histories);
  if (drift.verdict == analysis::DriftVerdict::kRecalibrate) session.code = ExitCode::kCriterionFailed;
  if (session.json) {
    nlohmann::ordered_json json = drift_json(drift);
    json["outside_validity"] = analysis::outside_validity(model, histories);
    print_json("model.check", json);
    return;
  }
  tty::print("{} of {} on {}: {}\n", analysis::label_of(model), model.source, histories.source, display_text(drift));
  for (const std::string& line : analysis::outside_validity(model, histories))
    tty::print("  outside the model's validity: {}\n", line);
  tty::print("  mean residual of {}, % FS: unchanged {:.3f}, re-zeroed {:.3f}, with gain {:.3f} (tolerance {:.3f})\n",
             analysis::counted(drift.taxels.size(), "taxel"), 100.0 * drift.as_is, 100.0 * drift.zeroed,
             100.0 * drift.adjusted, 100.0 * drift.tolerance);
  std::vector<analysis::TaxelDrift> worst = drift.taxels;
  std::ranges::stable_sort(worst, std::ranges::greater{}, &analysis::TaxelDrift::as_is);
  worst.resize(std::min<std::size_t>(worst.size(), 5));
  namespace doc = analysis::doc;
  doc::Table table{
      .columns = {
          {"taxel", true}, {fmt::format("zero ± u, {}", model.output_unit), true}, {"gain ± u", true}, {"% FS", true}}};
  for (const analysis::TaxelDrift& t : worst)
    table.rows.push_back({{std::to_string(t.taxel), doc::number_with_u(t.zero, t.zero_u),
                           doc::number_with_u(t.gain, t.gain_u), doc::percent_of(t.as_is, 3)}});
  print_table(std::move(table));
}

void add_model(CLI::App& app, Session& session) {
  CLI::App* model = app.add_subcommand("model", "show, check, adjust, compare or write out stored models");
  model->require_subcommand(1);
  const char* what = "a .json that fit -o wrote, or RUN or RUN:FIT of the store";
  auto first = std::make_shared<std::string>(), second = std::make_shared<std::string>();
  CLI::App* show_verb = model->add_subcommand("show", "show a model and its parameters");
  show_verb->add_option("model", *first, what)->required();
  add_void_too(*show_verb, session);
  show_verb->callback([first, &session] { show(*first, session); });
  auto checked = std::make_shared<FitModelsOptions>();
  CLI::App* check_verb = model->add_subcommand(
      "check", "check whether a model is still valid on a run or table, and what is needed if not");
  check_verb->add_option("model", *first, what)->required();
  check_verb->add_option("source", checked->source, "run number or table")->required();
  add_table_options(*check_verb, checked->table);
  add_void_too(*check_verb, session);
  check_verb->callback([first, checked, &session] { check_model(*first, *checked, session); });
  CLI::App* diff_verb =
      model->add_subcommand("diff", "compare the parameters of two models of one kind; exit code 1 if they differ");
  diff_verb->add_option("first", *first, what)->required();
  diff_verb->add_option("second", *second, what)->required();
  add_void_too(*diff_verb, session);
  diff_verb->callback([first, second, &session] { diff_models(*first, *second, session); });
  auto options = std::make_shared<AdjustOptions>();
  CLI::App* adjust_verb =
      model->add_subcommand("adjust", "make a copy of a model with its zero (and gain) adjusted to a short run");
  adjust_verb->add_option("model", options->model, what)->required();
  adjust_verb->add_option("by", options->by, "run number or table to which to adjust")->required();
  adjust_verb->add_flag("--zero", options->zero, "adjust the zero of each taxel");
  adjust_verb->add_flag("--gain", options->gain, "adjust its gain, too");
  adjust_verb->add_option("-o,--output", options->output, "file to write")->required();
  add_replace(*adjust_verb, session);
  add_table_options(*adjust_verb, options->table);
  add_void_too(*adjust_verb, session);
  adjust_verb->callback([options, &session] { adjust(*options, session); });
  add_subverbs(*model, session);
}

}  // namespace tactbench::bench
