// A disk on which no write succeeds, for every SQLite connection of this process: the system calls of SQLite's own file
// system layer are replaced, so that its real answers to ENOSPC and EROFS are met. Works for root too.
#pragma once

namespace tactbench::tests {

// errno of every write from now on; 0: the disk is well again.
void disk_fails_with(int error);

}  // namespace tactbench::tests
