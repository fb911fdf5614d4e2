// What `trend` and `fleet trend` share: their options, and the output of figures and charts.
#pragma once

#include <string>

#include "bench/cli/session.h"

namespace tactbench::bench {

struct TrendOptions {
  std::string sensor, subject, figure, html;
  bool check = false;
};
void add_trend_options(CLI::App& verb, TrendOptions& options, Session& session);

// Prints figures of session.db; sets session.code.
void trend(const TrendOptions& options, Session& session);

}  // namespace tactbench::bench
