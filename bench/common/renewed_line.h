// Erases the line of standard error that tty::renew_line() overwrites (for_people.h). tty::print() erases it before it
// writes; a line end alone on standard error leaves it.
#pragma once

namespace tactbench::bench::tty {

void erase_line();

}  // namespace tactbench::bench::tty
