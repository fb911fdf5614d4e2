#include "tests/bench/cli/verb_here.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>

namespace tactbench::tests {

Finished verb_here(AddVerb add, std::vector<std::string> words) {
  bench::Session session;
  CLI::App app("of a test", "tactbench");
  app.require_subcommand(1);
  bench::add_global_options(app, session);
  add(app, session);
  std::ranges::reverse(words);
  Finished finished;
  Captured out(stdout), err(stderr);
  std::string error;
  try {
    app.parse(words);
    finished.code = static_cast<int>(session.code);
  } catch (const CLI::ParseError& refused) {
    finished.code = static_cast<int>(bench::ExitCode::kUsage);
    error = std::string("parse: ") + refused.what() + "\n";
  } catch (...) {
    const bench::Error thrown = bench::as_error(std::current_exception());
    finished.code = static_cast<int>(thrown.code());
    error = bench::error_text(thrown, false);
  }
  finished.out = out.text();
  finished.err = err.text() + error;
  return finished;
}

}  // namespace tactbench::tests
