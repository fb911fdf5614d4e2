// The line of standard error that tty::renew_line() writes over (for_people.h). What tty::print() writes erases it
// first; a line end alone on standard error leaves it.
#pragma once

namespace tactbench::bench::tty {

void erase_line();

}  // namespace tactbench::bench::tty
