#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "bench/simulation/counter_noise.h"
#include "bench/simulation/specimen_film.h"

namespace tactbench::bench {

namespace {

constexpr std::uint64_t kMountStream = 50;
constexpr double kAtTheRim = 0.25;  // of a line's width still feels the membrane on the outermost line

double edge_share(const SpecimenOptions& options, int row, int column) {
  if (options.edge_outside_lines <= 0) return 1.0;
  int line = 0;  // from the edge
  switch (options.edge_outside) {
    case MountEdge::kFirstRow:
      line = row;
      break;
    case MountEdge::kLastRow:
      line = options.rows - 1 - row;
      break;
    case MountEdge::kFirstColumn:
      line = column;
      break;
    case MountEdge::kLastColumn:
      line = options.columns - 1 - column;
      break;
  }
  return std::min(1.0, (line + kAtTheRim) / options.edge_outside_lines);
}

// What the chamber's tilt adds at each taxel of the film.
std::vector<double> tilt_shares(const SpecimenOptions& options) {
  const std::vector<std::size_t> wiring = turned_wiring(options);
  const double degrees = options.effects.chamber_tilt_deg - options.turned_in_chamber_deg;
  const double angle = degrees * std::numbers::pi / 180.0;
  const double side = std::max({options.rows - 1, options.columns - 1, 1});
  std::vector<double> shares(wiring.size());
  for (std::size_t lead = 0; lead < wiring.size(); ++lead) {
    const int row = static_cast<int>(lead) / options.columns;
    const int column = static_cast<int>(lead) % options.columns;
    const double up = 0.5 * (options.rows - 1) - row;
    const double right = column - 0.5 * (options.columns - 1);
    const double toward = right * std::cos(angle) + up * std::sin(angle);
    shares[wiring[lead]] = options.effects.chamber_tilt * toward / side;
  }
  return shares;
}

}  // namespace

std::vector<std::string> mount_turn_words(bool square) {
  std::vector<std::string> words = {"none",      "turned-180", "rows-mirrored", "columns-mirrored",
                                    "turned-90", "turned-270", "transposed",    "anti-transposed"};
  if (!square) words.resize(4);
  return words;
}

std::vector<std::string> mount_edge_words() { return {"first-row", "last-row", "first-column", "last-column"}; }

std::vector<double> shares_of_chamber(const SpecimenOptions& options) {
  std::vector<double> shares;
  const std::vector<double> tilt = tilt_shares(options);
  const double half_rows = 0.5 * (options.rows - 1);
  const double half_columns = 0.5 * (options.columns - 1);
  const double corner = std::max(half_rows * half_rows + half_columns * half_columns, 1e-12);
  for (int i = 0; i < options.rows * options.columns; ++i) {
    const int row = i / options.columns;
    const int column = i % options.columns;
    const double y = row - half_rows;
    const double x = column - half_columns;
    double share = 1.0 + options.effects.chamber_nonuniformity * (x * x + y * y) / corner;
    share += tilt[static_cast<std::size_t>(i)];
    if (options.mount_seed != 0) {
      const auto key = hash_of(options.sensor_seed, kMountStream, options.mount_seed);
      const double change = options.effects.remount_variation * bell_of(hash_of(key, 0, static_cast<std::uint64_t>(i)));
      share *= std::max(0.0, 1.0 + change);
    }
    shares.push_back(share * edge_share(options, row, column));
  }
  return shares;
}

std::vector<std::size_t> turned_wiring(const SpecimenOptions& options) {
  const int last_row = options.rows - 1;
  const int last_column = options.columns - 1;
  const auto from = [&](int r, int c) -> std::pair<int, int> {
    switch (options.mount_turn) {
      case MountTurn::kNone:
        break;
      case MountTurn::kBy90:
        return {last_row - c, r};
      case MountTurn::kBy180:
        return {last_row - r, last_column - c};
      case MountTurn::kBy270:
        return {c, last_column - r};
      case MountTurn::kRowsMirrored:
        return {last_row - r, c};
      case MountTurn::kColumnsMirrored:
        return {r, last_column - c};
      case MountTurn::kTransposed:
        return {c, r};
      case MountTurn::kAntiTransposed:
        return {last_row - c, last_column - r};
    }
    return {r, c};
  };
  std::vector<std::size_t> wiring;
  for (int r = 0; r < options.rows; ++r) {
    for (int c = 0; c < options.columns; ++c) {
      const auto [row, column] = from(r, c);
      if (row < 0 || row > last_row || column < 0 || column > last_column) {
        throw std::invalid_argument("specimen: an array that is not square cannot be turned by a quarter");
      }
      wiring.push_back(static_cast<std::size_t>(row) * static_cast<std::size_t>(options.columns) +
                       static_cast<std::size_t>(column));
    }
  }
  return wiring;
}

}  // namespace tactbench::bench
