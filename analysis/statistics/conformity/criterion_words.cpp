#include "analysis/statistics/conformity/criterion_words.h"

#include <algorithm>
#include <array>
#include <utility>

namespace tactbench::analysis {

namespace {

constexpr std::array<std::pair<const char*, const char*>, 6> kCriteria = {{
    {"mean_compensation_error", "mean absolute error"},
    {"worst_taxel_error", "worst taxel's mean error"},
    {"distance_of_mean", "hysteresis of the mean"},
    {"unfit_taxels", "taxels not modelled"},
    {"mismatch", "non-uniformity"},
    {"mpe", "maximum permissible error"},
}};

std::string with_branch_in_words(std::string scope) {
  for (const auto& [stored, words] : {std::pair{" up", " increasing"}, std::pair{" down", " decreasing"}})
    if (scope.ends_with(stored)) return scope.replace(scope.rfind(' '), std::string::npos, words);
  return scope;
}

}  // namespace

std::string criterion_in_words(const std::string& criterion) {
  for (const auto& [key, words] : kCriteria)
    if (criterion == key) return words;
  std::string words = criterion;
  std::ranges::replace(words, '_', ' ');
  return words;
}

std::string scope_in_words(const std::string& scope, PressureUnit unit) {
  return with_branch_in_words(unit.in_text(scope));
}

std::string scope_in_both_units(const std::string& scope, PressureUnit unit) {
  return with_branch_in_words(unit.both_in_text(scope));
}

}  // namespace tactbench::analysis
