#include "analysis/identify/rivals/gpi_lanes.h"

#include <algorithm>
#include <limits>
#include <map>

#include "analysis/identify/elam/vector_lanes.h"

namespace tactbench::analysis {
namespace {

// Knots of the turns that are remembered, the present place last: a minimum at even places, a maximum at odd ones. The
// first is the virgin state, which no fall brings back.
using Turns = std::vector<std::uint32_t>;

void go(Turns& turns, std::uint32_t knot) {
  if (knot == turns.back()) return;
  const bool up = knot > turns.back();
  if (up == (turns.size() % 2 == 0))
    turns.back() = knot;
  else
    turns.push_back(knot);
  const auto wiped = [&] {
    const std::size_t size = turns.size();
    return up ? size >= 4 && knot >= turns[size - 3] : size >= 5 && knot <= turns[size - 3];
  };
  while (wiped()) {
    turns.erase(turns.end() - 3, turns.end() - 1);
  }
}

struct State {
  std::uint32_t parent = GpiTree::kVirgin, knot = 0;
  std::map<std::uint32_t, std::uint32_t> steps;  // knot -> number, in order of appearance
};

// States and steps as they appear.
struct Growing {
  std::map<Turns, std::uint32_t> known;
  std::vector<State> states;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> steps;  // state, knot
  Turns turns;
  std::uint32_t here = 0;

  void begin() {
    turns = {0};
    here = put(GpiTree::kVirgin, 0);
  }
  void move(std::uint32_t knot) {
    if (knot == turns.back()) return;
    go(turns, knot);
    here = put(here, knot);
  }
  std::uint32_t compare(std::uint32_t knot) {
    const auto [at, fresh] = states[here].steps.try_emplace(knot, static_cast<std::uint32_t>(steps.size()));
    if (fresh) steps.emplace_back(here, knot);
    return at->second;
  }

 private:
  std::uint32_t put(std::uint32_t parent, std::uint32_t knot) {
    const auto [at, fresh] = known.try_emplace(turns, static_cast<std::uint32_t>(states.size()));
    if (fresh) states.push_back({parent, knot, {}});
    return at->second;
  }
};

}  // namespace

GpiTree::GpiTree(const FitSamples& samples) {
  const double span = samples.x_high - samples.x_low;
  const auto share = [&](std::size_t i) { return (samples.x[i] - samples.x_low) / span; };
  std::vector<bool> fitted(samples.x.size(), false);
  for (const std::size_t i : samples.fitted) fitted[i] = true;
  // Visits all that a walk along the branches meets: begins of histories, moves, comparisons.
  const auto walk = [&](const auto& begin, const auto& rise, const auto& move, const auto& compare) {
    std::size_t last = 0;
    for (const FitSamples::Part& part : samples.parts) {
      if (part.opens_history) begin();
      if (part.from_top) rise();
      // Of what lies between two branches the turns alone count.
      const std::vector<double>& x = samples.x;
      for (std::size_t i = part.opens_history ? part.first : std::min(last + 1, part.first); i < part.first; ++i)
        if ((x[i] - x[i - 1]) * (x[i + 1] - x[i]) <= 0.0) move(i);
      move(part.first);
      for (std::size_t i = part.first + 1; i <= part.last; ++i)
        if (fitted[i]) compare(i);
      move(last = part.last);
    }
  };
  const auto add = [&](std::size_t i) { knots.push_back(share(i)); };
  knots.push_back(0.0);
  walk([] {}, [&] { knots.push_back(1.0); }, add, add);
  std::ranges::sort(knots);
  knots.erase(std::unique(knots.begin(), knots.end()), knots.end());
  const auto knot = [&](std::size_t i) {
    return static_cast<std::uint32_t>(std::ranges::lower_bound(knots, share(i)) - knots.begin());
  };
  Growing grown;
  std::vector<std::uint32_t> step_of;
  walk([&] { grown.begin(); }, [&] { grown.move(static_cast<std::uint32_t>(knots.size() - 1)); },
       [&](std::size_t i) { grown.move(knot(i)); },
       [&](std::size_t i) {
         sample_.push_back(i);
         step_of.push_back(grown.compare(knot(i)));
       });
  // Steps state by state; a slot for each state that others are reached from, as long as they are not all made.
  std::vector<std::uint32_t> last_child(grown.states.size(), 0), number(grown.steps.size()), free;
  for (std::uint32_t n = 0; n < grown.states.size(); ++n)
    if (grown.states[n].parent != kVirgin) last_child[grown.states[n].parent] = n;
  for (std::uint32_t n = 0; n < grown.states.size(); ++n) {
    const State& state = grown.states[n];
    Node node{kVirgin, 0, state.knot, steps.size(), 0};
    for (const auto& [at, step] : state.steps) {
      number[step] = static_cast<std::uint32_t>(steps.size());
      steps.push_back({at, 0.0});
    }
    node.end = steps.size();
    if (state.parent != kVirgin) node.from = nodes[state.parent].slot;
    if (free.empty()) free.push_back(slots++);
    node.slot = free.back();
    free.pop_back();
    nodes.push_back(node);
    if (last_child[n] == 0) free.push_back(node.slot);
    if (state.parent != kVirgin && last_child[state.parent] == n) free.push_back(node.from);
  }
  for (const std::uint32_t step : step_of) {
    step_of_.push_back(number[step]);
    steps[number[step]].weight += 1.0;
  }
}

GpiTree::Target GpiTree::target(std::span<const double> y) const {
  Target target{std::vector<double>(steps.size(), 0.0), 0.0};
  for (std::size_t k = 0; k < sample_.size(); ++k) target.mean[step_of_[k]] += y[sample_[k]];
  for (std::size_t s = 0; s < steps.size(); ++s) target.mean[s] /= steps[s].weight;
  for (std::size_t k = 0; k < sample_.size(); ++k) {
    const double off = y[sample_[k]] - target.mean[step_of_[k]];
    target.constant += off * off;
  }
  return target;
}

// GPI along the tree of states.

// Vectors wider than the base's registers are passed between always-inlined functions only.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace {

// e^x for x in -700..700: Cody and Waite's reduction, Taylor's polynomial on |r| < 0.35, to the last place or two.
TACTBENCH_INLINE Lanes exponential(const Lanes& x) {
  constexpr double kShift = 6755399441055744.0;  // 1.5 x 2^52: what is added to it is rounded to a whole number
  const Lanes shifted = x * 1.4426950408889634 + kShift, whole = shifted - kShift;
  const Lanes r = (x - whole * 0.693147180369123816490) - whole * 1.90821492927058770002e-10;
  Lanes sum = r * (1.0 / 479001600.0) + 1.0 / 39916800.0;
  for (const double term : {1.0 / 3628800.0, 1.0 / 362880.0, 1.0 / 40320.0, 1.0 / 5040.0, 1.0 / 720.0, 1.0 / 120.0,
                            1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0})
    sum = sum * r + term;
  LaneMask bits, power;
  __builtin_memcpy(&bits, &sum, sizeof(Lanes));
  __builtin_memcpy(&power, &shifted, sizeof(Lanes));
  bits += power << 52;
  Lanes result;
  __builtin_memcpy(&result, &bits, sizeof(Lanes));
  return result;
}

// What of an operator's output depends on which unknown: envelope by ln a, l0, ln dl, ln b, r0, ln dr.
constexpr int kGpiFields = 6;
// In an envelope table, and in a slot an operator: the value and its derivatives.
constexpr int kGpiValues = 2;

template <bool kGradient>
TACTBENCH_INLINE void envelopes(GpiLanes& lanes) {
  constexpr int kWidth = kGradient ? kGpiFields : kGpiValues;
  for (const bool is_left : {true, false}) {
    Lanes ln_a, start, ln_rise;
    load(ln_a, &lanes.unknown[is_left ? kLnA : kLnB][0]);
    load(start, &lanes.unknown[is_left ? kL0 : kR0][0]);
    load(ln_rise, &lanes.unknown[is_left ? kLnDl : kLnDr][0]);
    const Lanes a = exponential(ln_a), rise = exponential(ln_rise), end = exponential(-a);
    const Lanes per_whole = 1.0 / (1.0 - end);
    double* row = lanes.envelopes.data() + (is_left ? 0 : kLanes);
    for (const double u : lanes.tree->knots) {
      const Lanes rest = exponential(-a * u), shape = (1.0 - rest) * per_whole;
      store(row, Lanes(start + rise * shape));
      if constexpr (kGradient) {
        store(row + 2 * kLanes, Lanes(rise * a * (u * rest - shape * end) * per_whole));
        store(row + 4 * kLanes, Lanes(rise * shape));
      }
      row += kWidth * kLanes;
    }
  }
}

template <bool kGradient>
struct GpiPlays {
  Lanes output[kGpiOperators];
  Lanes field[kGradient ? kGpiOperators : 1][kGpiFields];
};

TACTBENCH_INLINE Lanes masked(const LaneMask& mask, const Lanes& value) {
  LaneMask bits;
  __builtin_memcpy(&bits, &value, sizeof(Lanes));
  bits &= mask;
  Lanes result;
  __builtin_memcpy(&result, &bits, sizeof(Lanes));
  return result;
}

template <bool kGradient>
TACTBENCH_INLINE void gpi_walk(GpiLanes& lanes, const GpiTree::Target& target) {
  constexpr int kWidth = kGradient ? kGpiFields : kGpiValues, kSlot = kGpiOperators * (kGradient ? 1 + kGpiFields : 1);
  const GpiTree& tree = *lanes.tree;
  const Lanes zero{}, one = zero + 1.0;
  Lanes threshold[kGpiOperators], density[kGpiOperators];
  Lanes ln_alpha, s_of;
  load(ln_alpha, &lanes.unknown[kLnAlpha][0]);
  load(s_of, &lanes.unknown[kS][0]);
  const Lanes alpha = exponential(ln_alpha), fall = exponential(-s_of);
  for (int i = 0; i < kGpiOperators; ++i) {
    threshold[i] = alpha * static_cast<double>(i);
    density[i] = i == 0 ? one : density[i - 1] * fall;
  }
  envelopes<kGradient>(lanes);
  Lanes j = zero + target.constant, normal[kGpiNormals], slope[kGpiUnknowns];
  for (Lanes& value : normal) value = zero;
  for (Lanes& value : slope) value = zero;
  for (const GpiTree::Node& node : tree.nodes) {
    GpiPlays<kGradient> here;
    for (Lanes& value : here.output) value = zero;
    for (auto& fields : here.field)
      for (Lanes& value : fields) value = zero;
    if (node.from != GpiTree::kVirgin) {
      const double* slot = lanes.slots.data() + static_cast<std::size_t>(node.from) * kSlot * kLanes;
      for (int i = 0; i < kGpiOperators; ++i) {
        load(here.output[i], slot);
        slot += kLanes;
        for (int f = 0; kGradient && f < kGpiFields; ++f, slot += kLanes) load(here.field[i][f], slot);
      }
    }
    {
      const double* row = lanes.envelopes.data() + static_cast<std::size_t>(node.knot) * kWidth * kLanes;
      Lanes left, right, by[4];
      load(left, row);
      load(right, row + kLanes);
      for (int k = 0; kGradient && k < 4; ++k) load(by[k], row + (2 + k) * kLanes);
      double* slot = lanes.slots.data() + static_cast<std::size_t>(node.slot) * kSlot * kLanes;
      for (int i = 0; i < kGpiOperators; ++i) {
        const Lanes up = right + threshold[i], low = left - threshold[i];
        const LaneMask on_right = here.output[i] > up;
        const Lanes most = here.output[i] > up ? up : here.output[i];
        const LaneMask on_left = low > most;
        here.output[i] = low > most ? low : most;
        store(slot, here.output[i]);
        slot += kLanes;
        if constexpr (kGradient) {
          const LaneMask held = ~(on_left | on_right), falls = on_right & ~on_left;
          Lanes* field = here.field[i];
          for (int f = 0; f < kGpiFields; ++f) field[f] = masked(held, field[f]);
          field[0] += masked(on_left, by[0]);
          field[1] += masked(on_left, one);
          field[2] += masked(on_left, by[2]);
          field[3] += masked(falls, by[1]);
          field[4] += masked(falls, one);
          field[5] += masked(falls, by[3]);
          for (int f = 0; f < kGpiFields; ++f, slot += kLanes) store(slot, field[f]);
        }
      }
    }
    Lanes kept[kGradient ? kGpiOperators : 1][kGpiFields + 1];
    for (int i = 0; kGradient && i < kGpiOperators; ++i) {
      for (int f = 0; f < kGpiFields; ++f) kept[i][f] = density[i] * here.field[i][f];
      kept[i][kGpiFields] = threshold[i] * (kept[i][4] - kept[i][1]);
    }
    for (std::size_t s = node.first; s < node.end; ++s) {
      const double* row = lanes.envelopes.data() + static_cast<std::size_t>(tree.steps[s].knot) * kWidth * kLanes;
      Lanes left, right;
      load(left, row);
      load(right, row + kLanes);
      Lanes off = zero - target.mean[s], on_left_sum = zero, on_right_sum = zero, by_s = zero, by_alpha = zero;
      Lanes held_sum[kGpiFields];
      for (Lanes& value : held_sum) value = zero;
      for (int i = 0; i < kGpiOperators; ++i) {
        const Lanes up = right + threshold[i], low = left - threshold[i];
        const Lanes most = here.output[i] > up ? up : here.output[i];
        const Lanes output = density[i] * (low > most ? low : most);
        off += output;
        if constexpr (kGradient) {
          const LaneMask on_right = here.output[i] > up, on_left = low > most, held = ~(on_left | on_right);
          const Lanes rises = masked(on_left, density[i]), falls = masked(LaneMask(on_right & ~on_left), density[i]);
          on_left_sum += rises;
          on_right_sum += falls;
          by_alpha += threshold[i] * (falls - rises) + masked(held, kept[i][kGpiFields]);
          by_s -= output * static_cast<double>(i);
          for (int f = 0; f < kGpiFields; ++f) held_sum[f] += masked(held, kept[i][f]);
        }
      }
      const double weight = tree.steps[s].weight;
      const Lanes weighted = off * weight;
      j += weighted * off;
      if constexpr (kGradient) {
        Lanes by[4];
        for (int k = 0; k < 4; ++k) load(by[k], row + (2 + k) * kLanes);
        const Lanes own[kGpiUnknowns] = {by[0] * on_left_sum + held_sum[0],
                                         on_left_sum + held_sum[1],
                                         by[2] * on_left_sum + held_sum[2],
                                         by[1] * on_right_sum + held_sum[3],
                                         on_right_sum + held_sum[4],
                                         by[3] * on_right_sum + held_sum[5],
                                         by_alpha,
                                         by_s};
        for (int a = 0, k = 0; a < kGpiUnknowns; ++a) {
          slope[a] += weighted * own[a];
          const Lanes much = own[a] * weight;
          for (int b = 0; b <= a; ++b, ++k) normal[k] += much * own[b];
        }
      }
    }
  }
  store(&lanes.j[0], j);
  if constexpr (kGradient) {
    for (std::size_t k = 0; k < kGpiNormals; ++k) store(&lanes.normal[k][0], normal[k]);
    for (std::size_t k = 0; k < kGpiUnknowns; ++k) store(&lanes.slope[k][0], slope[k]);
  }
}

TACTBENCH_CLONES void evaluate_lanes(GpiLanes& lanes, const GpiTree::Target& target, bool gradient) {
  if (gradient)
    gpi_walk<true>(lanes, target);
  else
    gpi_walk<false>(lanes, target);
}

}  // namespace
#pragma GCC diagnostic pop

GpiLanes::GpiLanes(const GpiTree& own) : tree(&own) {
  envelopes.resize(own.knots.size() * kGpiFields * kMost);
  slots.resize(static_cast<std::size_t>(own.slots) * kGpiOperators * (1 + kGpiFields) * kMost);
}

void GpiLanes::evaluate(const GpiTree::Target& target, bool gradient) {
  for (std::size_t lane = 0; lane < kMost; ++lane)
    for (std::size_t k = 0; k < kGpiUnknowns; ++k) unknown[k][lane] = at[lane][k];
  evaluate_lanes(*this, target, gradient);
}

}  // namespace tactbench::analysis
