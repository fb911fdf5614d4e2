// Series of a table -> histories: turns by the inputs' own noise, the outputs' noise, and what is doubtful about both.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "analysis/counted.h"
#include "analysis/error.h"
#include "analysis/identify/histories.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

constexpr double kTurnInNoises = 7.0;        // of the inputs: one pair in three million lies as far apart
constexpr double kTurnShare = 0.001;         // of the inputs' span: no turn is less
constexpr double kWidestTurn = 0.25;         // of the span: inputs with more noise than that are taken to jump
constexpr double kDoubtful = 0.02;           // of the span: turns of the input and dead bands above it are told
constexpr double kNearEnd = 0.01;            // of the span: an input as near to its end lies there
constexpr std::size_t kNoiseInputs = 50;     // fewer do not tell their noise
constexpr std::size_t kRestingSamples = 50;  // fewer do not tell the outputs' noise
constexpr double kSlip = 0.03;               // of the inputs' span: turns that go back by less may be none
constexpr double kWanders = 0.03;            // of the outputs' span: an end that moves by more is told
constexpr double kVisits = 0.005;            // of the inputs' span: an input as near to its end is a visit to it
constexpr double kDips = 0.05;     // of the outputs' span: an output that falls where it should rise by more is told
constexpr double kSeen = 6.0;      // noises: what is less is not told
constexpr int kFewInner = 3;       // inner branches of one direction
constexpr std::size_t kNamed = 3;  // sequences that a warning names

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

std::span<const double> part(const std::vector<double>& values, const Branch& branch) {
  const auto first = static_cast<std::size_t>(branch.first);
  return std::span(values).subspan(first, static_cast<std::size_t>(branch.last) - first + 1);
}

// The last decimal place in which any of them is written; 0: none within double precision.
double last_place(const std::vector<double>& outputs) {
  constexpr double kExact = 1e-6, kMost = 1e12;
  double scale = 1.0;
  for (std::size_t i = 0; i < outputs.size();) {
    const double scaled = std::abs(outputs[i] * scale);
    if (scaled > kMost) return 0.0;
    if (std::abs(scaled - std::round(scaled)) <= kExact)
      ++i;
    else
      scale *= 10.0;
  }
  return 1.0 / scale;
}

// Of one count, where outputs are counts: the median gap between values that occur, of which the gaps are multiples.
// Else, and where the gaps are few, of the last decimal place. 0 where it is so wide that outputs of a formula would do
// the same.
double count_of(const std::vector<Stretch>& stretches) {
  constexpr std::size_t kLooked = 100'000, kFewest = 20;  // outputs; gaps
  constexpr double kLeastGap = 1e-9, kBetween = 0.25, kMostOff = 0.2, kWidest = 0.02;
  std::vector<double> outputs;
  for (const Stretch& stretch : stretches)
    for (const double y : stretch.y.first(std::min(stretch.y.size(), kLooked - outputs.size()))) outputs.push_back(y);
  std::ranges::sort(outputs);
  if (outputs.empty()) return 0.0;
  const double span = outputs.back() - outputs.front();
  std::vector<double> gaps;
  for (std::size_t i = 1; i < outputs.size(); ++i)
    if (const double gap = outputs[i] - outputs[i - 1]; gap > kLeastGap * span) gaps.push_back(gap);
  double place = last_place(outputs);
  if (place > kWidest * span) place = 0.0;
  if (gaps.size() < kFewest) return place;
  const double count = quantile_of(gaps, 0.5);
  const auto off = std::ranges::count_if(gaps, [&](double gap) {
    const double counts = gap / count;
    return counts < 1.0 - kBetween || std::abs(counts - std::round(counts)) > kBetween;
  });
  const bool counts = static_cast<double>(off) <= kMostOff * static_cast<double>(gaps.size());
  return counts && count <= kWidest * span ? count : place;
}

// Where the input stays within three of its own noises.
void add_rests(const History& history, double noise, std::vector<Stretch>& rests) {
  constexpr std::size_t kLeast = 8;  // samples
  const std::vector<double>& x = history.x;
  for (std::size_t first = 0, end = 0; first < x.size(); first = end) {
    for (end = first + 1; end < x.size() && std::abs(x[end] - x[first]) <= 3.0 * noise;) ++end;
    if (end - first >= kLeast) rests.push_back({{}, std::span(history.y).subspan(first, end - first)});
  }
}

struct OutputNoise {
  double noise = 0.0, count = 0.0;  // count: 0 where outputs are no counts
};

// Where inputs rest, of histories that rest long enough; else within the branches that are fitted. Not below what
// rounding to counts alone gives, 1 / sqrt(12) of one.
OutputNoise output_noise_of(const std::vector<History>& histories, const HistoriesOptions& options) {
  std::vector<Stretch> stretches, rests;
  std::size_t resting = 0;
  for (const History& history : histories) {
    if (!is_fitted(history, options)) continue;
    for (const Branch& branch : history.branches)
      stretches.push_back({part(history.x, branch), part(history.y, branch)});
    add_rests(history, input_noise_of({history}), rests);
  }
  for (const Stretch& rest : rests) resting += rest.y.size();
  const double count = count_of(stretches);
  const double noise = difference_noise(resting >= kRestingSamples ? rests : stretches);
  return {std::max(noise, count / std::sqrt(12.0)), count};
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
  Doubts(const TaxelHistories& taxel, double count, const HistoriesOptions& options)
      : taxel_(&taxel),
        count_(count),
        turn_given_(options.turn >= 0.0),
        fitted_(named(taxel.fit, options.fitted)),
        x_(span_of(taxel.fit, &History::x)),
        y_(span_of(fitted_, &History::y)) {}

  void report(std::vector<std::string>& warnings) const {
    report_slips(warnings);
    report_blocks(warnings);
    report_ends(warnings);
    report_dips(warnings);
    report_start(warnings);
    report_inner(warnings);
    report_loop(warnings);
  }

 private:
  // Turns that may be none, and a size of turns without them.
  void report_slips(std::vector<std::string>& warnings) const {
    double longest = 0.0;
    std::size_t branches = 0, left = 0;
    for (const History& history : fitted_) {
      branches += history.branches.size();
      for (const Branch& branch : history.branches) {
        const std::span<const double> x = part(history.x, branch);
        if (const double way = std::abs(x.back() - x.front()); way < kSlip * x_.length())
          longest = std::max(longest, way);
      }
    }
    if (turn_given_ || longest == 0.0) return;
    const double digit = std::pow(10.0, std::floor(std::log10(1.25 * longest)));
    const double turn = digit * std::ceil(1.25 * longest / digit - 1e-9);
    for (const History& history : fitted_) left += branches_along(history.x, turn).size();
    if (left >= branches) return;
    warnings.push_back(fmt::format(
        "{} of {} branches are due to inputs that go back by less than {:g} % of their span (by {:.3g} of {:.3g} at "
        "most); if these are slips or noise and no turns, --turn {:g} leaves {}",
        branches - left, branches, 100.0 * kSlip, longest, x_.length(), turn, counted(left, "branch", "branches")));
  }

  // The same rows again, where noise makes that no chance.
  void report_blocks(std::vector<std::string>& warnings) const {
    constexpr std::size_t kLeast = 8, kLooked = 1'000'000;  // rows
    constexpr double kClear = 3.0, kNoNoise = 1e-4;         // noises a count; of the span
    if (taxel_->noise < std::max(kClear * count_, kNoNoise * y_.length())) return;
    for (const History& history : fitted_) {
      const std::size_t rows = std::min(history.x.size(), kLooked);
      std::map<std::pair<double, double>, std::size_t> seen;  // where a row stood last
      std::size_t before = 0, length = 0;
      for (std::size_t i = 0; i <= rows; ++i) {
        const auto found = i < rows ? seen.find({history.x[i], history.y[i]}) : seen.end();
        const bool goes_on = found != seen.end() && length > 0 && found->second == before + length;
        if (!goes_on && length >= kLeast) {
          warnings.push_back(fmt::format(
              "samples {} to {} of sequence \"{}\" are the same as samples {} to {}, noise and all: they stand there "
              "twice, or they are no measurements",
              i - length + 1, i, history.name, before + 1, before + length));
          break;
        }
        if (!goes_on) {
          before = found == seen.end() ? 0 : found->second;
          length = found == seen.end() ? 0 : 1;
        } else {
          ++length;
        }
        if (i < rows) seen[{history.x[i], history.y[i]}] = i;
      }
    }
  }

  // Outputs at the lowest and at the highest input, a visit each but where a history begins: what was never loaded does
  // not come back to that output, which is no drift.
  void report_ends(std::vector<std::string>& warnings) const {
    for (const double end : {x_.low, x_.high}) {
      const double near = std::max(kVisits * x_.length(), taxel_->turn);
      std::vector<double> outputs;
      for (const History& history : fitted_) {
        std::optional<std::size_t> nearest;  // of this visit
        bool begins = true;
        for (std::size_t i = 0; i <= history.x.size(); ++i) {
          const bool there = i < history.x.size() && std::abs(history.x[i] - end) <= near;
          if (there && (!nearest || std::abs(history.x[i] - end) < std::abs(history.x[*nearest] - end))) nearest = i;
          if (there) continue;
          if (nearest && !begins) outputs.push_back(history.y[*nearest]);
          nearest.reset();
          begins = false;
        }
      }
      if (outputs.empty()) continue;
      const double farthest =
          *std::ranges::max_element(outputs, {}, [&](double y) { return std::abs(y - outputs.front()); });
      const double wandered = std::abs(farthest - outputs.front());
      if (wandered <= std::max(kWanders * y_.length(), kSeen * taxel_->noise)) continue;
      return warnings.push_back(
          fmt::format("at input {:g} the output went from {:.3g} to {:.3g}, {:.0f} % of its span, from visit to visit: "
                      "it drifts or still settles; models follow neither, and their errors hold it",
                      end, outputs.front(), farthest, 100.0 * wandered / y_.length()));
    }
  }

  // The longest way by which an output that had risen falls again inside a branch along which it should rise.
  void report_dips(std::vector<std::string>& warnings) const {
    double worst = 0.0, at = 0.0;
    const double rises = rising() ? 1.0 : -1.0;
    for (const History& history : fitted_) {
      for (const Branch& branch : history.branches) {
        const std::span<const double> x = part(history.x, branch), y = part(history.y, branch);
        const double sign = branch.ascending ? rises : -rises;
        std::vector<double> later(y.size());  // the least from here on
        for (std::size_t i = y.size(); i-- > 0;)
          later[i] = std::min(sign * y[i], i + 1 < y.size() ? later[i + 1] : HUGE_VAL);
        double least = HUGE_VAL;
        for (std::size_t i = 0; i < y.size(); ++i) {
          least = std::min(least, sign * y[i]);
          const double dip = std::min(sign * y[i] - least, sign * y[i] - later[i]);
          if (dip <= worst) continue;
          worst = dip;
          at = x[i];
        }
      }
    }
    if (worst <= std::max(kDips * y_.length(), kSeen * taxel_->noise)) return;
    warnings.push_back(fmt::format(
        "the output turns back by {:.3g} ({:.0f} % of its span) from input {:.3g} on, where the input does not turn: "
        "models change with the input in one direction only, and of one output several inputs may be true",
        worst, 100.0 * worst / y_.length(), at));
  }

  [[nodiscard]] bool rising() const {
    double sum = 0.0;
    for (const History& history : fitted_) {
      const double x = mean_of(history.x), y = mean_of(history.y);
      for (std::size_t i = 0; i < history.x.size(); ++i) sum += (history.x[i] - x) * (history.y[i] - y);
    }
    return sum >= 0.0;
  }

  [[nodiscard]] double near() const { return std::max(kNearEnd * x_.length(), taxel_->turn); }

  void report_start(std::vector<std::string>& warnings) const {
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

  void report_inner(std::vector<std::string>& warnings) const {
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

  void report_loop(std::vector<std::string>& warnings) const {
    std::vector<TaxelTable> sequences;
    for (const History& history : fitted_) sequences.push_back({history.x, history.y, history.branches});
    try {
      const ExternalLoop loop = external_loop(sequences, 1, taxel_->turn);
      if (loop.joined)
        warnings.push_back("no sweep goes all the way: the last branch and the first, which meet, are taken as one");
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
  double count_;
  bool turn_given_;
  std::vector<History> fitted_;
  Span x_, y_;
};

// Of all taxels that can be fitted, the one with the widest dead band.
void report_band(const Histories& histories, std::vector<std::string>& warnings) {
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

// Wild samples of a series, which its taxel keeps the first of where it is fitted to them.
void find_wild(const TableSeries& series, const HistoriesOptions& options, TaxelHistories& taxel,
               std::vector<std::string>& found) {
  for (const ImplausibleSample& wild : implausible_samples(series)) {
    found.push_back(implausible_text(series, wild));
    if (taxel.wild.empty() && is_fitted(taxel.fit.back(), options)) taxel.wild = found.back();
  }
}

void report_wild(const std::vector<std::string>& found, bool imported, std::vector<std::string>& warnings) {
  for (std::size_t i = 0; i < std::min(found.size(), kNamed); ++i)
    warnings.push_back(fmt::format("{}: correct it, or leave it out by {}--skip-bad-rows", found[i],
                                   imported ? "importing the table anew with " : ""));
  if (found.size() > kNamed)
    warnings.push_back(
        fmt::format("{} more lie as far from their neighbours", counted(found.size() - kNamed, "sample")));
}

// But for the rounding of the numbers.
bool is_constant(const Span& span) {
  constexpr double kRounding = 1e-8;
  return span.length() <= kRounding * std::max(std::abs(span.low), std::abs(span.high));
}

}  // namespace

Histories histories_of(const std::vector<TableSeries>& series, const std::string& source,
                       const HistoriesOptions& options) {
  Histories histories;
  histories.source = source;
  histories.origin = "imported";
  std::map<int, TaxelHistories> taxels;
  std::vector<std::string> wild;
  std::optional<double> count;  // of the first taxel that can be fitted
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
    find_wild(own, options, taxel, wild);
    if (!options.timed) continue;
    if (own.time_s.empty())
      throw AnalysisError("TB-MODEL-DYNAMIC", fmt::format("{} tells no times in seconds", source),
                          "give a table with a column time_s, or name it: --map time=COL; imported runs keep no times");
    taxel.fit.back().time_s = own.time_s;
    taxel.fit.back().held_s.assign(own.time_s.size(), 0.0);
  }
  for (auto& [number, taxel] : taxels) {
    const Span x = span_of(taxel.fit, &History::x), y = span_of(taxel.fit, &History::y);
    if (is_constant(x))
      throw AnalysisError("TB-TABLE-CONSTANT",
                          fmt::format("{}: the input of taxel {} is {} in all rows", source, number, x.low),
                          "a history needs inputs that rise and fall; --map input=COL names another column");
    if (options.turn >= x.length())
      throw AnalysisError("TB-TABLE-TURN",
                          fmt::format("{}: --turn {:g} is not less than what the inputs of taxel {} span, {:g} to {:g}",
                                      source, options.turn, number, x.low, x.high),
                          "state in input units by how much an input goes back when it turns, noise apart");
    find_turns(taxel, options, histories.warnings);
    if (is_constant(y)) taxel.status = TaxelStatus::kConstant;
    const OutputNoise found = output_noise_of(taxel.fit, options);
    taxel.noise = options.noise < 0.0 ? found.noise : options.noise;
    if (taxel.usable() && !count) count = found.count;
    taxel.score = taxel.fit;
    histories.taxels.push_back(std::move(taxel));
  }
  report_wild(wild, series.front().lines.empty(), histories.warnings);
  histories.rows = static_cast<int>(histories.taxels.size());
  const auto first = std::ranges::find_if(histories.taxels, [](const auto& t) { return t.usable(); });
  if (first != histories.taxels.end()) Doubts(*first, *count, options).report(histories.warnings);
  report_band(histories, histories.warnings);
  finish(histories);
  return histories;
}

}  // namespace tactbench::analysis
