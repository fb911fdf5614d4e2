#include <CLI/CLI.hpp>
#include <memory>

#include "bench/cli/session.h"
#include "bench/safety/dead_man_server.h"

namespace tactbench::bench {

void add_dead_man(CLI::App& app, Session& session) {
  auto socket = std::make_shared<int>(-1);
  CLI::App* verb = app.add_subcommand("dead-man", "internal: started by the sequencer, not by users");
  verb->group("");
  verb->add_option("--socket", *socket)->required();
  verb->callback([socket, &session] { session.code = static_cast<ExitCode>(serve_dead_man(*socket)); });
}

}  // namespace tactbench::bench
