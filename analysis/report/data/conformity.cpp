#include "analysis/report/data/conformity.h"

#include <algorithm>
#include <cmath>

namespace tactbench::analysis {

namespace {

const HeldOut* held_out_of(const ReportInput& input, std::int64_t run) {
  const auto found = std::ranges::find(input.held_out, run, [](const HeldOut& own) { return own.evaluation.run; });
  return found == input.held_out.end() ? nullptr : &*found;
}

}  // namespace

std::string title_of_judged(const ReportInput& input, std::int64_t run) {
  if (run == input.run.run) {
    const bool others = std::ranges::any_of(input.judgement.figures, [&](const JudgedFigure& own) {
      return own.run == run && own.model_run != 0 && own.model_run != run;
    });
    return others ? "this run" : "own run (calibration data)";
  }
  const HeldOut* const held_out = held_out_of(input, run);
  return held_out == nullptr ? "a run that is not part of this report" : held_out->title;
}

const Evaluation* evaluation_of(const ReportInput& input, std::int64_t run) {
  if (run == input.run.run) return &input.evaluation;
  const HeldOut* const held_out = held_out_of(input, run);
  return held_out == nullptr ? nullptr : &held_out->evaluation;
}

doc::Phrase figure_phrase(Criterion criterion, double value, double expanded) {
  if (!std::isfinite(value)) return "not measured";
  const bool known = expanded > 0.0;  // a NaN is not
  switch (quantity_of(criterion)) {
    case Quantity::kPressure:
      return known ? doc::pressure_with_u(value, expanded) : doc::pressure(value, 2);
    case Quantity::kShareOfFullScale:
      return {known ? doc::number_with_u(100.0 * value, 100.0 * expanded) : doc::percent_of(value, 2), " % FS"};
    case Quantity::kCount:
      break;
  }
  return {doc::number(value, 0), value == 1.0 ? " taxel" : " taxels"};
}

std::string requirement_name(const JudgedFigure& figure, PressureUnit unit) {
  const bool array = figure.scope.kind == Scope::Kind::kArray;
  return display_text(figure.criterion) + (array ? "" : ", " + display_text(figure.scope, unit));
}

std::vector<DecisionRule> rules_of(const Judgement& judgement) {
  std::vector<DecisionRule> rules;
  for (const JudgedFigure& figure : judgement.figures)
    if (std::ranges::find(rules, figure.rule) == rules.end()) rules.push_back(figure.rule);
  return rules;
}

}  // namespace tactbench::analysis
