// Reports the dead-man's state while an actuator is held: to the record and to people.
#pragma once

namespace tactbench::bench {

class Progress;
class Recorder;
class Rig;

// Reports what came since the last call: an event of kind "dead-man" and a note each. Nothing without a dead-man.
void record_dead_man_news(Rig& rig, Recorder& recorder, Progress& progress);
// The same for verbs that keep no record: one line each on standard error.
void tell_dead_man_news(Rig& rig);
// Throws Fault TB-DEADMAN-SILENT, TB-DEADMAN-ENDED, TB-DEADMAN-BLIND when it no longer watches.
void check_dead_man(Rig& rig);

}  // namespace tactbench::bench
