#include "analysis/statistics/uncertainty/untraced.h"

#include <fmt/format.h>

namespace tactbench::analysis {

std::string in_words(const Untraced& untraced, PressureUnit unit) {
  if (!untraced.overdue_since.empty()) return "reference overdue since " + untraced.overdue_since;
  const auto at = [&](double psi) { return unit.short_text(psi); };
  const std::string covering = untraced.corrected
                                   ? fmt::format("correction (readings of {})",
                                                 unit.short_span(untraced.first_reading_psi, untraced.last_reading_psi))
                                   : std::string("certificate");
  return fmt::format("levels {}{}{} are not traceable: the run goes from {}, the reference's {} covers {}",
                     untraced.below ? "below " + at(untraced.low_psi) : "",
                     untraced.below && untraced.above ? " and " : "",
                     untraced.above ? "above " + at(untraced.high_psi) : "",
                     unit.short_span(untraced.run_low_psi, untraced.run_high_psi), covering,
                     unit.short_span(untraced.low_psi, untraced.high_psi));
}

}  // namespace tactbench::analysis
