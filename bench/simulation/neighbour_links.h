// Coupling between neighbouring taxels, in row, column and diagonal, each link drawn by the sensor's seed: used for the
// harsh film's electrical coupling and for the skin of the foam.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bench/config/plant_options.h"

namespace tactbench::bench {

class NeighbourLinks {
 public:
  // `beside`, `corner`: the mean share of a link in row or column, and of a diagonal one; each link differs from it by
  // up to half. `stream`: of the sensor's seed.
  NeighbourLinks(const SpecimenOptions& options, std::uint64_t stream, double side, double corner);
  // Moves the values of neighbours toward each other.
  void couple(std::span<double> values) const;

 private:
  struct Link {
    std::size_t from, to;
    double share;
  };
  std::vector<Link> links_;
};

}  // namespace tactbench::bench
