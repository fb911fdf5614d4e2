// Coupling between neighbouring taxels, in row and column and diagonally, each link drawn by the sensor's seed: the
// harsh film's electrical coupling, the skin of the foam.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bench/config/plant_options.h"

namespace tactbench::bench {

class NeighbourLinks {
 public:
  // `beside`, `corner`: the mean share of a link in row or column, and of a diagonal one; each differs by up to half of
  // it. `stream`: of the sensor's seed.
  NeighbourLinks(const SpecimenOptions& options, std::uint64_t stream, double beside, double corner);
  // Neighbours draw each other's values together.
  void couple(std::span<double> values) const;

 private:
  struct Link {
    std::size_t from, to;
    double share;
  };
  std::vector<Link> links_;
};

}  // namespace tactbench::bench
