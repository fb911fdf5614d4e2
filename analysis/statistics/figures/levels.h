// The figures of each level of the external loop (Tables 6, 7) and their averages.
#pragma once

#include <cstddef>
#include <vector>

#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/figures/streams.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {

// Rows (levels or steps) of a rows x taxels table, the fitted taxels only.
class Fitted {
 public:
  explicit Fitted(const SensorModel& fit);
  [[nodiscard]] std::vector<double> row(const std::vector<double>& table, std::size_t row) const;
  // The whole row, taxels that are not fitted as NaN when `only_fitted`.
  [[nodiscard]] std::vector<double> frame(const std::vector<double>& table, std::size_t row, bool only_fitted) const;
  [[nodiscard]] const std::vector<std::size_t>& taxels() const { return taxels_; }
  [[nodiscard]] std::size_t width() const { return width_; }

 private:
  std::size_t width_;
  std::vector<std::size_t> taxels_;
};

// Fills in `levels` and what is averaged over them.
void gather_levels(Evaluation& evaluation, const CompensatedStreams& streams, const Fitted& fitted);

}  // namespace tactbench::analysis
