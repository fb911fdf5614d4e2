// Checks before a run how a sensor is seated: from an unloaded and a lightly loaded frame, compared with those of the
// sensor's last good seating if there is one, to findings as text for the operator. Pure functions.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tactbench::analysis {

// Bounds against the simulated sensors (bench/simulation/README.md): taxels differ by 62 % at 8 psi, line means by a
// bowl and a tilt. Over 200 arrays the weakest line had 0.19 of the upper quartile of lines, the weakest edge 0.23 of
// the median line, and a re-mounted array correlated with itself by 0.97 and more (local pressure changed by 10 %),
// with a turned or mirrored image of itself by 0.53 at most. Not verified on hardware.
struct SeatingBounds {
  double least_response_v = 0.01;   // a taxel below is dead: six times the noise of two frames of two scans
  double least_array_v = 0.02;      // the better lines' mean below: nothing answers
  double dead_line_share = 0.08;    // of the upper quartile of the lines' means; open lines still see some crosstalk
  double dead_taxels_share = 0.02;  // of the taxels, dead one by one: above, a warning
  double edge_share = 0.5;          // outermost line against the last seating and the other lines
  double edge_reach_share = 0.8;    // lines below this belong to the fall-off
  double edge_share_alone = 0.15;   // the same two without a last seating: against the median line
  double edge_reach_share_alone = 0.2;
  double edge_least_share = 0.03;  // of the upper quartile: a fall-off has a line above, an open connector has not
  double turn_margin = 0.2;        // by which another position has to fit better ...
  double turn_correlation = 0.8;   // ... and how well
  double least_spread = 0.05;      // relative, of the last pattern: an even array looks the same from all sides
  double correlation_warning = 0.9, correlation_fail = 0.8;
  double lines_correlation = 0.5;  // below, the last seating says nothing of single lines
  // A virgin film answers 8 % weaker than a conditioned one, and 0.25 psi of 8 are 6 %.
  double mean_warning = 0.2, mean_fail = 0.5;
  double same_pressure_psi = 0.5;  // means are compared only within this
};
inline constexpr SeatingBounds kSeating;

struct SeatingFrames {
  double pressure_psi = 0.0;                 // of the loaded frame, measured
  std::vector<double> unloaded_v, loaded_v;  // rows x columns, row-major
};

struct SeatingFinding {
  std::string kind;     // no-response | dead-rows | dead-columns | half-inserted | edge-outside | turned | deviation |
                        // dead-taxels
  std::string verdict;  // fail | warning
  std::vector<int> rows, columns;  // the lines meant, ascending, counted from 0; of dead-taxels one pair a taxel
  std::string text;                // for people
};

struct SeatingResult {
  std::string verdict = "pass";  // pass | warning | fail: the worst of the findings
  std::vector<SeatingFinding> findings;
  double mean_response_v = 0.0;
  std::optional<double> correlation, mean_ratio;  // with the last seating
  std::vector<int> dead_taxels;                   // all, known ones too, in lines that answer
};

// `last`: the frames of the last good seating; taxels dead there are known and found no more. Throws
// std::invalid_argument when a frame does not have rows x columns values.
SeatingResult check_seating(int rows, int columns, const SeatingFrames& now, const std::optional<SeatingFrames>& last);

// Parts of it, seating.cpp: how well `now` fits `before` in each of the positions that the shape allows (8 of a
// square, 4 of a rectangle), the taxels where `use` is true alone; the first position is the identity.
struct SeatingPosition {
  std::string name;  // "turned by 180 degrees"
  double correlation = 0.0;
};
std::vector<SeatingPosition> compare_positions(int rows, int columns, std::span<const double> now,
                                               std::span<const double> before, const std::vector<bool>& use_now,
                                               const std::vector<bool>& use_before);

// Part of the seating check: whole rows and columns. Used only by seating.cpp.
struct SeatingTaxels {
  int rows = 0, columns = 0;
  std::vector<double> response_v, loaded_v, before_v;  // before_v: empty where no last seating may be compared
  std::vector<bool> known_dead;
  std::vector<bool> open_rows, open_columns;  // find_open_lines
};

// Lines that are silent as a whole; the lines across are judged without them.
void find_open_lines(SeatingTaxels& taxels, double least_v);

// Dead lines, half-inserted connectors, edges outside the membrane, along one axis. `lost` is set for the taxels of
// the lines found.
std::vector<SeatingFinding> check_lines(const SeatingTaxels& taxels, bool along_rows, std::vector<bool>& lost);

}  // namespace tactbench::analysis
