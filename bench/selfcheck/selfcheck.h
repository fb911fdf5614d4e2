// Does this program do on this machine what it is said to do? Each check computes something whose right answer is
// known beforehand, by the code that users run, and says what it expected and what it found.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace tactbench::bench {

struct SelfcheckLine {
  std::string area;  // identification, inverse, dispatch, compensator, store, clock, run
  std::string what, expected, found;
  bool pass = false;
};
using SelfcheckLines = std::vector<SelfcheckLine>;

struct SelfcheckAnswer {
  bool pass = false;
  std::string found;
};
// A check that throws has failed; what it threw is what was found.
SelfcheckLine selfchecked(const std::string& area, const std::string& what, const std::string& expected,
                          const std::function<SelfcheckAnswer()>& check);

// ELAM, GPI, MPI and POLY, each fitted to data without noise that one of its kind made: the model comes out again.
SelfcheckLines check_known_fits();
// direct(inverse(y)) = y along random histories, 1e-9 of the output's span (analysis/models/model.h).
SelfcheckLines check_round_trips();
// The same bits on every level of vector code that this machine has.
SelfcheckLines check_dispatch_levels();
// The streaming compensator gives back the pressures that the direct formula made its outputs from.
SelfcheckLines check_compensator();
// In files of their own in `folder`, which exists: fdatasync, write and read back, a writer killed in mid-run, flipped
// bytes.
SelfcheckLines check_store(const std::string& folder);
// Steady and wall clock.
SelfcheckLines check_clocks();
// A short run of the simulated rig over loopback wires, fitted and verified, its store in `folder`. Twice: the same
// seed gives the same content.
SelfcheckLines check_simulated_run(const std::string& folder);

// Names and versions of the libraries in use, as they say themselves.
std::vector<std::pair<std::string, std::string>> library_versions();

}  // namespace tactbench::bench
