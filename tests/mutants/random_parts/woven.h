// The choice between a source and its mutant while a program runs (weave.py). Included by woven copies of sources
// alone.
#pragma once

namespace tactbench::mutants {

struct Control {
  int chosen;                            // number of the mutant; 0: none
  unsigned char reached[(1 << 16) - 4];  // by number: whether its place was reached; whoever reads it sets it back
};

// Shared by all processes of one run of tests: the file that woven_control.cpp was compiled with.
extern Control* control;
Control* open_control();

inline bool on(int number) {
  Control* const shared = control != nullptr ? control : open_control();
  shared->reached[number] = 1;
  return shared->chosen == number;
}

}  // namespace tactbench::mutants
