// Reports what the dead-man and busy modules signalled while an actuator is held: to the run's record and to people.
#pragma once

namespace tactbench::bench {

class Progress;
class Recorder;
class Rig;

// Reports what came since the last call: of the dead-man an event of kind "dead-man" and a note each, of a module that
// was busy one of kind "warning" (TB-MODBUS-BUSY).
void record_notices(Rig& rig, Recorder& recorder, Progress& progress);
// The dead-man's for verbs that keep no record: one line each on standard error.
void print_dead_man_notices(Rig& rig);
// Throws Fault TB-DEADMAN-SILENT, TB-DEADMAN-ENDED, TB-DEADMAN-BLIND when it no longer watches.
void check_dead_man(Rig& rig);

}  // namespace tactbench::bench
