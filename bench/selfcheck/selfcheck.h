// Validation of the installed program on this machine: each check runs the code that users run on a problem with a
// known answer and reports what it expected and what it found.
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
// A check that throws has failed; its finding is the exception's text.
SelfcheckLine selfchecked(const std::string& area, const std::string& what, const std::string& expected,
                          const std::function<SelfcheckAnswer()>& check);

// ELAM, GPI, MPI and POLY, each fitted to noise-free data of a known model of its kind: the fit recovers the model.
SelfcheckLines check_known_fits();
// direct(inverse(y)) = y along random histories, 1e-9 of the output's span (analysis/models/model.h).
SelfcheckLines check_round_trips();
// The same bits on every vector level of this machine.
SelfcheckLines check_dispatch_levels();
// The streaming compensator recovers the pressures from which the direct formula computed its outputs.
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
