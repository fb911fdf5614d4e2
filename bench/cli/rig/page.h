// The page of the verb `page`, started in a background process next to a run or a demonstration.
#pragma once

#include <string>

namespace tactbench::bench {

// Starts the page in a process of its own, which prints its address on standard error, survives Ctrl-C in this
// terminal, and ends by itself once this process has ended and nobody views the page any more. To be called before a
// device is opened. Throws std::system_error when no process can be made.
void start_background_page(const std::string& db, const std::string& bench_id, const std::string& operator_name);

}  // namespace tactbench::bench
