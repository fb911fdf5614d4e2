// The options of `nightly`.
#pragma once

#include <string>

#include "bench/cli/night/night_results.h"

namespace tactbench::bench {

struct NightlyOptions {
  std::string suite, stores, result, shard, copy;
  NightFiles files;
  Selection selection;
  int jobs = 2;
  double limit_s = 300.0;
  bool list = false, stop_on_red = false, keeps = false;  // keeps: --db was given
};

void add_nightly_options(CLI::App& verb, NightlyOptions& options, Session& session);

}  // namespace tactbench::bench
