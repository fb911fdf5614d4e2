#include "bench/cli/models/model_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "analysis/counted.h"
#include "analysis/json_fields.h"
#include "bench/common/build_info.h"

namespace tactbench::bench {

namespace doc = analysis::doc;

namespace {

// The mean taxel, which is at the end, if there are several; else the last one with a model.
const analysis::ModelTaxel& shown(const analysis::SensorModel& document) {
  return *std::find_if(document.taxels.rbegin(), document.taxels.rend(),
                       [](const analysis::ModelTaxel& taxel) { return taxel.fit.model != nullptr; });
}

// Without the mean, unless it is alone.
std::span<const analysis::ModelTaxel> own_taxels(const analysis::SensorModel& document) {
  return document.array().empty() ? std::span(document.taxels) : document.array();
}

// Three digits.
std::string digits(double value) {
  return value != 0.0 && (std::abs(value) < 1e-3 || std::abs(value) >= 1e4)
             ? fmt::format("{:.1e}", value)
             : fmt::format("{:.{}f}", value,
                           std::abs(value) < 1.0     ? 3
                           : std::abs(value) < 100.0 ? 2
                                                     : 0);
}

// Models whose inverse has larger errors than a straight line.
std::vector<std::string> worse_than_line(const std::vector<ModelRow>& rows, std::size_t target) {
  std::vector<std::string> labels;
  for (const ModelRow& row : rows)
    if (row.scores[target].worse_than_line()) labels.push_back(row.label);
  return labels;
}

// Of bins: the factors of their ends, and of the errors in them.
struct ShownBins {
  std::string title, unit;
  double ends = 1.0, errors = 1.0;
};

void add_bins(doc::Document& out, const ShownBins& shown, const std::vector<ModelRow>& rows, std::size_t target,
              std::vector<analysis::Bin> analysis::Score::*bins) {
  const auto& first = rows.front().scores[target].taxels.*bins;
  if (first.size() < 2) return;
  doc::Table table{.caption = shown.title + ", mean compensation error by model",
                   .columns = {{shown.unit, true}, {"samples", true}}};
  for (const ModelRow& row : rows) table.columns.push_back({row.label, true});
  for (std::size_t b = 0; b < first.size(); ++b) {
    doc::Row& line = table.rows.emplace_back();
    line.cells = {fmt::format("{:.4g} .. {:.4g}", shown.ends * first[b].low, shown.ends * first[b].high),
                  std::to_string(first[b].error.samples)};
    for (const ModelRow& row : rows) {
      const auto& own = row.scores[target].taxels.*bins;
      line.cells.emplace_back(digits(b < own.size() ? shown.errors * own[b].error.mean() : 0.0));
    }
  }
  out.add(std::move(table));
}

nlohmann::ordered_json error_json(const analysis::ErrorSum& error) {
  return {{"mean", error.mean()}, JSON_FIELDS(error, max, samples)};
}

nlohmann::ordered_json bins_json(const std::vector<analysis::Bin>& bins) {
  auto json = nlohmann::ordered_json::array();
  for (const analysis::Bin& bin : bins)
    json.push_back({JSON_FIELDS(bin, low, high), {"compensated", error_json(bin.error)}});
  return json;
}

nlohmann::ordered_json score_json(const analysis::Score& score) {
  return {{"direct", error_json(score.direct)},           {"free_running", error_json(score.free_running)},
          {"compensated", error_json(score.compensated)}, {"raw", error_json(score.raw)},
          {"by_hold_s", bins_json(score.by_hold)},        {"by_rate", bins_json(score.by_rate)}};
}

}  // namespace

std::string left_out_text(const analysis::SensorModel& document) {
  constexpr std::size_t kNamed = 3;
  std::size_t count = 0;
  std::string text;
  for (const analysis::ModelTaxel& taxel : own_taxels(document)) {
    if (taxel.fitted() || ++count > kNamed) continue;
    const bool unfit = taxel.status == analysis::TaxelStatus::kUnfit;
    text += fmt::format("{}: {} is {}{}\n", analysis::label_of(document),
                        taxel.taxel == analysis::kMeanTaxel ? "the mean taxel" : fmt::format("taxel {}", taxel.taxel),
                        analysis::to_string(taxel.status), unfit ? ": " + taxel.why() : "");
  }
  if (count > kNamed) text += fmt::format("{} more are not fitted\n", analysis::counted(count - kNamed, "taxel"));
  return text;
}

bool any_unfit(const analysis::SensorModel& document) {
  return std::ranges::any_of(own_taxels(document), [](const analysis::ModelTaxel& taxel) {
    return taxel.status == analysis::TaxelStatus::kUnfit;
  });
}

std::string undetermined_text(const analysis::SensorModel& document) {
  std::vector<std::string> names;
  int left_open = 0;
  const std::span<const analysis::ModelTaxel> taxels = own_taxels(document);
  for (const analysis::ModelTaxel& taxel : taxels) {
    if (!taxel.fit.undetermined.empty()) ++left_open;
    for (const std::string& name : taxel.fit.undetermined)
      if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  if (names.empty()) return {};
  return fmt::format("{}: the data do not determine {} ({} of {})\n", analysis::label_of(document),
                     fmt::join(names, ", "), left_open, analysis::counted(taxels.size(), "taxel"));
}

std::vector<ModelRow> model_rows(const std::vector<std::string>& models, const analysis::Histories& histories,
                                 const std::vector<std::string>& sequences, const analysis::IdentifyOptions& options,
                                 const std::vector<ScoreTarget>& targets, std::vector<ModelRefusal>* refusals,
                                 const std::function<void(const std::string&)>& begun) {
  std::vector<ModelRow> rows;
  for (const std::string& model : models) {
    if (begun) begun(model);
    ModelRow row;
    try {
      row.document = analysis::fit_models(model, histories, sequences, options);
    } catch (const analysis::AnalysisError& error) {
      const bool last = rows.empty() && &model == &models.back();
      if (refusals == nullptr || last || (error.id() != "TB-ANALYSIS-NO-LOOP" && error.id() != "TB-ANALYSIS-MODEL"))
        throw;
      refusals->push_back({model, error.what()});
      continue;
    }
    row.document.program_version = build_info().version;
    row.label = analysis::label_of(row.document);
    for (const ScoreTarget& target : targets)
      row.scores.push_back(analysis::score_model(row.document, *target.histories, target.sequences));
    rows.push_back(std::move(row));
  }
  return rows;
}

void cross_validate(std::vector<ModelRow>& rows, const analysis::Histories& histories,
                    const std::vector<std::string>& sequences) {
  for (ModelRow& row : rows) {
    const auto own = std::ranges::find(histories.taxels, shown(row.document).taxel, &analysis::TaxelHistories::taxel);
    row.crossed =
        analysis::cross_validate(row.document.model, analysis::fit_data_of(*own, sequences), row.document.options);
  }
}

doc::Document fits_document(const std::vector<ModelRow>& rows, bool all) {
  doc::Document out;
  doc::Table table{.columns = {{"model"},
                               {"taxels", true},
                               {"error of fit\nmean, % FS", true},
                               {"largest\n% FS", true},
                               {"cross-validated\nmean, % FS", true}}};
  if (all) table.columns.insert(table.columns.end(), {{"para-\nmeters", true}, {"J", true}, {"opera-\ntions", true}});
  for (const ModelRow& row : rows) {
    const analysis::ModelFit& fit = shown(row.document).fit;
    const bool alone = row.document.taxels.size() == 1;
    const auto taxels = std::ranges::count_if(row.document.taxels, [&](const analysis::ModelTaxel& t) {
      return t.fit.model != nullptr && (alone || t.taxel != analysis::kMeanTaxel);
    });
    const auto percent = [&](double error) { return digits(100.0 * error / fit.full_scale); };
    doc::Row& line = table.rows.emplace_back();
    line.cells = {row.label, std::to_string(taxels), percent(fit.mean_error), percent(fit.max_error),
                  row.crossed.samples > 0 ? percent(row.crossed.mean()) : "-"};
    if (!all) continue;
    line.cells.emplace_back(std::to_string(fit.model->parameters().size()));
    line.cells.emplace_back(fmt::format("{:.4g}", fit.j));
    line.cells.emplace_back(std::to_string(fit.model->operations_per_sample()));
  }
  out.add(std::move(table));
  for (const ModelRow& row : rows) {
    const std::string text = undetermined_text(row.document) + left_out_text(row.document);
    if (!text.empty()) out.add(doc::Paragraph{{text.substr(0, text.size() - 1)}});
    if (row.document.model == "gpi")
      out.add(doc::Paragraph{{"gpi: found by a search, which may miss the least J; the other fits are exact"}});
  }
  return out;
}

doc::Document scores_document(const std::vector<ModelRow>& rows, const std::vector<ScoreTarget>& targets,
                              const std::string& unit_of_input, analysis::PressureUnit shown, bool all) {
  const bool pressure = unit_of_input == "psi";
  const std::string unit = pressure ? shown.symbol() : unit_of_input;
  const double factor = pressure ? shown.of(1.0) : 1.0;
  doc::Document out;
  const auto add = [&](const std::string& text) { out.add(doc::Paragraph{{text}}); };
  for (std::size_t t = 0; t < targets.size(); ++t) {
    const analysis::ModelScore& any = rows.front().scores[t];
    const bool array = any.count > 1;
    doc::Table table{
        .caption = fmt::format("\nscored on {} ({}{})", targets[t].title,
                               analysis::counted(any.taxels.direct.samples, "sample"),
                               array ? fmt::format(", {} taxels", any.count) : std::string()),
        .columns = {
            {"model"}, {fmt::format("compensated\nmean, {}", unit), true}, {fmt::format("largest\n{}", unit), true}}};
    if (array) table.columns.push_back({fmt::format("mean taxel\nmean, {}", unit), true});
    if (all)
      table.columns.insert(
          table.columns.end(),
          {{"direct\nmean, % FS", true}, {"largest", true}, {"free running\nmean, % FS", true}, {"largest", true}});
    const auto begin = [&](const std::string& label, const analysis::ErrorSum& taxels, const analysis::ErrorSum& mean) {
      doc::Row& line = table.rows.emplace_back();
      line.cells = {label, digits(factor * taxels.mean()), digits(factor * taxels.max)};
      if (array) line.cells.emplace_back(digits(factor * mean.mean()));
    };
    begin("none (straight line)", any.taxels.raw, any.mean.raw);
    for (const ModelRow& row : rows) {
      const analysis::ModelScore& score = row.scores[t];
      begin(row.label, score.taxels.compensated, score.mean.compensated);
      for (const analysis::ErrorSum* const error : {&score.taxels.direct, &score.taxels.free_running})
        for (const double value : {error->mean(), error->max})
          if (all) table.rows.back().cells.emplace_back(digits(100.0 * value / score.full_scale));
    }
    out.add(std::move(table));
    if (const std::vector<std::string> worse = worse_than_line(rows, t); !worse.empty())
      add(fmt::format("worse than a straight line on the held-out data: {}", fmt::join(worse, "; ")));
    for (const std::string& line :
         analysis::outside_validity(rows.front().document, *targets[t].histories, targets[t].sequences, shown))
      add("outside the models' validity: " + line);
    if (!all) continue;
    add_bins(out, {"by hold time", "s", 1.0, factor}, rows, t, &analysis::Score::by_hold);
    add_bins(out, {"by rate", unit + "/s", factor, factor}, rows, t, &analysis::Score::by_rate);
  }
  return out;
}

nlohmann::ordered_json model_row_json(const ModelRow& row, const std::vector<ScoreTarget>& targets) {
  const analysis::ModelFit& fit = shown(row.document).fit;
  nlohmann::ordered_json json = {{"model", row.label}, {"fit", row.document.fit}};
  json["left_out"] = nlohmann::ordered_json::array();
  for (const analysis::ModelTaxel& own : own_taxels(row.document))
    if (!own.fitted())
      json["left_out"].push_back(
          {{"taxel", own.taxel}, {"status", analysis::to_string(own.status)}, {"why", own.why()}});
  auto parameters = nlohmann::ordered_json::array();
  for (const analysis::ModelParameter& p : fit.model->parameters())
    parameters.push_back({JSON_FIELDS(p, name, value, unit), {"at_bound", p.at_bound()}});
  nlohmann::ordered_json taxel = {{"taxel", shown(row.document).taxel},
                                  JSON_FIELDS(fit, j, mean_error, max_error, full_scale, samples, starts, undetermined),
                                  {"operations_per_sample", fit.model->operations_per_sample()}};
  if (row.crossed.samples > 0) taxel["cross_validated"] = error_json(row.crossed);
  taxel["parameters"] = std::move(parameters);
  json["shown_taxel"] = std::move(taxel);
  json["scores"] = nlohmann::ordered_json::array();
  for (std::size_t t = 0; t < targets.size(); ++t)
    json["scores"].push_back(
        {{"on", targets[t].title},
         {"taxels", row.scores[t].count},
         {"outside_validity", analysis::outside_validity(row.document, *targets[t].histories, targets[t].sequences)},
         {"all", score_json(row.scores[t].taxels)},
         {"mean_taxel", score_json(row.scores[t].mean)},
         {"full_scale", row.scores[t].full_scale},
         {"worse_than_line", row.scores[t].worse_than_line()}});
  return json;
}

}  // namespace tactbench::bench
