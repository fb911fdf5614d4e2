#include "bench/cli/calibrate/calibrate_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/json_fields.h"
#include "bench/cli/judgement_words.h"
#include "bench/cli/models/fit_words.h"
#include "bench/cli/session.h"

namespace tactbench::bench {

namespace doc = analysis::doc;
using analysis::Verdict;

namespace {

std::string place(const BadTaxel& taxel) {
  return fmt::format("row {}, column {} ({})", taxel.row, taxel.column, taxel.why);
}

std::string bad_taxels_text(const std::vector<BadTaxel>& taxels) {
  constexpr std::size_t kNamed = 12;
  if (taxels.empty()) return "none";
  std::vector<std::string> places;
  for (std::size_t i = 0; i < std::min(kNamed, taxels.size()); ++i) places.push_back(place(taxels[i]));
  return fmt::format("{}{}", fmt::join(places, "; "),
                     taxels.size() > kNamed ? fmt::format("; and {} more, in the report", taxels.size() - kNamed) : "");
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

std::string fit_line(const CalibrationResult& result) {
  const analysis::SensorModel& model = result.fit.model;
  const analysis::Evaluation& judged = result.fit.evaluations.back().evaluation;
  return fmt::format(
      "{} on run {}: {} of {} fitted; on run {} mean |error| {}, worst taxel {}", analysis::label_of(model), model.run,
      model.fitted().size(), analysis::counted(model.array().size(), "taxel"), judged.run,
      result.unit.text(judged.mean_error_psi, 2), result.unit.text(judged.worst_taxel_mean_error_psi, 2));
}

doc::Document verdict_document(const CalibrationResult& result, const Session& session) {
  doc::Document out;
  out.add(judgement_document(result.judgement, result.origin, result.unit, session.all));
  if (session.quiet) out.blocks.resize(1);
  out.add(doc::Paragraph{
      {fmt::format("sensor {}, limits '{}', bad taxels: {}", one_line(result.sensor), one_line(result.limits),
                   bad_taxels_text(bad_taxels(result.fit, result.judgement, result.unit)))}});
  if (!result.drift.empty()) out.add(doc::Paragraph{{"drifted since its models before: ", result.drift}});
  return out;
}

nlohmann::ordered_json calibration_json(const CalibrationResult& result) {
  const std::optional<Verdict> verdict = result.judgement.overall;
  auto bad = nlohmann::ordered_json::array(), evaluations = nlohmann::ordered_json::array();
  for (const BadTaxel& taxel : bad_taxels(result.fit, result.judgement))
    bad.push_back({JSON_FIELDS(taxel, row, column, why)});
  for (const NamedEvaluation& named : result.fit.evaluations) evaluations.push_back(evaluation_json(named));
  return {JSON_FIELDS(result, sensor, registered, origin, run, held_out),
          {"model", analysis::label_of(result.fit.model)},
          {"limits", result.limits},
          {"verdict", analysis::verdict_word(verdict)},
          {"shown", verdict ? shown_verdict(*verdict, result.origin) : std::string("no verdict")},
          {"statement", headline(result.judgement, result.origin, analysis::PressureUnit::kPsi)},
          {"bad_taxels", bad},
          {"drift", result.drift.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(result.drift)},
          {"evaluations", evaluations},
          {"verdicts", verdicts_json(result.judgement.figures, result.origin)},
          {"judgement", judgement_json(result.judgement, result.origin)},
          {"report", {{"number", result.report_number}, {"path", result.report_path}}}};
}

}  // namespace tactbench::bench
