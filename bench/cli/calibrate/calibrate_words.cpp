#include "bench/cli/calibrate/calibrate_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/identify/stored/model_document.h"
#include "bench/cli/calibrate/large_word.h"
#include "bench/cli/judgement_words.h"
#include "bench/cli/models/fit_words.h"
#include "bench/cli/session.h"

namespace tactbench::bench {

using analysis::Verdict;

namespace {

// "taxels not modelled: 1 (tolerance limit 0)".
std::string figure_against_limit(const analysis::JudgedFigure& row, analysis::PressureUnit unit) {
  const auto figure = [&](double value) {
    return quantity_of(row.criterion) == analysis::Quantity::kCount ? fmt::format("{:g}", value)
                                                                    : figure_text(row.criterion, value, unit);
  };
  const std::string scope = row.scope.kind == analysis::Scope::Kind::kArray ? "" : " at " + in_words(row.scope, unit);
  return fmt::format("{}{}: {} (tolerance limit {})", in_words(row.criterion), scope, figure(row.value),
                     figure(row.limit));
}

std::string place(const BadTaxel& taxel) {
  return fmt::format("row {}, column {} ({})", taxel.row, taxel.column, taxel.why);
}

std::string bad_taxels_text(const std::vector<BadTaxel>& taxels) {
  constexpr std::size_t kNamed = 12;
  if (taxels.empty()) return "bad taxels: none\n";
  std::vector<std::string> places;
  for (std::size_t i = 0; i < std::min(kNamed, taxels.size()); ++i) places.push_back(place(taxels[i]));
  return fmt::format("bad taxels: {}{}\n", fmt::join(places, "; "),
                     taxels.size() > kNamed ? fmt::format("; and {} more, in the report", taxels.size() - kNamed) : "");
}

// Before each line of the large word.
std::string margin_of(const std::string& origin) { return origin == "simulated" ? "SIMULATED  " : "  "; }

std::string shown_overall(const CalibrationResult& result, analysis::PressureUnit unit) {
  const std::optional<Verdict> verdict = result.judgement.overall;
  return verdict ? shown_verdict(*verdict, result.origin) + condition_in_words(result.judgement, unit)
                 : std::string("no verdict");
}

}  // namespace

std::vector<BadTaxel> bad_taxels(const JudgedFit& fit, const analysis::Judgement& judgement,
                                 analysis::PressureUnit unit) {
  std::vector<BadTaxel> bad;
  for (const LeftOut& taxel : left_out_of(fit.model)) bad.push_back({taxel.row, taxel.column, taxel.status});
  const bool worst_is_bad = std::ranges::any_of(judgement.figures, [](const analysis::JudgedFigure& row) {
    return row.criterion == analysis::Criterion::kWorstTaxelError &&
           (row.verdict == Verdict::kFail || row.verdict == Verdict::kConditionalFail);
  });
  const analysis::Evaluation& judged = fit.evaluations.back().evaluation;
  if (worst_is_bad && judged.worst_taxel >= 0)
    bad.push_back({judged.worst_taxel / fit.model.columns, judged.worst_taxel % fit.model.columns,
                   fmt::format("mean |error| {}, the largest", unit.text(judged.worst_taxel_mean_error_psi, 2))});
  return bad;
}

std::string reason_text(const analysis::Judgement& judgement, const std::string& limits, std::int64_t held_out,
                        analysis::PressureUnit unit) {
  constexpr std::size_t kNamed = 2;
  if (judgement.not_judged) return "not judged: " + in_words(*judgement.not_judged, unit);
  const std::optional<Verdict> overall = judgement.overall;
  if (!analysis::states_conformity(overall))
    return fmt::format("limits '{}' only list figures: they state no verdict", limits);
  if (overall == Verdict::kPass)
    return fmt::format("all {} requirements of '{}' pass on held-out run {}", judgement.figures.size(), limits,
                       held_out);
  std::vector<std::string> decided;
  for (const analysis::JudgedFigure& row : judgement.figures)
    if (row.verdict == *overall) decided.push_back(figure_against_limit(row, unit));
  if (decided.empty()) return fmt::format("an earlier verdict on these models is {}", to_string(*overall));
  const std::size_t more = decided.size() - std::min(kNamed, decided.size());
  decided.resize(std::min(kNamed, decided.size()));
  const char* const within = overall == Verdict::kConditionalPass   ? ", within the uncertainty below the limit"
                             : overall == Verdict::kConditionalFail ? ", within the uncertainty above the limit"
                                                                    : "";
  return fmt::format("{}{}{}, on held-out run {}", fmt::join(decided, "; "),
                     more > 0 ? fmt::format("; and {} more", more) : "", within, held_out);
}

std::string large_verdict(const analysis::Judgement& judgement) {
  if (!analysis::states_conformity(judgement.overall)) return {};
  const ExitCode code = exit_code_of(judgement.overall);
  return code == ExitCode::kPass ? "PASS" : code == ExitCode::kCriterionFailed ? "FAIL" : "INCONCLUSIVE";
}

std::string fit_line(const CalibrationResult& result) {
  const analysis::SensorModel& model = result.fit.model;
  const analysis::Evaluation& judged = result.fit.evaluations.back().evaluation;
  return fmt::format(
      "{} on run {}: {} of {} fitted; on run {} mean |error| {}, worst taxel {}", analysis::label_of(model), model.run,
      model.fitted().size(), analysis::counted(model.array().size(), "taxel"), judged.run,
      result.unit.text(judged.mean_error_psi, 3), result.unit.text(judged.worst_taxel_mean_error_psi, 2));
}

std::string verdict_page(const CalibrationResult& result) {
  const std::string word = large_verdict(result.judgement);
  std::string text = word.empty() ? std::string("\n") : "\n" + large_word(word, margin_of(result.origin)) + "\n";
  text +=
      fmt::format("sensor {}: {}: {}\n", one_line(result.sensor), shown_overall(result, result.unit),
                  one_line(reason_text(result.judgement, result.limits, result.held_out, result.unit), kLongestText));
  text += conditions_text(result.judgement);
  text += bad_taxels_text(bad_taxels(result.fit, result.judgement, result.unit));
  for (const analysis::Remark& remark : result.judgement.remarks)
    text += fmt::format("note: {}\n", in_words(remark, result.unit));
  return text;
}

nlohmann::ordered_json calibration_json(const CalibrationResult& result) {
  const std::optional<Verdict> verdict = result.judgement.overall;
  auto bad = nlohmann::ordered_json::array(), evaluations = nlohmann::ordered_json::array();
  for (const BadTaxel& taxel : bad_taxels(result.fit, result.judgement))
    bad.push_back({{"row", taxel.row}, {"column", taxel.column}, {"why", taxel.why}});
  for (const NamedEvaluation& named : result.fit.evaluations) evaluations.push_back(evaluation_json(named));
  return {{"sensor", result.sensor},
          {"registered", result.registered},
          {"origin", result.origin},
          {"run", result.run},
          {"held_out", result.held_out},
          {"model", analysis::label_of(result.fit.model)},
          {"limits", result.limits},
          {"verdict", analysis::verdict_word(verdict)},
          {"shown", verdict ? shown_verdict(*verdict, result.origin) : std::string("no verdict")},
          {"statement", shown_overall(result, analysis::PressureUnit::kPsi)},
          {"reason", reason_text(result.judgement, result.limits, result.held_out)},
          {"bad_taxels", bad},
          {"evaluations", evaluations},
          {"verdicts", verdicts_json(result.judgement.figures, result.origin)},
          {"judgement", judgement_json(result.judgement, result.origin)},
          {"report", {{"number", result.report_number}, {"path", result.report_path}}}};
}

}  // namespace tactbench::bench
