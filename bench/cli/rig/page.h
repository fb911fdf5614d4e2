// The verb `page`, and the same page started in a background process next to a run or a demonstration.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace tactbench::bench {

struct Session;

void add_page(CLI::App& app, Session& session);

// Starts the page in a process of its own, which prints its address on standard error, survives Ctrl-C in this
// terminal, and ends by itself once this process has ended and nobody views the page any more. To be called before a
// device is opened. Throws std::system_error when no process can be made.
void start_background_page(const std::string& db, const std::string& bench_id, const std::string& operator_name);

}  // namespace tactbench::bench
