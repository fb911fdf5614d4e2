#include "bench/cli/models/model_diff.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "analysis/counted.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/json_fields.h"
#include "bench/cli/runs/source.h"

namespace tactbench::bench {

using analysis::ModelParameter;
using analysis::ModelTaxel;
using analysis::SensorModel;

ShownInput shown_input(const SensorModel& model, analysis::PressureUnit unit) {
  if (model.input_unit != "psi") return {model.input_unit};
  return {unit.symbol(), unit.of(1.0)};
}

std::string parameter_unit(const std::string& unit, const SensorModel& model, const ShownInput& input) {
  std::string text;
  for (const char c : unit) {
    const bool known = (c == 'x' && !input.unit.empty()) || (c == 'y' && !model.output_unit.empty());
    text += known ? (c == 'x' ? input.unit : model.output_unit) : std::string(1, c);
  }
  return text;
}

double parameter_factor(const std::string& unit, const ShownInput& input) {
  const std::size_t at = unit.find('x');
  if (at == std::string::npos) return 1.0;
  const int power = unit.compare(at, 2, "x^") == 0 ? std::stoi(unit.substr(at + 2)) : 1;
  return std::pow(input.factor, unit.find('/') < at ? -power : power);
}

// Largest and mean difference of each parameter over the taxels that both models have.
void diff_models(const std::string& first, const std::string& second, Session& session) {
  const SensorModel a = load_model(first, session), b = load_model(second, session);
  if (a.model != b.model)
    throw Error("TB-MODEL-DIFF", fmt::format("one is {}, the other {}", a.model, b.model), "model diff");
  struct Line {
    std::string name, unit;
    double sum = 0.0, worst = 0.0;
    int count = 0, worst_taxel = 0;
    std::string other_unit;  // of the second model, where it is another
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
    // One that a model does not have is 0 there: c, a weight.
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
  if (only > 0) tty::print("{} fitted in the first alone\n", analysis::counted(only, "taxel is", "taxels are"));
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

}  // namespace tactbench::bench
