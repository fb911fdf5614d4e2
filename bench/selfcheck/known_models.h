// The models that selfcheck knows, and how it judges what is made of them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "analysis/identify/fit_data.h"
#include "analysis/models/model.h"
#include "bench/selfcheck/selfcheck.h"

namespace tactbench::bench {

// ELAM, GPI, MPI and POLY.
std::vector<std::unique_ptr<analysis::HysteresisModel>> known_models();
// The model's outputs along the paper's two sequences, and its external loop as patterns.
analysis::FitData data_made_by(const analysis::HysteresisModel& model);

// What of the model is recovered, and within what: see `expected_of_fit`.
SelfcheckAnswer judge_fit(const analysis::HysteresisModel& truth, const analysis::HysteresisModel& fitted);
std::string expected_of_fit(const std::string& model);
// Outputs that can be reached along 200 random histories, inverted and predicted again.
SelfcheckAnswer judge_round_trips(const analysis::HysteresisModel& model);

}  // namespace tactbench::bench
