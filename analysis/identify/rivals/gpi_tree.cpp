#include "analysis/identify/rivals/gpi_tree.h"

#include <algorithm>
#include <limits>
#include <map>

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

}  // namespace tactbench::analysis
