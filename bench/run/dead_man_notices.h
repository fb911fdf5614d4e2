// Reports notices of the dead-man and of busy modules to the run's record and to the operator.
#pragma once

namespace tactbench::bench {

class Progress;
class Recorder;
class Rig;

// Reports the notices since the last call: for the dead-man an event of kind "dead-man" and a printed note each, for a
// busy module an event of kind "warning" (TB-MODBUS-BUSY).
void record_notices(Rig& rig, Recorder& recorder, Progress& progress);
// Prints the dead-man's notices, for verbs without a run record: one line each on standard error.
void print_dead_man_notices(Rig& rig);
// Throws Fault TB-DEADMAN-SILENT, TB-DEADMAN-ENDED, TB-DEADMAN-BLIND when it no longer watches.
void check_dead_man(Rig& rig);

}  // namespace tactbench::bench
