#include "bench/cli/models/model_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "analysis/counted.h"
#include "bench/common/build_info.h"

namespace tactbench::bench {

namespace {

// The mean taxel where there are several, else the last that has a model: the mean stands at the end.
const analysis::ModelTaxel& shown(const analysis::SensorModel& document) {
  return *std::find_if(document.taxels.rbegin(), document.taxels.rend(),
                       [](const analysis::ModelTaxel& taxel) { return taxel.fit.model != nullptr; });
}

// Without the mean, unless it is alone.
std::span<const analysis::ModelTaxel> own_taxels(const analysis::SensorModel& document) {
  return document.array().empty() ? std::span(document.taxels) : document.array();
}

// Right in `width`, with a blank before it whatever its size.
std::string number_cell(double value, int decimals, int width) {
  std::string text = fmt::format("{:.{}f}", value, decimals);
  if (text.size() >= static_cast<std::size_t>(width)) text = fmt::format("{:.1e}", value);  // 8 at most
  return fmt::format("{:>{}}", text, width);
}

std::string percent_cell(double error, double full_scale, int width) {
  return number_cell(100.0 * error / full_scale, 3, width);
}

// Models whose inverse errs more than a straight line does.
std::vector<std::string> worse_than_line(const std::vector<ModelRow>& rows, std::size_t target) {
  std::vector<std::string> labels;
  for (const ModelRow& row : rows)
    if (row.scores[target].worse_than_line()) labels.push_back(row.label);
  return labels;
}

// As many as show the size of `typical` in four digits, three at least.
int decimals_for(double typical) {
  return typical > 0.0 ? std::max(3, 3 - static_cast<int>(std::floor(std::log10(typical)))) : 3;
}

// Errors beside each other.
class ErrorCells {
 public:
  // `factor`: from the unit of the errors to the one shown.
  ErrorCells(double typical, double factor) : factor_(factor), decimals_(decimals_for(typical)) {}
  [[nodiscard]] std::string operator()(const analysis::ErrorSum& error, int width) const {
    return number_cell(factor_ * error.mean(), decimals_, width) + number_cell(factor_ * error.max, decimals_, width);
  }

 private:
  double factor_;
  int decimals_;
};

// Of bins: the factors of their ends, and of the errors in them.
struct ShownBins {
  std::string title, unit;
  double ends = 1.0, errors = 1.0;
};

std::string bins_table(const ShownBins& shown, const std::vector<ModelRow>& rows, std::size_t target,
                       std::vector<analysis::Bin> analysis::Score::*bins) {
  if ((rows.front().scores[target].taxels.*bins).size() < 2) return {};
  std::string text =
      fmt::format("\n  {}, mean compensation error by model\n  {:>18}{:>10}", shown.title, shown.unit, "samples");
  for (const ModelRow& row : rows)
    text += fmt::format("{:>{}}", row.label, std::max<std::size_t>(12, row.label.size() + 2));
  text += "\n";
  const auto& first = rows.front().scores[target].taxels.*bins;
  const int decimals = std::min(decimals_for(shown.errors * rows.front().scores[target].taxels.raw.mean()), 7);
  for (std::size_t b = 0; b < first.size(); ++b) {
    text += fmt::format("  {:>18}{:>10}",
                        fmt::format("{:.4g} .. {:.4g}", shown.ends * first[b].low, shown.ends * first[b].high),
                        first[b].error.samples);
    for (const ModelRow& row : rows) {
      const auto& own = row.scores[target].taxels.*bins;
      text += number_cell(b < own.size() ? shown.errors * own[b].error.mean() : 0.0, decimals,
                          static_cast<int>(std::max<std::size_t>(12, row.label.size() + 2)));
    }
    text += "\n";
  }
  return text;
}

nlohmann::ordered_json error_json(const analysis::ErrorSum& error) {
  return {{"mean", error.mean()}, {"max", error.max}, {"samples", error.samples}};
}

nlohmann::ordered_json bins_json(const std::vector<analysis::Bin>& bins) {
  auto json = nlohmann::ordered_json::array();
  for (const analysis::Bin& bin : bins)
    json.push_back({{"low", bin.low}, {"high", bin.high}, {"compensated", error_json(bin.error)}});
  return json;
}

nlohmann::ordered_json score_json(const analysis::Score& score) {
  return {{"direct", error_json(score.direct)},           {"free_running", error_json(score.free_running)},
          {"compensated", error_json(score.compensated)}, {"raw", error_json(score.raw)},
          {"by_hold_s", bins_json(score.by_hold)},        {"by_rate", bins_json(score.by_rate)}};
}

}  // namespace

std::string left_out_text(const analysis::SensorModel& document) {
  constexpr std::size_t kNamed = 12;
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

std::string fits_table(const std::vector<ModelRow>& rows) {
  std::string text = fmt::format("{:<22}{:>6}{:>13}{:>10}{:>9}{:>11}{:>10}{:>8}\n", "model", "params", "J", "mean %FS",
                                 "max %FS", "cross %FS", "ops/smpl", "taxels");
  for (const ModelRow& row : rows) {
    const analysis::ModelFit& fit = shown(row.document).fit;
    const bool alone = row.document.taxels.size() == 1;
    const auto taxels = std::ranges::count_if(row.document.taxels, [&](const analysis::ModelTaxel& t) {
      return t.fit.model != nullptr && (alone || t.taxel != analysis::kMeanTaxel);
    });
    text +=
        fmt::format("{:<22}{:>6}{:>13.6g}{}{}{:>11}{:>10}{:>8}\n", row.label, fit.model->parameters().size(), fit.j,
                    percent_cell(fit.mean_error, fit.full_scale, 10), percent_cell(fit.max_error, fit.full_scale, 9),
                    row.crossed.samples > 0 ? percent_cell(row.crossed.mean(), fit.full_scale, 11) : "-",
                    fit.model->operations_per_sample(), taxels);
  }
  for (const ModelRow& row : rows) {
    text += undetermined_text(row.document) + left_out_text(row.document);
    if (row.document.model == "gpi")
      text += "gpi: found by a search, which may miss the least J; the others are exact\n";
  }
  return text;
}

std::string scores_table(const std::vector<ModelRow>& rows, const std::vector<ScoreTarget>& targets,
                         const std::string& unit_of_input, analysis::PressureUnit shown) {
  const bool pressure = unit_of_input == "psi";
  const std::string unit = pressure ? shown.symbol() : unit_of_input;
  const double factor = pressure ? shown.of(1.0) : 1.0;
  std::string text;
  for (std::size_t t = 0; t < targets.size(); ++t) {
    const bool array = rows.front().scores[t].count > 1;
    text += fmt::format("\nscored on {} ({}{})\n", targets[t].title,
                        analysis::counted(rows.front().scores[t].taxels.direct.samples, "sample"),
                        array ? fmt::format(", {} taxels", rows.front().scores[t].count) : std::string());
    text += fmt::format("{:<22}{:>42}\n", "", "direct model, % FS");
    text += fmt::format("{:<22}{:>21}{:>21}  {:>22}{}\n", "", "from measured turns", "free running",
                        unit == "input units" ? "input, compensated" : fmt::format("compensated, {}", unit),
                        array ? "      mean taxel" : "");
    text += fmt::format("{:<22}{:>11}{:>10}{:>11}{:>10}{:>12}{:>12}{}\n", "model", "mean", "max", "mean", "max", "mean",
                        "max", array ? fmt::format("{:>10}{:>10}", "mean", "max") : std::string());
    const analysis::ModelScore& any = rows.front().scores[t];
    const ErrorCells cells(factor * any.taxels.raw.mean(), factor);
    text += fmt::format("{:<22}{:>11}{:>10}{:>11}{:>10}{}{}\n", "none (straight line)", "-", "-", "-", "-",
                        cells(any.taxels.raw, 12), array ? cells(any.mean.raw, 10) : std::string());
    for (const ModelRow& row : rows) {
      const analysis::ModelScore& score = row.scores[t];
      const auto direct = [&](const analysis::ErrorSum& error) {
        return percent_cell(error.mean(), score.full_scale, 11) + percent_cell(error.max, score.full_scale, 10);
      };
      text +=
          fmt::format("{:<22}{}{}{}{}\n", row.label, direct(score.taxels.direct), direct(score.taxels.free_running),
                      cells(score.taxels.compensated, 12), array ? cells(score.mean.compensated, 10) : std::string());
    }
    if (const std::vector<std::string> worse = worse_than_line(rows, t); !worse.empty())
      text += fmt::format("worse than a straight line on what was held out: {}\n", fmt::join(worse, "; "));
    for (const std::string& line :
         analysis::outside_validity(rows.front().document, *targets[t].histories, targets[t].sequences, shown))
      text += fmt::format("outside the models' validity: {}\n", line);
    text += bins_table({"by hold time", "s", 1.0, factor}, rows, t, &analysis::Score::by_hold);
    text += bins_table({"by rate", unit + "/s", factor, factor}, rows, t, &analysis::Score::by_rate);
  }
  return text;
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
    parameters.push_back({{"name", p.name}, {"value", p.value}, {"unit", p.unit}, {"at_bound", p.at_bound()}});
  nlohmann::ordered_json taxel = {{"taxel", shown(row.document).taxel},
                                  {"j", fit.j},
                                  {"mean_error", fit.mean_error},
                                  {"max_error", fit.max_error},
                                  {"full_scale", fit.full_scale},
                                  {"samples", fit.samples},
                                  {"starts", fit.starts},
                                  {"undetermined", fit.undetermined},
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
