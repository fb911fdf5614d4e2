// Standard output and error of a program that drives devices: when a terminal is closed or a reader ends while the
// chamber is under pressure, only text is lost.
#pragma once

namespace tactbench::bench {

// Opens descriptors 0 to 2 if they are closed: otherwise a file opened later would take their number and receive the
// output.
void open_standard_descriptors();

// From now on output that cannot be written to stdout or stderr is dropped without a signal or an error; stderr does
// not wait long for a stopped reader. Holds for the rest of the program.
void drop_unwritable_output();

// Whether stdout has lost output since drop_unwritable_output().
[[nodiscard]] bool output_is_lost();

}  // namespace tactbench::bench
