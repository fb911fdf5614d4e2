#include "analysis/statistics/sensor/seating.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "analysis/counted.h"
#include "analysis/pressure_unit.h"
#include "analysis/statistics/numbers/moments.h"

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
                     SeatingResult& result) {
  constexpr std::ptrdiff_t kFewestTaxels = 16;  // by chance alone, fewer taxels resemble each other
  const std::vector<bool> use_now = answering(now, kSeating.least_response_v);
  const std::vector<bool> use_before = answering(before, kSeating.least_response_v);
  if (std::count(use_now.begin(), use_now.end(), true) < kFewestTaxels) return true;
  if (relative_spread(before, use_before) < kSeating.least_spread) return true;
  const auto fits = compare_positions(rows, columns, now, before, use_now, use_before);
  const double identity = fits.front().correlation;
  result.correlation = identity;
  const auto best = std::max_element(fits.begin() + 1, fits.end(),
                                     [](const auto& a, const auto& b) { return a.correlation < b.correlation; });
  if (best->correlation >= kSeating.turn_correlation && best->correlation > identity + kSeating.turn_margin) {
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
  if (identity >= kSeating.correlation_warning) return true;
  const bool fail = identity < kSeating.correlation_fail;
  result.findings.push_back({"deviation",
                             fail ? "fail" : "warning",
                             {},
                             {},
                             fmt::format("the pattern of responses resembles the last seating's with a correlation of "
                                         "{:.2f} only{}",
                                         identity, fail ? ": another sensor, or a different mount" : "")});
  return identity >= kSeating.lines_correlation;
}

void compare_mean(const std::vector<double>& now, const std::vector<double>& before, const std::vector<bool>& leave_out,
                  SeatingResult& result) {
  double sum_now = 0.0, sum_before = 0.0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (leave_out[i]) continue;
    sum_now += now[i];
    sum_before += before[i];
  }
  if (!(sum_before > 0.0)) return;
  result.mean_ratio = sum_now / sum_before;
  const double off = std::abs(*result.mean_ratio - 1.0);
  if (off <= kSeating.mean_warning) return;
  result.findings.push_back(
      {"deviation",
       off > kSeating.mean_fail ? "fail" : "warning",
       {},
       {},
       fmt::format("the mean response is {:.0f} % of the last seating's", 100.0 * *result.mean_ratio)});
}

void count_dead(int columns, const std::vector<double>& now, const SeatingTaxels& taxels, const std::vector<bool>& lost,
                SeatingResult& result) {
  SeatingFinding finding{"dead-taxels", "warning", {}, {}, ""};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (lost[i] || std::abs(now[i]) >= kSeating.least_response_v) continue;
    result.dead_taxels.push_back(static_cast<int>(i));
    if (taxels.known_dead[i]) continue;
    finding.rows.push_back(static_cast<int>(i) / columns);
    finding.columns.push_back(static_cast<int>(i) % columns);
    names.push_back(fmt::format("({}, {})", finding.rows.back(), finding.columns.back()));
  }
  if (static_cast<double>(names.size()) <= kSeating.dead_taxels_share * static_cast<double>(now.size())) return;
  finding.text = fmt::format("{}: (row, column) {}",
                             counted(names.size(), "single taxel does not answer", "single taxels do not answer"),
                             fmt::join(names, " "));
  result.findings.push_back(std::move(finding));
}

}  // namespace

SeatingResult check_seating(int rows, int columns, const SeatingFrames& now, const std::optional<SeatingFrames>& last) {
  const auto taxels = static_cast<std::size_t>(std::max(0, rows)) * static_cast<std::size_t>(std::max(0, columns));
  if (taxels == 0) throw std::invalid_argument("check_seating: no taxels");
  const std::vector<double> response = response_of(now, taxels);
  const std::vector<double> before = last ? response_of(*last, taxels) : std::vector<double>();
  SeatingResult result;
  result.mean_response_v = mean_of(response);
  if (quantile_of(response, 0.9) < kSeating.least_array_v) {
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
  find_open_lines(parts, kSeating.least_response_v);
  if (last) {
    const std::vector<bool> answered = answering(before, kSeating.least_response_v);
    for (std::size_t i = 0; i < taxels; ++i) parts.known_dead[i] = !answered[i];
    if (compare_pattern(rows, columns, response, before, result)) parts.before_v = before;
  }
  std::vector<bool> lost(taxels, false);
  for (const bool along_rows : {true, false}) {
    for (SeatingFinding& finding : check_lines(parts, along_rows, lost)) {
      result.findings.push_back(std::move(finding));
    }
  }
  if (last && std::abs(last->pressure_psi - now.pressure_psi) <= kSeating.same_pressure_psi) {
    compare_mean(response, before, lost, result);
  }
  count_dead(columns, response, parts, lost, result);
  for (const SeatingFinding& finding : result.findings) {
    if (finding.verdict == "fail" || result.verdict == "pass") result.verdict = finding.verdict;
  }
  return result;
}

namespace {

// Transposed first, then rows and columns turned round: all eight symmetries of the square. Said from the sensor's
// side: what was done to it since the last seating.
struct Position {
  bool transposed, rows_reversed, columns_reversed;
  const char* name;
};
constexpr std::array<Position, 8> kPositions = {
    {{false, false, false, "as before"},
     {false, true, true, "turned by 180 degrees"},
     {false, true, false, "mirrored, first row with last"},
     {false, false, true, "mirrored, first column with last"},
     {true, false, true, "turned clockwise by 90 degrees"},
     {true, true, false, "turned counter-clockwise by 90 degrees"},
     {true, false, false, "mirrored, rows with columns"},
     {true, true, true, "mirrored, rows with columns from the far corner"}}};

}  // namespace

std::vector<SeatingPosition> compare_positions(int rows, int columns, std::span<const double> now,
                                               std::span<const double> before, const std::vector<bool>& use_now,
                                               const std::vector<bool>& use_before) {
  std::vector<SeatingPosition> fits;
  for (const Position& position : kPositions) {
    if (position.transposed && rows != columns) continue;
    std::vector<double> is_now, was_before;
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {  // a taxel of the last seating, and where it would lie now
        int row = position.transposed ? c : r;
        int column = position.transposed ? r : c;
        if (position.rows_reversed) row = rows - 1 - row;
        if (position.columns_reversed) column = columns - 1 - column;
        const auto was = static_cast<std::size_t>(r * columns + c);
        const auto is = static_cast<std::size_t>(row * columns + column);
        if (!use_now[is] || !use_before[was]) continue;
        is_now.push_back(now[is]);
        was_before.push_back(before[was]);
      }
    }
    fits.push_back({position.name, is_now.size() < 3 ? 0.0 : line_fit(is_now, was_before).correlation()});
  }
  return fits;
}

namespace {

struct Line {
  double mean_v = 0.0;  // response
  double loaded_v = 0.0;
  double level = 0.0;  // against what is expected of it: the last seating, or the median line
  bool dead = false;
  bool judged = true;
};

class LineSearch {
 public:
  LineSearch(const SeatingTaxels& taxels, bool along_rows) : taxels_(taxels), along_rows_(along_rows) {
    const int count = along_rows ? taxels.rows : taxels.columns;
    std::vector<double> answers;
    for (int i = 0; i < count; ++i) {
      double now_sum = 0.0, before_sum = 0.0, loaded_sum = 0.0, used = 0.0;
      for (const std::size_t taxel : members(i)) {
        if (taxels.known_dead[taxel] || crossed(static_cast<int>(taxel))) continue;
        used += 1.0;
        now_sum += taxels.response_v[taxel];
        loaded_sum += taxels.loaded_v[taxel];
        before_sum += compares() ? taxels.before_v[taxel] : 1.0;
      }
      Line& line = lines_.emplace_back();
      // Too few are left where the lines across are open: they say nothing of this line.
      line.judged = 4.0 * used >= static_cast<double>(members(i).size());
      line.mean_v = now_sum / std::max(used, 1.0);
      line.loaded_v = loaded_sum / std::max(used, 1.0);
      line.level = now_sum / std::max(before_sum, kSeating.least_response_v);
      if (line.judged && line.mean_v >= kSeating.least_array_v) answers.push_back(line.mean_v);
    }
    usual_v_ = answers.empty() ? 0.0 : quantile_of(answers, 0.75);
    const double bound = kSeating.dead_line_share * usual_v_;
    std::vector<double> living;
    for (Line& line : lines_) {
      line.dead = line.judged && line.mean_v < bound;
      if (line.judged && !line.dead) living.push_back(line.level);
    }
    const double usual = living.empty() ? 1.0 : quantile_of(living, 0.5);
    for (Line& line : lines_) line.level = line.judged ? line.level / usual : 1.0;
  }

  std::vector<SeatingFinding> findings(std::vector<bool>& lost) {
    std::vector<SeatingFinding> found;
    const int count = static_cast<int>(lines_.size());
    std::vector<bool> named(lines_.size(), false);
    for (const bool last : {false, true}) {
      const auto from_edge = [&](int k) { return last ? count - 1 - k : k; };
      const int reach = fall_off(from_edge);
      int block = reach;
      while (reach == 0 && block < count && at(from_edge(block)).dead) ++block;
      if (reach == 0 && block < 2) continue;
      std::vector<int> which;
      for (int k = 0; k < block; ++k) which.push_back(from_edge(k));
      std::sort(which.begin(), which.end());
      for (const int i : which) named[static_cast<std::size_t>(i)] = true;
      found.push_back(reach > 0 ? edge(which, last) : connector(which, last));
    }
    std::vector<int> dead;
    for (int i = 0; i < count; ++i) {
      if (at(i).dead && !named[static_cast<std::size_t>(i)]) dead.push_back(i);
    }
    if (!dead.empty()) found.push_back(dead_lines(dead));
    for (int i = 0; i < count; ++i) {
      if (!at(i).dead && !named[static_cast<std::size_t>(i)]) continue;
      for (const std::size_t taxel : members(i)) lost[taxel] = true;
    }
    return found;
  }

 private:
  [[nodiscard]] bool crossed(int taxel) const {
    const int across = along_rows_ ? taxel % taxels_.columns : taxel / taxels_.columns;
    return (along_rows_ ? taxels_.open_columns : taxels_.open_rows)[static_cast<std::size_t>(across)];
  }
  [[nodiscard]] bool compares() const { return !taxels_.before_v.empty(); }
  Line& at(int i) { return lines_[static_cast<std::size_t>(i)]; }

  [[nodiscard]] std::vector<std::size_t> members(int line) const {
    std::vector<std::size_t> found;
    const int count = along_rows_ ? taxels_.columns : taxels_.rows;
    for (int i = 0; i < count; ++i) {
      const int taxel = along_rows_ ? line * taxels_.columns + i : i * taxels_.columns + line;
      found.push_back(static_cast<std::size_t>(taxel));
    }
    return found;
  }

  // Lines from an edge that rise toward the others; 0 where none answers at all: that is no membrane.
  template <typename FromEdge>
  int fall_off(const FromEdge& from_edge) {
    const double share = compares() ? kSeating.edge_share : kSeating.edge_share_alone;
    const double reach_share = compares() ? kSeating.edge_reach_share : kSeating.edge_reach_share_alone;
    constexpr double kUneven = 0.05;  // a step back that noise and re-mounting may cause
    const int most = static_cast<int>(lines_.size()) / 2;
    if (most < 2 || at(from_edge(0)).level >= share) return 0;
    int reach = 0;
    bool graded = false;
    while (reach < most && at(from_edge(reach)).level < reach_share) {
      if (reach > 0 && at(from_edge(reach)).level < at(from_edge(reach - 1)).level - kUneven) break;
      graded = graded || at(from_edge(reach)).mean_v >= kSeating.edge_least_share * usual_v_;
      ++reach;
    }
    return graded ? reach : 0;
  }

  [[nodiscard]] std::string name(const std::vector<int>& which) const {
    const char* word = along_rows_ ? "row" : "column";
    if (which.size() == 1) return fmt::format("{} {}", word, which.front());
    const bool run = which.back() - which.front() + 1 == static_cast<int>(which.size()) && which.size() > 2;
    return run ? fmt::format("{}s {} to {}", word, which.front(), which.back())
               : fmt::format("{}s {}", word, fmt::join(which, ", "));
  }

  [[nodiscard]] std::string side(bool last) const {
    return fmt::format("{} {}", last ? "last" : "first", along_rows_ ? "row" : "column");
  }

  SeatingFinding finding(const char* kind, const std::vector<int>& which, std::string text) {
    return {kind, "fail", along_rows_ ? which : std::vector<int>{}, along_rows_ ? std::vector<int>{} : which,
            std::move(text)};
  }

  // "at 0.00 V": whether a line is open or stands at the converter's limit tells people where to look.
  std::string stands_at(const std::vector<int>& which) {
    std::vector<double> volts;
    for (const int i : which) volts.push_back(at(i).loaded_v);
    const auto [low, high] = std::minmax_element(volts.begin(), volts.end());
    if (*high - *low < kSeating.least_array_v) return fmt::format("at {:.2f} V", *low);
    return fmt::format("between {:.2f} and {:.2f} V", *low, *high);
  }

  SeatingFinding edge(const std::vector<int>& which, bool last) {
    std::vector<std::string> shares;
    for (const int i : which) shares.push_back(fmt::format("{:.0f}", 100.0 * at(i).level));
    return finding("edge-outside", which,
                   fmt::format("the response falls off toward the {}: {} at {} % of what the others suggest, so that "
                               "edge seems to lie outside the membrane",
                               side(last), name(which), fmt::join(shares, ", ")));
  }

  SeatingFinding connector(const std::vector<int>& which, bool last) {
    return finding("half-inserted", which,
                   fmt::format("{} do not answer, standing {}: the connector of the {}s seems half inserted, open at "
                               "the side of the {}",
                               name(which), stands_at(which), along_rows_ ? "row" : "column", side(last)));
  }

  SeatingFinding dead_lines(const std::vector<int>& which) {
    return finding(along_rows_ ? "dead-rows" : "dead-columns", which,
                   fmt::format("{} {} not answer, standing {}: a broken line or contact", name(which),
                               which.size() == 1 ? "does" : "do", stands_at(which)));
  }

  const SeatingTaxels& taxels_;
  bool along_rows_;
  std::vector<Line> lines_;
  double usual_v_ = 0.0;  // of lines that answer
};

}  // namespace

void find_open_lines(SeatingTaxels& taxels, double least_v) {
  constexpr int kOf = 10;  // all but a tenth of the line's taxels are silent
  std::vector<int> in_row(static_cast<std::size_t>(taxels.rows), 0);
  std::vector<int> in_column(static_cast<std::size_t>(taxels.columns), 0);
  for (std::size_t i = 0; i < taxels.response_v.size(); ++i) {
    if (std::abs(taxels.response_v[i]) >= least_v) continue;
    ++in_row[i / in_column.size()];
    ++in_column[i % in_column.size()];
  }
  for (const int silent : in_row) taxels.open_rows.push_back(kOf * silent >= (kOf - 1) * taxels.columns);
  for (const int silent : in_column) taxels.open_columns.push_back(kOf * silent >= (kOf - 1) * taxels.rows);
}

std::vector<SeatingFinding> check_lines(const SeatingTaxels& taxels, bool along_rows, std::vector<bool>& lost) {
  return LineSearch(taxels, along_rows).findings(lost);
}

}  // namespace tactbench::analysis
