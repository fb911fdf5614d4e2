// The limits that an evaluation is judged by, as read from a limits file.
#pragma once

#include <string>
#include <vector>

namespace tactbench::analysis {

// figure.h defines each rule.
enum class DecisionRule { kDefault, kSimple, kGuarded, kFourWay, kReportOnly };
struct Limits {
  std::string name;
  DecisionRule rule = DecisionRule::kDefault;  // default: four-way where U is known, simple where it is not
  double mean_compensation_error_psi = 0.0;    // all fitted taxels and frames
  double worst_taxel_error_psi = 0.0;          // the worst taxel's mean error
  double distance_of_mean_fs = 0.0;            // comp_distance_of_mean
  double unfit_taxels = 0.0;                   // dead, stuck, saturated or unfit taxels allowed
  struct Mismatch {
    double pressure_psi = 0.0;
    double std_fs = 0.0;  // compensated std/FS up and down
  };
  std::vector<Mismatch> mismatch;
  // Maximum permissible error of a reading, over a span of pressures or at one level.
  struct Mpe {
    double low_psi = 0.0, high_psi = 0.0;
    double mpe_psi = 0.0;
    double share = 0.95;  // of the fitted taxels that |error| + U of each must lie within
  };
  std::vector<Mpe> mpe;
  std::string toml, sha256;  // the file, stored with the verdicts
};

}  // namespace tactbench::analysis
