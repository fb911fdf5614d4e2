// Estimates the noise of otherwise smooth samples, from differences of neighbours that cancel slope and curvature.
#pragma once

#include <span>
#include <vector>

namespace tactbench::analysis {

// Samples in a row without a turn between them. `x`: where they lie, equally long; empty: evenly.
struct Stretch {
  std::span<const double> x, y;
};

// Standard deviation of a sample; 0 when no stretch has two. For each order from 1 to 6 the median size of the
// differences of all stretches: plain ones, and divided ones where the inputs are distinct. Each is the noise and what
// slope and curvature leave, so the least is taken, of orders with 20 differences at least; where a history is too
// short for any, with 2.
double difference_noise(std::span<const Stretch> stretches);

}  // namespace tactbench::analysis
