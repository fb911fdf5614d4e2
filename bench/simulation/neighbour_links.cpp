#include "bench/simulation/neighbour_links.h"

#include "bench/simulation/counter_noise.h"

namespace tactbench::bench {

NeighbourLinks::NeighbourLinks(const SpecimenOptions& options, std::uint64_t stream, double side, double corner) {
  const auto rows = static_cast<std::size_t>(options.rows), columns = static_cast<std::size_t>(options.columns);
  for (std::size_t i = 0; i < rows * columns; ++i) {
    const auto link = [&](std::uint64_t side, std::size_t to, double usual) {
      links_.push_back({i, to, usual * (0.5 + uniform_of(hash_of(options.sensor_seed, stream, 4 * i + side)))});
    };
    const bool last_row = i / columns + 1 == rows, last_column = i % columns + 1 == columns;
    if (!last_column) link(0, i + 1, side);
    if (!last_row) link(1, i + columns, side);
    if (!last_row && !last_column) link(2, i + columns + 1, corner);
    if (!last_row && i % columns > 0) link(3, i + columns - 1, corner);
  }
}

void NeighbourLinks::couple(std::span<double> values) const {
  const std::vector<double> alone(values.begin(), values.end());
  for (const Link& link : links_) {
    values[link.from] += link.share * (alone[link.to] - alone[link.from]);
    values[link.to] += link.share * (alone[link.from] - alone[link.to]);
  }
}

}  // namespace tactbench::bench
