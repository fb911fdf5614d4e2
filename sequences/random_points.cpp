#include "sequences/random_points.h"

#include <algorithm>
#include <random>
#include <utility>

namespace tactbench::sequences {

namespace {

// The raw generator, because the distributions differ between standard libraries.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : generator_(seed) {}
  long between(long low, long high) {  // both may be drawn
    return low + static_cast<long>(generator_() % static_cast<std::uint64_t>(high - low + 1));
  }

 private:
  std::mt19937_64 generator_;
};

// Of two sizes the larger goes the way that the walk is heading, the smaller one back, so that it comes through the
// whole range, where steps of equal size would stay about where they began. At an end it turns round.
void wander(const RandomPoints& of, Draws& draws, std::vector<long>& points) {
  points.push_back(draws.between(of.low + 1, of.high));
  bool heading_up = draws.between(0, 1) == 1;
  for (int i = 1; i < of.count; ++i) {
    const bool up = i % 2 == 0;
    const auto [small, large] = std::minmax({draws.between(of.smallest, of.most), draws.between(of.smallest, of.most)});
    const long to = points.back() + (up ? 1 : -1) * (up == heading_up ? large : small);
    points.push_back(std::clamp(to, of.low, of.high));
    if (to <= of.low || to >= of.high) heading_up = to <= of.low;
  }
}

// Few presses cover the whole range only if no part of it is left to chance.
void presses(const RandomPoints& of, Draws& draws, std::vector<long>& points) {
  const long low = std::max(1L, of.low), levels = of.high - low + 1;
  std::vector<long> heights;
  for (long part = 0; part < of.count; ++part) {
    const long first = part * levels / of.count, end = std::max(first + 1, (part + 1) * levels / of.count);
    heights.push_back(low + draws.between(first, std::min(end, levels) - 1));
  }
  for (std::size_t left = heights.size(); left > 1; --left)
    std::swap(heights[left - 1], heights[static_cast<std::size_t>(draws.between(0, static_cast<long>(left) - 1))]);
  for (const long height : heights) points.insert(points.end(), {height, 0});
}

}  // namespace

std::vector<std::string> random_kind_names() { return {"reversals", "wander", "press"}; }

std::vector<long> draw_points(const RandomPoints& of) {
  Draws draws(of.seed);
  std::vector<long> points = {0};
  if (of.kind == RandomKind::kReversals) points.insert(points.end(), {of.high, 0});
  if (of.kind == RandomKind::kWander) wander(of, draws, points);
  for (int i = 0; i < of.count && of.kind == RandomKind::kReversals; ++i) {
    const long last = points.back();
    points.push_back(i % 2 == 0 ? draws.between(std::max(last, of.low) + 1, of.high) : draws.between(of.low, last - 1));
  }
  if (of.kind == RandomKind::kPress) presses(of, draws, points);
  if (points.back() != 0) points.push_back(0);
  return points;
}

}  // namespace tactbench::sequences
