#include "bench/cli/models/fit_models.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench/cli/models/model_table.h"
#include "bench/common/output_file.h"
#include "bench/common/utc.h"

namespace tactbench::bench {

namespace {

std::vector<std::string> not_fitted(const analysis::Histories& histories, const std::vector<std::string>& fitted) {
  std::vector<std::string> others;
  for (const std::string& name : histories.sequences)
    if (!fitted.empty() && std::ranges::find(fitted, name) == fitted.end()) others.push_back(name);
  return others;
}

// What is scored is named once, and is not what the models are made from.
void check_scored(const FitModelsOptions& options, const analysis::Histories& histories) {
  // 01 and 1 are one run.
  const auto plain = [](const std::string& name) { return names_run(name) ? std::to_string(std::stoll(name)) : name; };
  std::vector<std::string> named;
  for (const std::string& name : options.score) {
    const bool sequence = std::ranges::find(histories.sequences, name) != histories.sequences.end();
    if (std::ranges::find(named, sequence ? name : plain(name)) != named.end())
      throw Error(ExitCode::kUsage, "TB-RUN-TWICE", fmt::format("'{}' is named twice", name), "--score",
                  "name each run, table or sequence once");
    named.push_back(sequence ? name : plain(name));
    if (!sequence && plain(name) == plain(options.source))
      throw Error(ExitCode::kUsage, "TB-RUN-OWN",
                  fmt::format("the models are made from {}: it is no independent data for them", histories.source),
                  "--score", "name other runs or tables, or with --fit the sequences to fit, and score on the others");
  }
}

}  // namespace

void fit_models(const FitModelsOptions& options, Session& session) {
  if (!options.output.empty() && options.models.size() != 1)
    throw Error(ExitCode::kUsage, "TB-USAGE", "--output takes one model, and several are named", "fit --output",
                "name one with --model");
  if (!options.output.empty()) check_output(options.output, kModelFile, session.replace);  // before an hour of anything
  const auto read = [&](const std::string& source) {
    analysis::Histories histories = read_source(source, options.table, session);
    return options.mean_taxel ? analysis::mean_taxel_of(std::move(histories)) : histories;
  };
  const analysis::Histories histories = read(options.source);
  check_scored(options, histories);
  // Others first: a name that is not there costs no fit.
  std::vector<analysis::Histories> others;
  others.reserve(options.score.size());
  std::vector<ScoreTarget> targets;
  std::vector<std::string> own;
  for (const std::string& name : options.score) {
    if (std::ranges::find(histories.sequences, name) != histories.sequences.end()) {
      own.push_back(name);
      continue;
    }
    others.push_back(read(name));
    targets.push_back({names_run(name) ? "run " + name : name, &others.back(), {}});
  }
  if (options.score.empty()) own = not_fitted(histories, options.fit);
  if (!own.empty())
    targets.insert(targets.begin(), {fmt::format("{} of {}", fmt::join(own, ", "), histories.source), &histories, own});

  std::vector<ModelRow> rows = model_rows(options.models, histories, options.fit, options.identify, targets);
  std::optional<db::RunStore> store;
  if (names_run(options.source)) store = db::RunStore::open(session.db);
  for (ModelRow& row : rows) {
    row.document.validity.mount = options.mount;
    row.document.validity.interface_material = options.interface_material;
    if (store) row.fit = analysis::store_model(*store, std::stoll(options.source), row.document, utc_now());
  }
  if (!options.output.empty()) write_output(options.output, analysis::to_text(rows.front().document), session.replace);
  if (session.json) {
    auto json = nlohmann::ordered_json::array();
    for (const ModelRow& row : rows) json.push_back(model_row_json(row, targets));
    print_json("fit", {{"source", histories.source},
                       {"origin", histories.origin},
                       {"input_unit", histories.input_unit},
                       {"output_unit", histories.output_unit},
                       {"falling", histories.falling},
                       {"fitted", rows.front().document.sequences},
                       {"models", json}});
    return;
  }
  tty::print("{} ({}): fitted on {}{}{}\n\n", histories.source, histories.origin,
             fmt::join(rows.front().document.sequences, ", "),
             histories.taxels.back().taxel == analysis::kMeanTaxel ? "; figures of the mean taxel" : "",
             histories.falling ? "; the output falls with the input and is negated" : "");
  tty::print("{}{}", fits_table(rows),
             scores_table(rows, targets, histories.input_unit.empty() ? "input units" : histories.input_unit));
  if (targets.empty()) tty::print("\nnothing was held out: --fit SEQ,... or --score names what to score on\n");
}

}  // namespace tactbench::bench
