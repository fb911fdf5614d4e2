#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench/cli/models/live_words.h"
#include "bench/cli/runs/source.h"
#include "bench/common/output_file.h"
#include "bench/common/overrides.h"
#include "bench/common/standard_streams.h"
#include "bench/instruments/watch.h"

namespace tactbench::bench {

namespace {

constexpr double kBetweenLines = 0.25;  // seconds

struct LiveVerbOptions {
  std::string model, csv;
  std::string as = "double";
  std::vector<std::string> set;
  LiveOptions live;
  std::optional<double> interval_s;
};

class CsvFile {
 public:
  explicit CsvFile(const std::string& path)
      : path_(path), file_(path.empty() ? nullptr : std::fopen(path.c_str(), "w")) {
    if (!path.empty() && !file_) failed();
    if (file_) put(kFramesHead);
  }
  void write(const LiveFrame& frame) {
    if (file_) put(frame_rows(frame));
  }
  void close() {
    if (file_ && std::fflush(file_.get()) != 0) failed();
  }

 private:
  struct Close {
    void operator()(std::FILE* file) const { (void)std::fclose(file); }
  };
  void put(const std::string& line) {
    if (std::fputs(line.c_str(), file_.get()) < 0) failed();
  }
  [[noreturn]] void failed() const { throw Error("TB-FILE-WRITE", "cannot write the frames", path_); }
  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
};

void live(const LiveVerbOptions& options, const Session& session) {
  const BenchConfig config = read_bench(find_config(session.bench_file()), split_overrides(options.set).bench);
  if (options.model.empty() && session.json)
    throw Error("TB-USAGE", "the instruments' values are not printed as JSON", "--json",
                "leave it out, or name a model: --model RUN; or devices check --json");
  if (options.model.empty())
    return watch_devices(config, {.interval_s = options.interval_s.value_or(WatchOptions().interval_s),
                                  .count = options.live.frames,
                                  .terminal = ::isatty(STDOUT_FILENO) != 0,
                                  .unit = session.unit()});
  const analysis::SensorModel model = load_model(options.model, session);
  if (!options.csv.empty()) check_output(options.csv, kind_of_file(kFramesHead), session.replace);
  CsvFile csv(options.csv);
  const auto columns = static_cast<std::size_t>(model.columns);
  const analysis::PressureUnit unit = session.unit();
  SummedFrame last;
  double next_line = 0.0;
  const LiveSummary summary = live_frames(config, model, options.live, [&](const LiveFrame& frame) {
    csv.write(frame);
    last = summed(frame);
    if (session.json || session.quiet || frame.time_s < next_line) return true;
    next_line = frame.time_s + kBetweenLines;
    tty::print("{}", frame_line(frame, last, columns, unit));
    std::fflush(stdout);
    return !output_is_lost() || !options.csv.empty();
  });
  csv.close();
  if (session.json) {
    nlohmann::ordered_json json = {{"bench", config.id},
                                   {"origin", config.origin == devices::Origin::kSimulated ? "simulated" : "hardware"},
                                   {"model", model.source}};
    json.update(live_json(summary, last));
    print_json("live", json);
    return;
  }
  for (const std::string& line : summary.outside)
    tty::print(stderr, "outside the model's validity, all values are flagged: {}\n", line);
  tty::print("{}", summary_line(summary));
}

}  // namespace

void add_live(CLI::App& app, Session& session) {
  auto options = std::make_shared<LiveVerbOptions>();
  CLI::App* verb = app.add_subcommand("live", "the instruments' values; with --model compensated frames of the array");
  verb->add_option("--model", options->model, "a .json that fit -o wrote, or RUN or RUN:FIT of the store");
  verb->add_option("--set", options->set, "override table.key=value of the bench file")->take_all();
  verb->add_option("--frames", options->live.frames, "end after so many; 0: at Ctrl-C")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  verb->add_option("--interval", options->interval_s,
                   "seconds between two readings [0.01 of frames, 0.5 of instruments]")
      ->check(CLI::Range(0.0, 60.0));
  verb->add_option("--scans", options->live.scans, "averaged into a frame")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  verb->add_option("--csv", options->csv, "write every frame there: frame,time_s,taxel,pressure,uncertainty,status");
  verb->add_option("--as", options->as,
                   "fixed: by the integers of a microcontroller, at this pace, without uncertainty")
      ->check(CLI::IsMember({"double", "fixed"}))
      ->capture_default_str();
  add_replace(*verb, session);
  add_void_too(*verb, session);
  verb->footer("Read-only, until Ctrl-C.");
  verb->callback([options, &session] {
    options->live.interval_s = options->interval_s.value_or(options->live.interval_s);
    if (options->as == "fixed") options->live.fixed.emplace();
    live(*options, session);
  });
}

}  // namespace tactbench::bench
