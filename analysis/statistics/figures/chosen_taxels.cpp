#include "analysis/statistics/figures/chosen_taxels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/identify/histories.h"

namespace tactbench::analysis {

ChosenTaxels choose_taxels(const Evaluation& evaluation) {
  const std::vector<double>& errors = evaluation.taxel_mean_error_psi;
  std::vector<int> order;
  for (std::size_t i = 0; i < errors.size(); ++i)
    if (std::isfinite(errors[i])) order.push_back(static_cast<int>(i));
  if (order.empty()) return {};
  std::ranges::stable_sort(order, {}, [&](int taxel) { return errors[static_cast<std::size_t>(taxel)]; });
  return {order.front(), order[(order.size() - 1) / 2], order.back()};
}

std::vector<NamedTaxel> named_taxels(const ChosenTaxels& chosen, int columns) {
  std::vector<NamedTaxel> out{{kMeanTaxel, "mean taxel"}};
  const auto add = [&](const char* word, int taxel) {
    if (taxel < 0 || std::ranges::find(out, taxel, &NamedTaxel::taxel) != out.end()) return;
    out.push_back({taxel, fmt::format("{} taxel, row {}, column {}", word, taxel / columns, taxel % columns)});
  };
  add("best", chosen.best);
  add("median", chosen.median);
  add("worst", chosen.worst);
  return out;
}

}  // namespace tactbench::analysis
