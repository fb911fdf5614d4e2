#include "analysis/statistics/sensor/seating_lines.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {

namespace {

struct Line {
  double mean_v = 0.0;  // response
  double loaded_v = 0.0;
  double level = 0.0;  // against what is expected of it: the last seating, or the median line
  bool dead = false;
  bool judged = true;
};

class Axis {
 public:
  Axis(const SeatingTaxels& taxels, bool along_rows, const SeatingOptions& options)
      : taxels_(taxels), along_rows_(along_rows), options_(options) {
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
      line.level = now_sum / std::max(before_sum, options.least_response_v);
      if (line.judged && line.mean_v >= options.least_array_v) answers.push_back(line.mean_v);
    }
    usual_v_ = answers.empty() ? 0.0 : quantile_of(answers, 0.75);
    const double bound = options.dead_line_share * usual_v_;
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
    const double share = compares() ? options_.edge_share : options_.edge_share_alone;
    const double reach_share = compares() ? options_.edge_reach_share : options_.edge_reach_share_alone;
    constexpr double kUneven = 0.05;  // a step back that noise and re-mounting may cause
    const int most = static_cast<int>(lines_.size()) / 2;
    if (most < 2 || at(from_edge(0)).level >= share) return 0;
    int reach = 0;
    bool graded = false;
    while (reach < most && at(from_edge(reach)).level < reach_share) {
      if (reach > 0 && at(from_edge(reach)).level < at(from_edge(reach - 1)).level - kUneven) break;
      graded = graded || at(from_edge(reach)).mean_v >= options_.edge_least_share * usual_v_;
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
    if (*high - *low < options_.least_array_v) return fmt::format("at {:.2f} V", *low);
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
  const SeatingOptions& options_;
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

std::vector<SeatingFinding> check_lines(const SeatingTaxels& taxels, bool along_rows, const SeatingOptions& options,
                                        std::vector<bool>& lost) {
  return Axis(taxels, along_rows, options).findings(lost);
}

}  // namespace tactbench::analysis
