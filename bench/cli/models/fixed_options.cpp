#include "bench/cli/models/fixed_options.h"

#include <CLI/CLI.hpp>

#include "analysis/error.h"
#include "analysis/scanner_scale.h"
#include "bench/cli/runs/source.h"
#include "db/run_store.h"

namespace tactbench::bench {

void add_device_options(CLI::App& verb, analysis::FixedOptions& options) {
  verb.add_option("--frame-rate", options.frame_rate_hz, "frames per second of the device; not needed for ELAM")
      ->check(CLI::Range(5.0, 10000.0));
  verb.add_option("--per-count", options.per_count,
                  "output (normally volts) of one count of the device's 16-bit converter [that of the run's scanner]")
      ->check(CLI::PositiveNumber);
  verb.add_option("--scans", options.scans, "scans averaged into a count on the device")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  verb.add_option("--noise", options.noise, "least standard deviation of a count, in output units [that of the model]")
      ->check(CLI::PositiveNumber);
}

void add_fixed_options(CLI::App& verb, FixedWords& text) {
  verb.add_option("--as", text.as,
                  "fixed: computes with the integers of a microcontroller (tactbench model export --format c); give "
                  "the same options as for the export")
      ->check(CLI::IsMember({"double", "fixed"}))
      ->capture_default_str();
  add_device_options(verb, text.options);
}

analysis::FixedModel fixed_model(const std::string& name, const analysis::SensorModel& model,
                                 analysis::FixedOptions options, const Session& session) {
  if (options.per_count == 0.0 && is_run_number(name.substr(0, name.find(':')))) try {
      const db::RunStore store = db::RunStore::open_read_only(session.db);
      options.per_count = analysis::volts_per_count(store.run(model.run));
    } catch (const analysis::AnalysisError&) {
      // An imported run: quantised() says what is missing.
    }
  return analysis::quantised(model, options);
}

}  // namespace tactbench::bench
