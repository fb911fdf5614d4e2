// Checks how an identification rejects invalid input.
#pragma once

#include <stdexcept>
#include <string>

#include "analysis/error.h"

namespace tactbench::analysis {

// The id of the error that ends `work`; empty where it comes to its end. Other exceptions pass.
template <class Work>
std::string id_of_refusal(const Work& work) {
  try {
    (void)work();
  } catch (const AnalysisError& error) {
    return error.id();
  }
  return {};
}

// The message about a wrong argument; empty if `work` ends without an error.
template <class Work>
std::string why_invalid(const Work& work) {
  try {
    (void)work();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

}  // namespace tactbench::analysis
