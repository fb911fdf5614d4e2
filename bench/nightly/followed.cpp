#include "bench/nightly/followed.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

namespace tactbench::bench {
namespace {

void judge_figure(FollowedFigure& figure, double false_alarm, std::int64_t newest,
                  const std::map<std::int64_t, std::int64_t>& repeated) {
  std::vector<double> accepted, later;
  for (std::size_t i = 0; i < figure.values.size(); ++i) {
    if (figure.accepted[i] && repeated.contains(figure.runs[i])) continue;
    (figure.accepted[i] ? accepted : later).push_back(figure.values[i]);
  }
  figure.band = analysis::control_band(accepted, false_alarm);
  figure.missing = figure.runs.back() != newest;
  figure.outside =
      figure.band && (figure.missing || (!figure.accepted.back() && !figure.band->holds(figure.values.back())));
  if (later.size() < kDriftRuns) return;
  const std::size_t count = std::min<std::size_t>(later.size(), 2 * kDriftRuns);
  figure.trend = analysis::monotone_trend(std::span(later).last(count));
  if (!figure.trend) return;
  const double spread = figure.band ? figure.band->deviation : 0.0;
  const double rounding = 1e-9 * std::abs(later.back());
  figure.drifts =
      figure.trend->probability < kDriftChance && std::abs(figure.trend->moved) > std::max(spread, rounding);
}

}  // namespace

Followed follow(const db::RunStore& store, const std::string& subject, std::size_t judged_together) {
  Followed followed;
  followed.subject = subject;
  for (const db::BaselineRecord& baseline : store.baselines())
    if (baseline.subject == subject) followed.baseline = baseline;
  std::map<std::string, FollowedFigure> figures;
  const std::vector<db::FigureRecord> records = store.figures(subject);
  if (!records.empty()) {
    followed.run = records.back().run;
    followed.origin = records.back().origin;
  }
  for (const db::FigureRecord& record : records) {
    if (record.origin != followed.origin || !std::isfinite(record.value)) continue;
    FollowedFigure& figure = figures[record.name];
    figure.name = record.name;
    figure.runs.push_back(record.run);
    figure.values.push_back(record.value);
    figure.accepted.push_back(followed.baseline && std::ranges::binary_search(followed.baseline->runs, record.run));
  }
  std::map<std::int64_t, std::int64_t> repeated;
  if (followed.baseline) repeated = store.repeated_runs(subject, followed.baseline->runs);
  followed.repeated = repeated.size();
  if (judged_together == 0) judged_together = std::max<std::size_t>(figures.size(), 1);
  for (auto& [name, figure] : figures) {
    judge_figure(figure, kNightAlarm / static_cast<double>(judged_together), followed.run, repeated);
    followed.figures.push_back(std::move(figure));
  }
  return followed;
}

std::vector<std::string> outside_lines(const Followed& followed) {
  std::vector<std::string> lines;
  for (const FollowedFigure& figure : followed.figures) {
    if (!figure.outside) continue;
    if (figure.missing) {
      lines.push_back(fmt::format("{} is missing from run {}; the baseline has it ({}, accepted by {})", figure.name,
                                  followed.run, followed.baseline->reason, followed.baseline->accepted_by));
      continue;
    }
    lines.push_back(fmt::format(
        "{} is {:.6g}, outside {:.6g} to {:.6g} of the baseline (mean {:.6g}, spread {:.2g} of {} runs; {}, accepted "
        "by {})",
        figure.name, figure.values.back(), figure.band->low, figure.band->high, figure.band->mean,
        figure.band->deviation, figure.band->values, followed.baseline->reason, followed.baseline->accepted_by));
  }
  return lines;
}

std::vector<std::string> drift_lines(const Followed& followed) {
  std::vector<std::string> lines;
  for (const FollowedFigure& figure : followed.figures) {
    if (!figure.drifts) continue;
    lines.push_back(fmt::format(
        "{} drifts: {:+.3g} per run, {:+.3g} in all, by chance with p = {:.1g}{}", figure.name, figure.trend->slope,
        figure.trend->moved, figure.trend->probability,
        figure.band ? fmt::format("; the baseline's spread is {:.2g}", figure.band->deviation) : std::string()));
  }
  return lines;
}

std::string sparkline(const std::vector<double>& values, std::size_t width) {
  static constexpr const char* kBlocks[] = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  const std::span<const double> shown = std::span(values).last(std::min(width, values.size()));
  double low = INFINITY, high = -INFINITY;
  for (const double value : shown) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  std::string line;
  for (const double value : shown) {
    if (!std::isfinite(value)) {
      line += "·";
      continue;
    }
    const double share = high > low ? (value - low) / (high - low) : 0.5;
    line += kBlocks[std::clamp(static_cast<int>(share * 8.0), 0, 7)];
  }
  return line;
}

}  // namespace tactbench::bench
