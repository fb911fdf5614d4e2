#include "bench/cli/models/live.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/compensate/compensator.h"
#include "analysis/counted.h"
#include "analysis/json_fields.h"
#include "bench/cli/runs/source.h"
#include "bench/common/output_file.h"
#include "bench/common/overrides.h"
#include "bench/common/standard_streams.h"
#include "bench/instruments/live.h"

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

std::string frame_line(const LiveFrame& frame, const FrameSummary& sum, std::size_t columns,
                       analysis::PressureUnit unit) {
  const TaxelFlags& flags = sum.flags;
  return fmt::format(
      "frame {:>6}  mean {:>6} {}  highest {:>6} {} at {},{}  flat {} unknown {} out of range {} dead {} "
      "lost {}  {:.0f} us\n",
      frame.number, unit.fixed(sum.mean_psi, 2), unit.symbol(), unit.fixed(sum.highest_psi, 2), unit.symbol(),
      sum.highest / columns, sum.highest % columns, flags.flat, flags.unknown, flags.out_of_range, flags.dead,
      flags.lost, frame.latency_us);
}

// Both end with a line break.
std::string summary_line(const LiveSummary& summary) {
  return fmt::format(
      "{}, {} lost; request to compensated values: median {:.0f} us, p99 {:.0f} us, worst {:.0f} us (of it "
      "the compensation, median {:.1f} us)\n",
      analysis::counted(summary.frames, "frame"), summary.lost, summary.median_us, summary.p99_us, summary.worst_us,
      summary.compensation_median_us);
}

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
  FrameSummary last;
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
  CLI::App* verb =
      app.add_subcommand("live", "show the instruments' values; with --model compensated frames of the array");
  verb->add_option("--model", options->model, "a .json that fit -o wrote, or RUN or RUN:FIT of the store");
  verb->add_option("--set", options->set, "override table.key=value of the bench file")->take_all();
  verb->add_option("--frames", options->live.frames, "end after so many frames; 0: at Ctrl-C")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  verb->add_option("--interval", options->interval_s,
                   "seconds between two readings [0.01 of frames, 0.5 of instruments]")
      ->check(CLI::Range(0.0, 60.0));
  verb->add_option("--scans", options->live.scans, "scans averaged into a frame")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  verb->add_option("--csv", options->csv,
                   "write every frame to this file: frame,time_s,taxel,pressure,uncertainty,status");
  verb->add_option("--as", options->as,
                   "fixed: computes with the integers of a microcontroller, at this rate, without uncertainty")
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

FrameSummary summed(const LiveFrame& frame) {
  FrameSummary sum;
  int counted = 0;
  for (std::size_t t = 0; t < frame.status.size(); ++t) {
    const unsigned bits = frame.status[t];
    sum.flags.flat += (bits & analysis::kTaxelFlat) != 0 ? 1 : 0;
    sum.flags.unknown += (bits & analysis::kTaxelUnknown) != 0 ? 1 : 0;
    sum.flags.out_of_range += (bits & analysis::kTaxelOutOfRange) != 0 ? 1 : 0;
    sum.flags.dead += (bits & analysis::kTaxelDead) != 0 ? 1 : 0;
    sum.flags.lost += (bits & analysis::kTaxelLost) != 0 ? 1 : 0;
    sum.flags.outside += (bits & analysis::kTaxelOutside) != 0 ? 1 : 0;
    if ((bits & analysis::kTaxelDead) != 0) continue;
    ++counted;
    const auto psi = static_cast<double>(frame.pressure_psi[t]);
    sum.mean_psi += psi;
    if (counted == 1 || psi > sum.highest_psi) {
      sum.highest_psi = psi;
      sum.highest = t;
    }
  }
  if (counted > 0) sum.mean_psi /= counted;
  return sum;
}

std::string frame_rows(const LiveFrame& frame) {
  std::string rows;
  for (std::size_t t = 0; t < frame.status.size(); ++t)
    rows += fmt::format("{},{:.6f},{},{:.4f},{:.4f},{}\n", frame.number, frame.time_s, t, frame.pressure_psi[t],
                        frame.uncertainty_psi[t], frame.status[t]);
  return rows;
}

nlohmann::ordered_json live_json(const LiveSummary& summary, const FrameSummary& last) {
  const TaxelFlags& flags = last.flags;
  return {{"other_scanner", summary.other_scanner},
          {"outside_validity", summary.outside},
          {"frames", summary.frames},
          {"lost_frames", summary.lost},
          {"latency_us",
           {{"median", summary.median_us},
            {"p99", summary.p99_us},
            {"worst", summary.worst_us},
            {"compensation_median", summary.compensation_median_us}}},
          {"last_frame",
           {JSON_FIELDS(last, mean_psi, highest_psi),
            JSON_FIELDS(flags, flat, unknown, out_of_range, dead),
            {"outside_validity", flags.outside},
            {"lost", flags.lost}}}};
}

}  // namespace tactbench::bench
