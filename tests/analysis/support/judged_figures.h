// Makes figures with verdicts, and judgements, from given values.
#pragma once

#include <utility>
#include <vector>

#include "analysis/judgement/judgement.h"

namespace tactbench::analysis::by_hand {

inline JudgedFigure judged_figure(std::int64_t run, Criterion criterion, double value, double limit, Verdict verdict,
                                  const Scope& scope = {}, std::int64_t model_run = 0) {
  JudgedFigure figure;
  figure.run = run;
  figure.criterion = criterion;
  figure.value = value;
  figure.limit = limit;
  figure.verdict = verdict;
  figure.scope = scope;
  figure.model_run = model_run;
  figure.limits_sha256 = std::string(64, 'e');
  return figure;
}

inline Judgement judgement_of(std::vector<JudgedFigure> figures) {
  Judgement judgement;
  judgement.figures = std::move(figures);
  judgement.limits_sha256 = std::string(64, 'e');
  conclude(judgement);
  return judgement;
}

}  // namespace tactbench::analysis::by_hand
