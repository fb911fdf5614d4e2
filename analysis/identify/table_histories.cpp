// Series of a table -> histories: turns by the inputs' own noise, the outputs' noise, and what is doubtful about both.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "analysis/counted.h"
#include "analysis/error.h"
#include "analysis/identify/histories.h"
#include "analysis/statistics/numbers/difference_noise.h"

namespace tactbench::analysis {
namespace {

constexpr double kTurnInNoises = 7.0;     // of the inputs: one pair in three million lies as far apart
constexpr double kTurnShare = 0.001;      // of the inputs' span: no turn is less
constexpr double kWidestTurn = 0.25;      // of the span: inputs with more noise than that are taken to jump
constexpr double kDoubtful = 0.02;        // of the span: turns of the input and dead bands above it are told
constexpr double kNearEnd = 0.01;         // of the span: an input as near to its end lies there
constexpr std::size_t kNoiseInputs = 50;  // fewer do not tell their noise
constexpr double kRepeated = 0.5;         // of neighbouring outputs are equal where a converter counts in wide steps
constexpr int kFewInner = 3;              // inner branches of one direction
constexpr std::size_t kNamed = 3;         // sequences that a warning names

// Of the inputs of one taxel, the noisiest of its histories.
double input_noise_of(const std::vector<History>& histories) {
  double noise = 0.0;
  for (const History& history : histories)
    if (history.x.size() >= kNoiseInputs)
      noise = std::max(noise, difference_noise(std::vector<Stretch>{{{}, history.x}}));
  return noise;
}

bool is_fitted(const History& history, const HistoriesOptions& options) {
  return options.fitted.empty() || std::ranges::find(options.fitted, history.name) != options.fitted.end();
}

// The least step between neighbours where so many of them are equal that the outputs are counts; else 0.
double resolution_of(const std::vector<Stretch>& stretches) {
  std::size_t pairs = 0, equal = 0;
  double least = HUGE_VAL;
  for (const Stretch& stretch : stretches) {
    for (std::size_t i = 1; i < stretch.y.size(); ++i) {
      const double step = std::abs(stretch.y[i] - stretch.y[i - 1]);
      ++pairs;
      if (step == 0.0)
        ++equal;
      else
        least = std::min(least, step);
    }
  }
  if (equal == pairs) return 0.0;
  return static_cast<double>(equal) / static_cast<double>(pairs) > kRepeated ? least : 0.0;
}

// Within the branches that are fitted. Where outputs are counts differences may show no noise: rounding alone has
// 1 / sqrt(12) of a count.
double output_noise_of(const std::vector<History>& histories, const HistoriesOptions& options) {
  std::vector<Stretch> stretches;
  for (const History& history : histories) {
    if (!is_fitted(history, options)) continue;
    for (const Branch& branch : history.branches) {
      const auto first = static_cast<std::size_t>(branch.first);
      const std::size_t count = static_cast<std::size_t>(branch.last) - first + 1;
      stretches.push_back({std::span(history.x).subspan(first, count), std::span(history.y).subspan(first, count)});
    }
  }
  return std::max(difference_noise(stretches), resolution_of(stretches) / std::sqrt(12.0));
}

std::string listed(const std::vector<std::string>& names) {
  const auto shown = static_cast<std::ptrdiff_t>(std::min(names.size(), kNamed));
  return fmt::format("\"{}\"{}", fmt::join(names.begin(), names.begin() + shown, "\", \""),
                     names.size() > kNamed ? fmt::format(" and {} more", names.size() - kNamed) : "");
}

// What one taxel's data leave in doubt. Taxels of a table mostly share their inputs, so the first usable one speaks for
// all but the noise.
class Doubts {
 public:
  // Throws AnalysisError TB-MODEL-SEQUENCE when a sequence to fit is not there.
  Doubts(const TaxelHistories& taxel, const HistoriesOptions& options)
      : taxel_(&taxel), fitted_(named(taxel.fit, options.fitted)), x_(span_of(taxel.fit, &History::x)) {}

  void tell(std::vector<std::string>& warnings) const {
    tell_start(warnings);
    tell_inner(warnings);
    tell_loop(warnings);
  }

 private:
  [[nodiscard]] double near() const { return std::max(kNearEnd * x_.length(), taxel_->turn); }

  void tell_start(std::vector<std::string>& warnings) const {
    std::vector<std::string> names;
    double first = 0.0;
    for (const History& history : taxel_->fit) {
      const double x = history.x.front();
      if (x - x_.low <= near() || x_.high - x <= near()) continue;
      if (names.empty()) first = x;
      names.push_back(history.name);
    }
    if (names.empty()) return;
    warnings.push_back(
        fmt::format("{} of {} in mid-range ({}; the first at {:g}, {:.0f} % of the span): what was before is not "
                    "known; "
                    "models take such a history as one rise from the lowest input, or as one fall from the highest "
                    "where it begins to fall",
                    names.size(),
                    names.size() == 1 ? counted(taxel_->fit.size(), "sequence") + " starts"
                                      : counted(taxel_->fit.size(), "sequence") + " start",
                    listed(names), first, 100.0 * (first - x_.low) / x_.length()));
  }

  void tell_inner(std::vector<std::string>& warnings) const {
    int falling = 0, rising = 0;
    for (const History& history : fitted_) {
      for (std::size_t b = 1; b < history.branches.size(); ++b) {
        const double x = history.x[static_cast<std::size_t>(history.branches[b].first)];
        if (x - x_.low > near() && x_.high - x > near()) ++(history.branches[b].ascending ? rising : falling);
      }
    }
    if (falling >= kFewInner && rising >= kFewInner) return;
    warnings.push_back(
        fmt::format("few reversals inside the range: {} begin there and fall, {} rise, {} each are needed; what models "
                    "predict of inner loops rests on these",
                    counted(falling, "branch", "branches"), rising, kFewInner));
  }

  void tell_loop(std::vector<std::string>& warnings) const {
    std::vector<TaxelTable> sequences;
    for (const History& history : fitted_) sequences.push_back({history.x, history.y, history.branches});
    try {
      const ExternalLoop loop = external_loop(sequences, 1, taxel_->turn);
      if (loop.left_out > 0.0)
        warnings.push_back(fmt::format(
            "no sweep reaches both extremes of the inputs: the external loop is taken from {:g} to {:g}, and "
            "{:g} % of the samples may lie beyond each end",
            loop.pressure_psi.front(), loop.pressure_psi.back(), 100.0 * loop.left_out));
    } catch (const AnalysisError& error) {
      warnings.push_back(
          fmt::format("no external loop: {}; elam and poly are not fitted, and the full scale is what the "
                      "outputs span from the lowest input to the highest",
                      error.what()));
    }
  }

  const TaxelHistories* taxel_;
  std::vector<History> fitted_;
  Span x_;
};

// Of all taxels that can be fitted, the one with the widest dead band.
void tell_band(const Histories& histories, std::vector<std::string>& warnings) {
  double widest = 0.0, noise = 0.0;
  int many = 0, taxel = 0;
  for (const TaxelHistories& own : histories.taxels) {
    if (!own.usable()) continue;
    const double share = kBandInNoises * own.noise / span_of(own.fit, &History::y).length();
    if (share > kDoubtful) ++many;
    if (share <= widest) continue;
    widest = share;
    noise = own.noise;
    taxel = own.taxel;
  }
  if (many == 0) return;
  warnings.push_back(fmt::format(
      "the dead band of compensation is {:.3g} % of the outputs' span (six times a noise of {:.3g}{}): lesser "
      "reversals "
      "of the output are not seen; state the noise with --noise if that is too much",
      100.0 * widest, noise,
      histories.taxels.size() > 1 ? fmt::format(", taxel {}, {} above {:g} %", taxel, many, 100.0 * kDoubtful)
                                  : std::string()));
}

// Sets `turn` of a taxel.
void find_turn(TaxelHistories& taxel, const std::vector<History>& fitted, const Span& x,
               const HistoriesOptions& options, std::vector<std::string>& warnings) {
  taxel.turn = options.turn;
  if (options.turn >= 0.0) return;
  taxel.turn = kTurnShare * x.length();
  const double wanted = kTurnInNoises * input_noise_of(fitted);
  if (wanted <= kWidestTurn * x.length()) taxel.turn = std::max(taxel.turn, wanted);
  if (!warnings.empty() || wanted <= kDoubtful * x.length()) return;
  const std::string noisy =
      fmt::format("(seven noises are {:.3g}, {:.0f} % of their span)", wanted, 100.0 * wanted / x.length());
  warnings.push_back(
      wanted > taxel.turn
          ? fmt::format(
                "the inputs jump {}: turns are counted from {:.3g} on, 0.1 % of the span; --turn states another size",
                noisy, taxel.turn)
          : fmt::format("the inputs are noisy {}: lesser turns are not seen; --turn states another size", noisy));
}

std::vector<History> fitted_of(const std::vector<History>& histories, const HistoriesOptions& options) {
  std::vector<History> fitted;
  for (const History& history : histories)
    if (is_fitted(history, options)) fitted.push_back(history);
  return fitted.empty() ? histories : fitted;
}

// Of a history that is scored alone, whose inputs may be noisier; nothing that is fitted depends on it.
double own_turn(const History& history, double turn) {
  const double wanted = kTurnInNoises * input_noise_of({history});
  return wanted <= kWidestTurn * span_of({history}, &History::x).length() ? std::max(turn, wanted) : turn;
}

// Sets `turn` of a taxel and the branches of its histories.
void find_turns(TaxelHistories& taxel, const HistoriesOptions& options, std::vector<std::string>& warnings) {
  const std::vector<History> fitted = fitted_of(taxel.fit, options);
  const Span x = span_of(fitted, &History::x);
  find_turn(taxel, fitted, x, options, warnings);
  for (History& history : taxel.fit) {
    const bool own = options.turn < 0.0 && !is_fitted(history, options);
    history.branches = branches_along(history.x, own ? own_turn(history, taxel.turn) : taxel.turn);
  }
}

}  // namespace

Histories histories_of(const std::vector<TableSeries>& series, const std::string& source,
                       const HistoriesOptions& options) {
  Histories histories;
  histories.source = source;
  histories.origin = "imported";
  std::map<int, TaxelHistories> taxels;
  for (const TableSeries& own : series) {
    if (own.input.size() < 4)
      throw AnalysisError("TB-TABLE-SHORT",
                          fmt::format("{}: sequence {} of taxel {} has {}", source, own.sequence, own.taxel,
                                      counted(own.input.size(), "sample")),
                          "a history of at least 4 samples is needed to see a loop");
    if (std::ranges::find(histories.sequences, own.sequence) == histories.sequences.end())
      histories.sequences.push_back(own.sequence);
    TaxelHistories& taxel = taxels[own.taxel];
    taxel.taxel = own.taxel;
    taxel.fit.push_back({own.sequence, own.input, own.output, {}, {}, {}});
  }
  for (auto& [number, taxel] : taxels) {
    const Span x = span_of(taxel.fit, &History::x), y = span_of(taxel.fit, &History::y);
    if (x.length() <= 0.0)
      throw AnalysisError("TB-TABLE-CONSTANT",
                          fmt::format("{}: the input of taxel {} is {} in all rows", source, number, x.low),
                          "a history needs inputs that rise and fall; --map input=COL names another column");
    if (options.turn >= x.length())
      throw AnalysisError("TB-TABLE-TURN",
                          fmt::format("{}: --turn {:g} is not less than what the inputs of taxel {} span, {:g} to {:g}",
                                      source, options.turn, number, x.low, x.high),
                          "state in input units by how much an input goes back when it turns, noise apart");
    find_turns(taxel, options, histories.warnings);
    if (y.length() <= 0.0) taxel.status = TaxelStatus::kConstant;
    taxel.noise = options.noise < 0.0 ? output_noise_of(taxel.fit, options) : options.noise;
    taxel.score = taxel.fit;
    histories.taxels.push_back(std::move(taxel));
  }
  histories.rows = static_cast<int>(histories.taxels.size());
  const auto first = std::ranges::find_if(histories.taxels, [](const auto& t) { return t.usable(); });
  if (first != histories.taxels.end()) Doubts(*first, options).tell(histories.warnings);
  tell_band(histories, histories.warnings);
  finish(histories);
  return histories;
}

}  // namespace tactbench::analysis
