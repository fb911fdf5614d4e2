// Standard output and error of a program that drives devices: a terminal may be closed and a reader may go while a
// chamber is under pressure. Words are then lost, and nothing else.
#pragma once

namespace tactbench::bench {

// Descriptors 0 to 2 are open from now on: a file opened later would take the place of a closed one, and be written to.
void keep_standard_files();

// From now on what cannot be written to stdout and stderr is dropped: no signal comes, no write fails. stderr never
// waits long for a reader that stands still. For the rest of the program.
void outlive_readers();

// Something was dropped from stdout since outlive_readers().
[[nodiscard]] bool output_is_lost();

}  // namespace tactbench::bench
