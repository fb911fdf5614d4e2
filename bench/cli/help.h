// Layout of --help: verbs in groups, one line each; lines of at most 90 columns; options that are rarely needed only
// with --help-all.
#pragma once

namespace CLI {
class App;
}

namespace tactbench::bench {

void set_help(CLI::App& app);  // before verbs are added, which inherit it

}  // namespace tactbench::bench
