// The dead-man's own process: `tactbench dead-man`, started by dead_man_process.h and by nobody else. Watches the
// sequencer's signs of life; when they end it vents, opens the dump valve, stops the stage, backs z off, proves it by
// reading, writes what it did to standard error and beside the bench's trip file, and ends.
#pragma once

namespace tactbench::bench {

// Serves on the inherited `socket`. 0: a goodbye came; otherwise 7 unless it made safe and proved it (then 0).
int serve_dead_man(int socket);

}  // namespace tactbench::bench
