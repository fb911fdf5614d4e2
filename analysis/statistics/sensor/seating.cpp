#include "analysis/statistics/sensor/seating.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/counted.h"
#include "analysis/pressure_unit.h"
#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/sensor/seating_lines.h"

namespace tactbench::analysis {

namespace {

std::vector<double> response_of(const SeatingFrames& frames, std::size_t taxels) {
  if (frames.unloaded_v.size() != taxels || frames.loaded_v.size() != taxels) {
    throw std::invalid_argument("check_seating: a frame does not fit rows x columns");
  }
  std::vector<double> response(taxels);
  for (std::size_t i = 0; i < taxels; ++i) response[i] = frames.loaded_v[i] - frames.unloaded_v[i];
  return response;
}

std::vector<bool> answering(const std::vector<double>& response, double least_v) {
  std::vector<bool> found;
  for (const double volts : response) found.push_back(std::abs(volts) >= least_v);
  return found;
}

double relative_spread(const std::vector<double>& values, const std::vector<bool>& use) {
  double n = 0.0, sum = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!use[i]) continue;
    n += 1.0;
    sum += values[i];
    squares += values[i] * values[i];
  }
  if (n < 2.0 || !(sum > 0.0)) return 0.0;
  return std::sqrt(std::max(0.0, squares / n - sum * sum / (n * n))) / (sum / n);
}

// Turn, mirror, another pattern. False where the last seating's taxels may not be compared one by one.
bool compare_pattern(int rows, int columns, const std::vector<double>& now, const std::vector<double>& before,
                     const SeatingOptions& options, SeatingResult& result) {
  constexpr std::ptrdiff_t kFewestTaxels = 16;  // by chance alone, fewer taxels resemble each other
  const std::vector<bool> use_now = answering(now, options.least_response_v);
  const std::vector<bool> use_before = answering(before, options.least_response_v);
  if (std::count(use_now.begin(), use_now.end(), true) < kFewestTaxels) return true;
  if (relative_spread(before, use_before) < options.least_spread) return true;
  const auto fits = compare_positions(rows, columns, now, before, use_now, use_before);
  const double identity = fits.front().correlation;
  result.correlation = identity;
  const auto best = std::max_element(fits.begin() + 1, fits.end(),
                                     [](const auto& a, const auto& b) { return a.correlation < b.correlation; });
  if (best->correlation >= options.turn_correlation && best->correlation > identity + options.turn_margin) {
    result.findings.push_back(
        {"turned",
         "fail",
         {},
         {},
         fmt::format("the sensor seems {} since its last seating: so its pattern fits with a correlation of {:.2f}, as "
                     "it is with {:.2f}",
                     best->name, best->correlation, identity)});
    return false;
  }
  if (identity >= options.correlation_warning) return true;
  const bool fail = identity < options.correlation_fail;
  result.findings.push_back({"deviation",
                             fail ? "fail" : "warning",
                             {},
                             {},
                             fmt::format("the pattern of responses resembles the last seating's with a correlation of "
                                         "{:.2f} only{}",
                                         identity, fail ? ": another sensor, or a different mount" : "")});
  return identity >= options.lines_correlation;
}

void compare_mean(const std::vector<double>& now, const std::vector<double>& before, const std::vector<bool>& leave_out,
                  const SeatingOptions& options, SeatingResult& result) {
  double sum_now = 0.0, sum_before = 0.0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (leave_out[i]) continue;
    sum_now += now[i];
    sum_before += before[i];
  }
  if (!(sum_before > 0.0)) return;
  result.mean_ratio = sum_now / sum_before;
  const double off = std::abs(*result.mean_ratio - 1.0);
  if (off <= options.mean_warning) return;
  result.findings.push_back(
      {"deviation",
       off > options.mean_fail ? "fail" : "warning",
       {},
       {},
       fmt::format("the mean response is {:.0f} % of the last seating's", 100.0 * *result.mean_ratio)});
}

void count_dead(int columns, const std::vector<double>& now, const SeatingTaxels& taxels, const std::vector<bool>& lost,
                const SeatingOptions& options, SeatingResult& result) {
  SeatingFinding finding{"dead-taxels", "warning", {}, {}, ""};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (lost[i] || std::abs(now[i]) >= options.least_response_v) continue;
    result.dead_taxels.push_back(static_cast<int>(i));
    if (taxels.known_dead[i]) continue;
    finding.rows.push_back(static_cast<int>(i) / columns);
    finding.columns.push_back(static_cast<int>(i) % columns);
    names.push_back(fmt::format("({}, {})", finding.rows.back(), finding.columns.back()));
  }
  if (static_cast<double>(names.size()) <= options.dead_taxels_share * static_cast<double>(now.size())) return;
  finding.text = fmt::format("{}: (row, column) {}",
                             counted(names.size(), "single taxel does not answer", "single taxels do not answer"),
                             fmt::join(names, " "));
  result.findings.push_back(std::move(finding));
}

}  // namespace

SeatingResult check_seating(int rows, int columns, const SeatingFrames& now, const std::optional<SeatingFrames>& last,
                            const SeatingOptions& options) {
  const auto taxels = static_cast<std::size_t>(std::max(0, rows)) * static_cast<std::size_t>(std::max(0, columns));
  if (taxels == 0) throw std::invalid_argument("check_seating: no taxels");
  const std::vector<double> response = response_of(now, taxels);
  const std::vector<double> before = last ? response_of(*last, taxels) : std::vector<double>();
  SeatingResult result;
  result.mean_response_v = mean_of(response);
  if (quantile_of(response, 0.9) < options.least_array_v) {
    result.verdict = "fail";
    result.findings = {{"no-response",
                        "fail",
                        {},
                        {},
                        fmt::format("the array does not answer to {}: {:.3f} V on average",
                                    both_units(now.pressure_psi, 1), result.mean_response_v)}};
    return result;
  }
  SeatingTaxels parts{rows, columns, response, now.loaded_v, {}, std::vector<bool>(taxels, false), {}, {}};
  find_open_lines(parts, options.least_response_v);
  if (last) {
    const std::vector<bool> answered = answering(before, options.least_response_v);
    for (std::size_t i = 0; i < taxels; ++i) parts.known_dead[i] = !answered[i];
    if (compare_pattern(rows, columns, response, before, options, result)) parts.before_v = before;
  }
  std::vector<bool> lost(taxels, false);
  for (const bool along_rows : {true, false}) {
    for (SeatingFinding& finding : check_lines(parts, along_rows, options, lost)) {
      result.findings.push_back(std::move(finding));
    }
  }
  if (last && std::abs(last->pressure_psi - now.pressure_psi) <= options.same_pressure_psi) {
    compare_mean(response, before, lost, options, result);
  }
  count_dead(columns, response, parts, lost, options, result);
  for (const SeatingFinding& finding : result.findings) {
    if (finding.verdict == "fail" || result.verdict == "pass") result.verdict = finding.verdict;
  }
  return result;
}

}  // namespace tactbench::analysis
