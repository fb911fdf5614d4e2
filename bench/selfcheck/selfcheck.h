// Validation of the installed program on this machine: each check runs the code that users run on a problem with a
// known answer and reports what it expected and what it found.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tactbench::bench {

struct SelfcheckLine {
  std::string area;  // model, run
  std::string what, expected, found;
  bool pass = false;  // a check that throws has failed; its finding is the exception's text
};
using SelfcheckLines = std::vector<SelfcheckLine>;

// Models of known parameters: their outputs (KnownModel of analysis/identify/fit_models.h); the inverse; and a fit to
// such outputs along both sequences of Table 1, which gives them again.
SelfcheckLines check_models();
// A short run of the simulated rig over loopback wires, its store in `folder`, which exists; fitted and verified from
// its raw frames; and again: the same seed gives the same content.
SelfcheckLines check_run(const std::string& folder);

// Names and versions of the libraries in use, as they say themselves, by name.
std::vector<std::pair<std::string, std::string>> library_versions();

}  // namespace tactbench::bench
