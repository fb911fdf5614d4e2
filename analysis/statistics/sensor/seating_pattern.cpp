#include <array>
#include <cmath>

#include "analysis/statistics/sensor/seating.h"

namespace tactbench::analysis {

namespace {

// Sums of Pearson's coefficient.
struct PairSums {
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, yy = 0.0, xy = 0.0;
  void add(double a, double b) {
    n += 1.0;
    x += a;
    y += b;
    xx += a * a;
    yy += b * b;
    xy += a * b;
  }
  [[nodiscard]] double correlation() const {
    const double spread = (xx - x * x / n) * (yy - y * y / n);
    return n < 3.0 || !(spread > 0.0) ? 0.0 : (xy - x * y / n) / std::sqrt(spread);
  }
};

// Transposed first, then rows and columns turned round: all eight symmetries of the square. Said from the sensor's
// side: what was done to it since the last seating.
struct Position {
  bool transposed, rows_reversed, columns_reversed;
  const char* name;
};
constexpr std::array<Position, 8> kPositions = {
    {{false, false, false, "as before"},
     {false, true, true, "turned by 180 degrees"},
     {false, true, false, "mirrored, first row with last"},
     {false, false, true, "mirrored, first column with last"},
     {true, false, true, "turned clockwise by 90 degrees"},
     {true, true, false, "turned counter-clockwise by 90 degrees"},
     {true, false, false, "mirrored, rows with columns"},
     {true, true, true, "mirrored, rows with columns from the far corner"}}};

}  // namespace

std::vector<SeatingPosition> compare_positions(int rows, int columns, std::span<const double> now,
                                               std::span<const double> before, const std::vector<bool>& use_now,
                                               const std::vector<bool>& use_before) {
  std::vector<SeatingPosition> fits;
  for (const Position& position : kPositions) {
    if (position.transposed && rows != columns) continue;
    PairSums pairs;
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {  // a taxel of the last seating, and where it would lie now
        int row = position.transposed ? c : r;
        int column = position.transposed ? r : c;
        if (position.rows_reversed) row = rows - 1 - row;
        if (position.columns_reversed) column = columns - 1 - column;
        const auto was = static_cast<std::size_t>(r * columns + c);
        const auto is = static_cast<std::size_t>(row * columns + column);
        if (use_now[is] && use_before[was]) pairs.add(now[is], before[was]);
      }
    }
    fits.push_back({position.name, pairs.correlation()});
  }
  return fits;
}

}  // namespace tactbench::analysis
