// What the dead-man says of itself while an actuator is held, for the record and for people.
#pragma once

namespace tactbench::bench {

class Progress;
class Recorder;
class Rig;

// What came since the last call: events of kind "dead-man", and a note each. Nothing where there is no dead-man.
void record_dead_man_news(Rig& rig, Recorder& recorder, Progress& progress);
// The same for commands that keep no record: a line each on standard error.
void tell_dead_man_news(Rig& rig);
// Throws Interlock TB-DEADMAN-SILENT, TB-DEADMAN-ENDED, TB-DEADMAN-BLIND when nothing may be held without it any more.
void check_dead_man(Rig& rig);

}  // namespace tactbench::bench
