// The switch of a mutant: on in a process whose environment names it in TACTBENCH_MUTANT. Included by the copies of
// sources that mutants.cmake makes, and by nothing that ships.
#pragma once

#include <cstdlib>
#include <cstring>

namespace tactbench::tests {

inline bool mutant_chosen(const char* name) {
  const char* chosen = std::getenv("TACTBENCH_MUTANT");
  return chosen != nullptr && std::strcmp(chosen, name) == 0;
}

}  // namespace tactbench::tests

// Asked once a place: inner loops stay as fast as they are.
#define TACTBENCH_MUTANT(name)                                                       \
  ([] {                                                                              \
    static const bool tactbench_mutant_on = ::tactbench::tests::mutant_chosen(name); \
    return tactbench_mutant_on;                                                      \
  }())
