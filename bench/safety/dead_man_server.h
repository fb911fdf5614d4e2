// The dead-man's own process: `tactbench dead-man`, started only by dead_man_process.h. Watches the sequencer's signs
// of life; when they stop, it vents, opens the dump valve, stops the stage, backs z off, proves all this by readings,
// records it on standard error and next to the bench's trip file, and ends.
#pragma once

namespace tactbench::bench {

// Serves on the inherited `socket`. Returns 0 after a goodbye or after making the bench safe and proving it, else 7.
int serve_dead_man(int socket);

}  // namespace tactbench::bench
