#include "bench/nightly/subject_trend.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "analysis/report/overview/overview.h"
#include "analysis/statistics/control/control_chart.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::bench {
namespace {

constexpr double kLeastOutlier = 0.1;  // of the median of the sensors

// Each simulated run that repeats the seeds of an earlier one, and the newest of those. Runs on instruments have none.
std::map<std::int64_t, std::int64_t> runs_with_same_seeds(const std::vector<db::FigureRecord>& records) {
  std::map<std::int64_t, std::int64_t> same;
  std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> newest;
  for (const db::FigureRecord& record : records) {
    if (record.origin != "simulated" || !std::isfinite(record.value)) continue;
    const auto [earlier, first] = newest.try_emplace({record.seed, record.sensor_seed}, record.run);
    if (first || earlier->second == record.run) continue;
    same[record.run] = earlier->second;
    earlier->second = record.run;
  }
  return same;
}

void chart(TrendFigure& figure, const SubjectTrend& followed, const std::map<std::int64_t, std::int64_t>& repeated,
           const std::map<std::int64_t, std::int64_t>& same_seeds) {
  const std::int64_t last = followed.baseline ? followed.baseline->runs.back() : 0;
  std::vector<double> start_up, later;
  for (std::size_t i = 0; i < figure.values.size(); ++i) {
    const std::int64_t run = figure.runs[i];
    if (figure.accepted[i] && !repeated.contains(run)) start_up.push_back(figure.values[i]);
    if (run > last && !same_seeds.contains(run)) later.push_back(figure.values[i]);
  }
  figure.chart = analysis::control_chart(figure.name, start_up, later);
  if (followed.same_seeds != 0) figure.chart.ewma.reset();
  figure.missing = figure.runs.back() != followed.run;
  const std::optional<analysis::ControlBand>& band = figure.chart.band;
  figure.compared = band && (figure.missing || !figure.accepted.back());
  figure.outside = figure.compared && (figure.missing || !band->holds(figure.values.back()));
}

}  // namespace

TrendReader::TrendReader(const db::Models& store, const std::string& subject)
    : subject_(subject),
      baseline_(store.last_baseline(subject)),
      records_(store.figures(subject)),
      same_seeds_(runs_with_same_seeds(records_)) {
  if (baseline_) repeated_ = store.repeated_runs(subject, baseline_->runs);
}

std::map<std::string, double> TrendReader::figures_of(std::int64_t run) const {
  std::map<std::string, double> figures;
  for (const db::FigureRecord& record : std::ranges::equal_range(records_, run, {}, &db::FigureRecord::run))
    figures[record.name] = record.value;
  return figures;
}

SubjectTrend TrendReader::up_to(std::int64_t run) const {
  SubjectTrend followed;
  followed.subject = subject_;
  followed.baseline = baseline_;
  const std::span known(records_.begin(), std::ranges::upper_bound(records_, run, {}, &db::FigureRecord::run));
  std::map<std::string, TrendFigure> figures;
  if (!known.empty()) {
    followed.run = known.back().run;
    followed.origin = known.back().origin;
  }
  for (const db::FigureRecord& record : known) {
    if (record.origin != followed.origin || !std::isfinite(record.value)) continue;
    TrendFigure& figure = figures[record.name];
    figure.name = record.name;
    figure.runs.push_back(record.run);
    figure.values.push_back(record.value);
    figure.accepted.push_back(baseline_ && std::ranges::binary_search(baseline_->runs, record.run));
  }
  if (baseline_) {
    followed.repeated = repeated_.size();
    followed.counted = baseline_->runs.size() - repeated_.size();
  }
  const auto own = same_seeds_.find(followed.run);
  if (followed.origin == "simulated" && own != same_seeds_.end()) followed.same_seeds = own->second;
  for (auto& [name, figure] : figures) {
    chart(figure, followed, repeated_, same_seeds_);
    followed.figures.push_back(std::move(figure));
  }
  return followed;
}

SubjectTrend follow(const db::Models& store, const std::string& subject) {
  return TrendReader(store, subject).up_to(std::numeric_limits<std::int64_t>::max());
}

void judge_shifts(const std::vector<SubjectTrend*>& family) {
  std::vector<TrendFigure*> charted;
  std::vector<double> probabilities;
  for (SubjectTrend* const followed : family)
    for (TrendFigure& figure : followed->figures) {
      figure.shifted = false;
      if (!figure.chart.ewma || figure.missing) continue;
      charted.push_back(&figure);
      probabilities.push_back(figure.chart.probability);
    }
  const std::vector<bool> reported = analysis::discoveries(probabilities);
  for (std::size_t i = 0; i < charted.size(); ++i) charted[i]->shifted = reported[i];
}

SubjectTrend trend_of_subject(const db::Models& store, const std::string& subject) {
  SubjectTrend followed = follow(store, subject);
  judge_shifts({&followed});
  return followed;
}

std::vector<std::string> outside_band_lines(const SubjectTrend& followed) {
  std::vector<std::string> lines;
  for (const TrendFigure& figure : followed.figures) {
    if (!figure.outside) continue;
    const std::string accepted =
        fmt::format("{}, accepted by {}", followed.baseline->reason, followed.baseline->accepted_by);
    const analysis::ControlBand& band = *figure.chart.band;
    if (figure.missing)
      lines.push_back(
          fmt::format("{} is missing from run {}; the baseline has it ({})", figure.name, followed.run, accepted));
    else if (figure.chart.constant)
      lines.push_back(fmt::format("{} is {:.6g}, and was {:.6g} in each of {} runs of the baseline ({})", figure.name,
                                  figure.values.back(), band.mean, band.values, accepted));
    else
      lines.push_back(fmt::format(
          "{} is {:.6g}, outside {:.6g} to {:.6g} of the baseline (mean {:.6g}, spread {:.2g} of {} runs; "
          "{})",
          figure.name, figure.values.back(), band.low, band.high, band.mean, band.deviation, band.values, accepted));
  }
  return lines;
}

std::vector<std::string> shift_lines(const SubjectTrend& followed) {
  std::vector<std::string> lines;
  for (const TrendFigure& figure : followed.figures) {
    if (!figure.shifted) continue;
    const analysis::EwmaState& ewma = *figure.chart.ewma;
    lines.push_back(fmt::format(
        "{} shifted: its moving average is {:.6g}, {:+.2g} of the baseline's deviations from its mean {:.6g} ({} "
        "runs), by chance with p = {:.1g} in {} runs{}",
        figure.name, figure.chart.level, ewma.ewma, figure.chart.band->mean, ewma.start_up, figure.chart.probability,
        analysis::kControlRuns, figure.chart.slope ? fmt::format("; {:+.3g} per run", *figure.chart.slope) : ""));
  }
  return lines;
}

std::string short_baseline(const SubjectTrend& followed) {
  if (!followed.baseline || followed.counted >= analysis::kMinStartUpRuns) return {};
  if (followed.counted < 3) return "fewer than three measurements: it is not used to judge";
  return fmt::format("fewer than {} measurements: it shows only gross changes; accept a longer one",
                     analysis::kMinStartUpRuns);
}

double TrendFigure::former() const { return values.size() > 1 ? values[values.size() - 2] : analysis::kNan; }

void mark_outliers(std::vector<SubjectTrend>& sensors) {
  std::map<std::pair<std::string, std::string>, std::vector<TrendFigure*>> same_figure;
  for (SubjectTrend& followed : sensors) {
    constexpr std::string_view kOfSensor = "sensor/";
    if (!followed.subject.starts_with(kOfSensor)) continue;
    const std::size_t end = followed.subject.find('/', kOfSensor.size());
    for (TrendFigure& figure : followed.figures)
      same_figure[{followed.subject.substr(std::min(end, followed.subject.size())), figure.name}].push_back(&figure);
  }
  for (const auto& [key, figures] : same_figure) {
    std::vector<double> newest;
    for (const TrendFigure* figure : figures) newest.push_back(figure->values.back());
    const std::vector<double> scores = analysis::modified_z_scores(newest);
    const double median = analysis::median_of(newest);
    for (std::size_t i = 0; i < figures.size(); ++i)
      figures[i]->outlier = std::abs(scores[i]) > analysis::kOutlierScore &&
                            std::abs(newest[i] - median) > kLeastOutlier * std::abs(median);
  }
}

FigureLabel display_text(const std::string& figure) {
  static const std::map<std::string, std::string, std::less<>> kUnits = {
      {"psi", "psi"}, {"kpa", "kPa"}, {"bar", "bar"}, {"mv", "mV"},   {"v", "V"},      {"um", "µm"},
      {"mm", "mm"},   {"n", "N"},     {"s", "s"},     {"min", "min"}, {"percent", "%"}};
  std::vector<std::string> words(1);
  for (const char c : figure) c == '_' ? void(words.emplace_back()) : void(words.back() += c);
  FigureLabel out;
  const auto take_unit = [&] {
    const auto unit = words.empty() ? kUnits.end() : kUnits.find(words.back());
    if (unit == kUnits.end()) return std::string();
    words.pop_back();
    return unit->second;
  };
  if (words.size() > 2 && words.back() == "fs" && words[words.size() - 2] == "percent") {
    words.resize(words.size() - 2);
    out.unit = "% FS";
  } else {
    out.unit = take_unit();
    if (!out.unit.empty() && !words.empty() && words.back() == "per") {
      words.pop_back();
      const std::string above = take_unit();
      out.unit = (above.empty() ? "1" : above) + "/" + out.unit;
    }
  }
  out.name = fmt::format("{}", fmt::join(words, " "));
  return out.name.empty() ? FigureLabel{figure, {}} : out;
}

FigureScale scale_of(const TrendFigure& figure) {
  if (const auto& band = figure.chart.band) {
    double width = band->high - band->low;
    if (figure.chart.constant) width = std::max(0.1 * std::abs(band->mean), 1.0);
    return {band->low - width, band->high + width};
  }
  FigureScale scale{0.0, 0.0};
  for (const double value : figure.values) {
    scale.low = std::min(scale.low, value);
    scale.high = std::max(scale.high, value);
  }
  return scale.high > scale.low ? scale : FigureScale{};
}

std::string sparkline(const std::vector<double>& values, const FigureScale& scale, std::size_t width) {
  static constexpr const char* kBlocks[] = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  std::string line;
  for (const double value : std::span(values).last(std::min(width, values.size()))) {
    const double share = (value - scale.low) / (scale.high - scale.low);
    if (!std::isfinite(share))
      line += "·";
    else if (share < 0.0 || share > 1.0)
      line += share < 0.0 ? "↓" : "↑";
    else
      line += kBlocks[std::min(static_cast<int>(share * 8.0), 7)];
  }
  return line;
}

namespace {

constexpr const char* kPsiWord = "psi";

// Position of psi as a separate word in a name; npos: none.
std::size_t place_of_psi(const std::string& name) {
  for (std::size_t at = name.find(kPsiWord); at != std::string::npos; at = name.find(kPsiWord, at + 1)) {
    const std::size_t end = at + 3;
    if ((at == 0 || name[at - 1] == '_') && (end == name.size() || name[end] == '_')) return at;
  }
  return std::string::npos;
}

void scale(TrendFigure& figure, double factor) {
  for (double& value : figure.values) value *= factor;
  analysis::ControlChart& chart = figure.chart;
  if (chart.band) {
    for (double* value : {&chart.band->mean, &chart.band->low, &chart.band->high}) *value *= factor;
    if (!chart.logarithmic) chart.band->deviation *= factor;
  }
  chart.level *= factor;
  if (chart.slope) *chart.slope *= factor;
}

}  // namespace

SubjectTrend in_unit(SubjectTrend followed, analysis::PressureUnit unit) {
  if (unit == analysis::PressureUnit::kPsi) return followed;
  std::string symbol = unit.symbol();
  for (char& letter : symbol) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  for (TrendFigure& figure : followed.figures) {
    const std::size_t at = place_of_psi(figure.name);
    if (at == std::string::npos) continue;
    const bool per = at >= 4 && figure.name.compare(at - 4, 4, "per_") == 0;
    scale(figure, per ? unit.per(1.0) : unit.of(1.0));
    figure.name.replace(at, 3, symbol);
  }
  return followed;
}

}  // namespace tactbench::bench
