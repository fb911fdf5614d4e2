#include "analysis/loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace tactbench::analysis {
namespace {

constexpr double kEndShare = 0.01;  // a sweep is full when it starts and ends this near to the ends of the range

// dV/dp of `repeat` at step i within its branch, by central difference of measured pressures.
class LocalSlope {
 public:
  LocalSlope(const Repeat& repeat, const Branch& branch, int step) {
    before_ = static_cast<std::size_t>(std::max(step - 1, branch.first));
    after_ = static_cast<std::size_t>(std::min(step + 1, branch.last));
    const Sample &a = repeat.steps[before_], &b = repeat.steps[after_];
    const double commanded = b.setpoint_psi - a.setpoint_psi;
    double moved = b.reference_psi - a.reference_psi;
    // Where the reference hardly moved or went back, the quotient would be noise: uses the commanded step.
    if (moved * commanded <= 0.1 * commanded * commanded) moved = commanded;
    inverse_ = moved == 0.0 ? 0.0 : 1.0 / moved;
  }
  [[nodiscard]] double operator()(const Repeat& repeat, std::size_t taxels, std::size_t taxel) const {
    return (repeat.volts[after_ * taxels + taxel] - repeat.volts[before_ * taxels + taxel]) * inverse_;
  }

 private:
  std::size_t before_ = 0, after_ = 0;
  double inverse_ = 0.0;
};

// The branch by which step i was reached (the turning sample belongs to the one that ends there [A7]).
const Branch& branch_of(const std::vector<Branch>& branches, int step) {
  const auto found = std::ranges::find_if(branches, [&](const Branch& b) { return step <= b.last; });
  return *found;
}

void check_same_levels(const SequenceData& sequence, const RepeatOptions& options, int last) {
  if (options.first_repeat < 0 || last >= static_cast<int>(sequence.repeats.size()) || options.first_repeat > last)
    throw AnalysisError("TB-ANALYSIS-REPEATS", "sequence " + sequence.name + " does not have the requested repeats",
                        "name repeats that are complete");
  const std::vector<Sample>& first = sequence.repeats[static_cast<std::size_t>(options.first_repeat)].steps;
  for (int r = options.first_repeat; r <= last; ++r) {
    const std::vector<Sample>& steps = sequence.repeats[static_cast<std::size_t>(r)].steps;
    if (!std::ranges::equal(steps, first, {}, &Sample::setpoint_psi, &Sample::setpoint_psi))
      throw AnalysisError("TB-ANALYSIS-REPEATS", "the repeats of sequence " + sequence.name + " have other set-points",
                          "analyse runs of one recipe only");
  }
}

}  // namespace

std::vector<Branch> branches_along(std::span<const double> x, double tolerance) {
  std::vector<Branch> branches;
  std::size_t first = 0, extreme = 0;  // of the current branch; leading equal samples join the first
  int direction = 0;
  for (std::size_t i = 1; i < x.size(); ++i) {
    const double ahead = x[i] - x[extreme];
    if (direction == 0) {
      if (std::abs(ahead) <= tolerance) continue;
      direction = ahead > 0.0 ? 1 : -1;
      extreme = i;
    } else if (ahead * direction >= 0.0) {
      extreme = i;
    } else if (-ahead * direction > tolerance) {
      branches.push_back({static_cast<int>(first), static_cast<int>(extreme), direction > 0});
      first = extreme;
      extreme = i;
      direction = -direction;
    }
  }
  if (direction != 0) branches.push_back({static_cast<int>(first), static_cast<int>(x.size()) - 1, direction > 0});
  return branches;
}

TaxelTable average_repeats(const SequenceData& sequence, int taxels, const RepeatOptions& options) {
  const int last = options.last_repeat < 0 ? static_cast<int>(sequence.repeats.size()) - 1 : options.last_repeat;
  check_same_levels(sequence, options, last);
  const auto width = static_cast<std::size_t>(taxels);
  const std::vector<Sample>& steps = sequence.repeats[static_cast<std::size_t>(options.first_repeat)].steps;
  const double weight = 1.0 / (last - options.first_repeat + 1);

  TaxelTable common;
  std::vector<double> commanded;
  for (const Sample& step : steps) commanded.push_back(step.setpoint_psi);
  common.branches = branches_along(commanded);
  common.pressure_psi.assign(steps.size(), 0.0);
  common.values.assign(steps.size() * width, 0.0);
  if (common.branches.empty())
    throw AnalysisError("TB-ANALYSIS-NO-LOOP", "sequence " + sequence.name + " never changes its pressure",
                        "run a recipe with turning points");
  for (int r = options.first_repeat; r <= last; ++r) {
    const Repeat& repeat = sequence.repeats[static_cast<std::size_t>(r)];
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const Sample& sample = repeat.steps[i];
      const double* volts = &repeat.volts[i * width];
      double* sum = &common.values[i * width];
      if (!options.move_to_setpoint) {
        common.pressure_psi[i] += weight * sample.reference_psi;
        for (std::size_t taxel = 0; taxel < width; ++taxel) sum[taxel] += weight * volts[taxel];
        continue;
      }
      common.pressure_psi[i] = sample.setpoint_psi;
      const int step = static_cast<int>(i);
      const LocalSlope slope(repeat, branch_of(common.branches, step), step);
      const double move = sample.setpoint_psi - sample.reference_psi;
      for (std::size_t taxel = 0; taxel < width; ++taxel)
        sum[taxel] += weight * (volts[taxel] + slope(repeat, width, taxel) * move);
    }
  }
  return common;
}

namespace {

struct Sweep {
  const TaxelTable* sequence;
  const Branch* branch;
  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(branch->last - branch->first) + 1; }
  // The k-th step counted from the low-pressure end.
  [[nodiscard]] std::size_t step(std::size_t k) const {
    return static_cast<std::size_t>(branch->ascending ? branch->first + static_cast<int>(k)
                                                      : branch->last - static_cast<int>(k));
  }
  [[nodiscard]] double pressure(std::size_t k) const { return sequence->pressure_psi[step(k)]; }
};

// Adds weight x the sweep's values at the grid's pressures, linear between its steps (and beyond, for the small
// differences of measured end pressures).
void add_sweep(const Sweep& sweep, std::span<const double> grid, std::size_t taxels, double weight,
               std::vector<double>& sum) {
  std::size_t k = 0;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    while (k + 2 < sweep.size() && sweep.pressure(k + 1) <= grid[i]) ++k;
    const double low = sweep.pressure(k), high = sweep.pressure(k + 1);
    const double share = high > low ? (grid[i] - low) / (high - low) : 0.0;
    const double* a = &sweep.sequence->values[sweep.step(k) * taxels];
    const double* b = &sweep.sequence->values[sweep.step(k + 1) * taxels];
    for (std::size_t taxel = 0; taxel < taxels; ++taxel)
      sum[i * taxels + taxel] += weight * (a[taxel] + share * (b[taxel] - a[taxel]));
  }
}

struct FullSweeps {
  std::vector<Sweep> up, down;
  double left_out = 0.0;
};

FullSweeps full_sweeps(std::span<const TaxelTable> sequences, double low, double high, double near) {
  FullSweeps full;
  for (const TaxelTable& sequence : sequences) {
    for (const Branch& branch : sequence.branches) {
      const Sweep sweep{&sequence, &branch};
      if (sweep.pressure(0) - low > near || high - sweep.pressure(sweep.size() - 1) > near) continue;
      (branch.ascending ? full.up : full.down).push_back(sweep);
    }
  }
  return full;
}

// Full sweeps between the extremes of the inputs; for measured inputs between percentiles if there are none.
FullSweeps full_sweeps(std::span<const TaxelTable> sequences, double turn) {
  std::vector<double> inputs;
  for (const TaxelTable& sequence : sequences)
    inputs.insert(inputs.end(), sequence.pressure_psi.begin(), sequence.pressure_psi.end());
  if (inputs.empty()) return {};
  std::ranges::sort(inputs);
  constexpr std::array kLeftOut = {0.0, 0.002, 0.005, 0.01, 0.02};
  FullSweeps widest;
  for (const double share : kLeftOut) {
    const auto out = static_cast<std::size_t>(share * static_cast<double>(inputs.size()));
    const double low = inputs[out], high = inputs[inputs.size() - 1 - out];
    FullSweeps full = full_sweeps(sequences, low, high, std::max(kEndShare * (high - low), turn));
    full.left_out = share;
    if (!full.up.empty() && !full.down.empty()) return full;
    if (share == 0.0) widest = std::move(full);
    if (turn <= 0.0) break;
  }
  return widest;
}

// Sequences that end where they began, as 0, +, -, 0 does: the last branch and the first are two parts of one sweep.
std::vector<TaxelTable> joined_ends(std::span<const TaxelTable> sequences, std::size_t taxels, double turn) {
  constexpr double kOpen = 0.05;  // share of the span of a taxel's values: with a wider gap it is not a sweep
  std::vector<TaxelTable> joined;
  for (const TaxelTable& own : sequences) {
    const std::size_t last = own.pressure_psi.size() - 1;
    if (own.branches.size() < 3 || own.branches.front().ascending != own.branches.back().ascending) continue;
    const auto [low, high] = std::ranges::minmax(own.pressure_psi);
    if (std::abs(own.pressure_psi[last] - own.pressure_psi[0]) > std::max(kEndShare * (high - low), turn)) continue;
    bool closes = true;
    for (std::size_t taxel = 0; taxel < taxels; ++taxel) {
      double least = HUGE_VAL, most = -HUGE_VAL;
      for (std::size_t i = taxel; i < own.values.size(); i += taxels) {
        least = std::min(least, own.values[i]);
        most = std::max(most, own.values[i]);
      }
      closes = closes && std::abs(own.values[last * taxels + taxel] - own.values[taxel]) <= kOpen * (most - least);
    }
    if (!closes) continue;
    TaxelTable& sweep = joined.emplace_back();
    for (const Branch& branch : {own.branches.back(), own.branches.front()}) {
      const auto first = static_cast<std::size_t>(branch.first), end = static_cast<std::size_t>(branch.last) + 1;
      sweep.pressure_psi.insert(sweep.pressure_psi.end(), &own.pressure_psi[first], &own.pressure_psi[0] + end);
      sweep.values.insert(sweep.values.end(), &own.values[first * taxels], &own.values[0] + end * taxels);
    }
    sweep.branches = {{0, static_cast<int>(sweep.pressure_psi.size()) - 1, own.branches.front().ascending}};
  }
  return joined;
}

}  // namespace

ExternalLoop external_loop(std::span<const TaxelTable> sequences, int taxels, double turn) {
  FullSweeps full = full_sweeps(sequences, turn);
  std::vector<TaxelTable> with_joined;
  if (turn > 0.0 && (full.up.empty() || full.down.empty())) {
    with_joined = joined_ends(sequences, static_cast<std::size_t>(taxels), turn);
    with_joined.insert(with_joined.end(), sequences.begin(), sequences.end());
    full = full_sweeps(with_joined, turn);
  }
  const auto& [up, down, left_out] = full;
  if (up.empty() || down.empty())
    throw AnalysisError("TB-ANALYSIS-NO-LOOP",
                        fmt::format("no sweep {} over the full {}", up.empty() ? "rises" : "falls",
                                    turn > 0.0 ? "range of inputs" : "pressure range"),
                        "measure from the lowest to the highest level and back without a reversal between");
  const Sweep& finest = *std::ranges::max_element(up, {}, &Sweep::size);
  ExternalLoop loop;
  loop.left_out = left_out;
  loop.joined = !with_joined.empty();
  for (std::size_t k = 0; k < finest.size(); ++k) {
    const double pressure = finest.pressure(k);
    // A held step (or, with measured pressures, one that did not advance) gives no new grid point.
    if (loop.pressure_psi.empty() || pressure > loop.pressure_psi.back()) loop.pressure_psi.push_back(pressure);
  }
  const auto width = static_cast<std::size_t>(taxels);
  loop.ascending.assign(loop.pressure_psi.size() * width, 0.0);
  loop.descending = loop.ascending;
  for (const Sweep& sweep : up)
    add_sweep(sweep, loop.pressure_psi, width, 1.0 / static_cast<double>(up.size()), loop.ascending);
  for (const Sweep& sweep : down)
    add_sweep(sweep, loop.pressure_psi, width, 1.0 / static_cast<double>(down.size()), loop.descending);
  return loop;
}

}  // namespace tactbench::analysis
