// Validation of the installed program on this machine: each check runs the product's code on a problem with a known
// answer and reports the expected and the actual result.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tactbench::bench {

struct SelfcheckLine {
  std::string area;  // model, run
  std::string what, expected, found;
  bool pass = false;  // false also if the check throws; its finding is then the exception's text
};
using SelfcheckLines = std::vector<SelfcheckLine>;

// Models of known parameters: their outputs (KnownModel of analysis/identify/fit_models.h); the inverse; and a fit to
// such outputs along both sequences of Table 1, which gives them again.
SelfcheckLines check_models();
// A short run of the simulated rig over loopback connections, stored in the existing `folder`, fitted, and verified
// from its raw frames; then repeated: the same seed must give the same content.
SelfcheckLines check_run(const std::string& folder);

// Names and versions of the libraries in use, as the libraries report them, sorted by name.
std::vector<std::pair<std::string, std::string>> library_versions();

}  // namespace tactbench::bench
