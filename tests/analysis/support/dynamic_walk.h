// Runs of the dynamic model's class by its formulas (analysis/models/dynamics.h), whose outputs are straight lines of
// the pressure that has arrived: what identification makes of them can be told exactly.
#pragma once

#include <string>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/dynamic/dynamics_search.h"
#include "analysis/models/dynamics.h"

namespace synthetic {

using namespace tactbench::analysis;

// A taxel: zero + volts_per_psi x what has arrived x the creep's factor.
struct WalkedTaxel {
  double zero = 0.0, volts_per_psi = 0.1, creep_scale = 1.0, lag_share = 0.0;
};

struct WalkedRepeat {
  std::vector<double> psi;
  double seconds = 1.0;   // at each level
  double worked_s = 0.0;  // conditioning before its first level
  double off = 0.0;       // of the reference from the set-point
};

struct WalkedSequence {
  std::string name;
  std::vector<WalkedRepeat> repeats;
};

// Neither creep nor lag is known yet.
inline ArrayDynamics nothing_known(std::size_t taxels) {
  ArrayDynamics none;
  none.creep_scale.assign(taxels, 1.0);
  none.lag_share.assign(taxels, 0.0);
  return none;
}

inline Dataset walked_run(const Dynamics& d, const std::vector<WalkedTaxel>& taxels,
                          const std::vector<WalkedSequence>& sequences, double span) {
  Dataset data;
  data.run = 1;
  data.origin = "simulated";
  data.rows = 1;
  data.columns = static_cast<int>(taxels.size());
  data.noise_v.assign(taxels.size(), 0.001);
  data.at_limit.assign(taxels.size(), false);
  DynamicsState state;
  double now = 0.0;
  for (const WalkedSequence& sequence : sequences) {
    SequenceData& own = data.sequences.emplace_back(SequenceData{sequence.name, {}});
    for (const WalkedRepeat& walked : sequence.repeats) {
      Repeat& repeat = own.repeats.emplace_back();
      for (std::size_t i = 0; i < walked.psi.size(); ++i) {
        if (i == 0 && walked.worked_s > 0.0) {
          now += walked.worked_s;
          work_unseen(d, state, walked.worked_s, span);
        }
        now += walked.seconds;
        const DynamicsStep step(d, walked.seconds);
        const double psi = walked.psi[i] + walked.off;
        repeat.steps.push_back({walked.psi[i], psi, now, walked.seconds});
        for (const WalkedTaxel& taxel : taxels)
          repeat.volts.push_back(taxel.zero + taxel.volts_per_psi * arrived(taxel.lag_share, state, step, psi) *
                                                  creep_factor(d, state, step, psi, taxel.creep_scale));
        advance(d, state, step, psi);
      }
    }
  }
  return data;
}

}  // namespace synthetic
