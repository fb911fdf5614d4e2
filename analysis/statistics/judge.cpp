#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/statistics/evaluation.h"
#include "analysis/statistics/levels.h"

namespace tactbench::analysis {
namespace {

// The simple rule (ILAC-G8): equality passes. What cannot be compared is not a pass.
const char* verdict_of(double value, double limit) {
  if (std::isnan(value) || std::isnan(limit)) return "inconclusive";
  return value <= limit ? "pass" : "fail";
}

}  // namespace

std::vector<db::VerdictRecord> judge(const Evaluation& evaluation, const ArrayFit& fit, const Limits& limits) {
  std::vector<db::VerdictRecord> verdicts;
  const auto add = [&](const std::string& criterion, const std::string& scope, double value, double limit,
                       const std::string& unit) {
    db::VerdictRecord record;
    record.run = evaluation.run;
    record.criterion = criterion;
    record.scope = scope;
    record.value = value;
    record.limit = limit;
    record.unit = unit;
    record.rule = "simple";
    record.verdict = verdict_of(value, limit);
    record.limits_toml = limits.toml;
    record.limits_sha256 = limits.sha256;
    verdicts.push_back(std::move(record));
  };
  const bool any = evaluation.frames > 0 && evaluation.worst_taxel >= 0;
  add("mean_compensation_error", "array", any ? evaluation.mean_error_psi : kNan, limits.mean_compensation_error_psi,
      "psi");
  add("worst_taxel_error", "array", any ? evaluation.worst_taxel_mean_error_psi : kNan, limits.worst_taxel_error_psi,
      "psi");
  add("distance_of_mean", "array", evaluation.levels.empty() ? kNan : evaluation.comp_distance_of_mean,
      limits.distance_of_mean_fs, "FS");
  const auto unfit =
      std::ranges::count_if(fit.taxels, [](const TaxelFit& taxel) { return taxel.status != TaxelStatus::kFitted; });
  add("unfit_taxels", "array", static_cast<double>(unfit), limits.unfit_taxels, "taxels");
  for (const Limits::Mismatch& mismatch : limits.mismatch) {
    const auto level = std::ranges::find_if(evaluation.levels, [&](const LevelFigures& figures) {
      return std::abs(figures.pressure_psi - mismatch.pressure_psi) < 1e-6;
    });
    const bool measured = level != evaluation.levels.end();
    const std::string scope = fmt::format("{:g} psi", mismatch.pressure_psi);
    add("mismatch", scope + " up", measured ? level->comp_std_up : kNan, mismatch.std_fs, "FS");
    add("mismatch", scope + " down", measured ? level->comp_std_down : kNan, mismatch.std_fs, "FS");
  }
  return verdicts;
}

}  // namespace tactbench::analysis
