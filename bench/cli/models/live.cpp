#include "bench/instruments/live.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/compensate/frame_compensator.h"
#include "analysis/counted.h"
#include "bench/cli/runs/source.h"
#include "bench/common/output_file.h"
#include "bench/common/overrides.h"
#include "bench/common/standard_streams.h"

namespace tactbench::bench {

namespace {

constexpr double kBetweenLines = 0.25;  // seconds

struct LiveVerbOptions {
  std::string bench, model, csv;
  std::vector<std::string> set;
  LiveOptions live;
};

struct Flags {
  int flat = 0, unknown = 0, out_of_range = 0, dead = 0, lost = 0, outside = 0;
};

struct Shown {
  double mean_psi = 0.0, highest_psi = 0.0;  // of the taxels that are not dead
  std::size_t highest = 0;
  Flags flags;
};

Shown summed(const LiveFrame& frame) {
  Shown shown;
  int counted = 0;
  for (std::size_t t = 0; t < frame.status.size(); ++t) {
    const unsigned bits = frame.status[t];
    shown.flags.flat += (bits & analysis::kTaxelFlat) != 0 ? 1 : 0;
    shown.flags.unknown += (bits & analysis::kTaxelUnknown) != 0 ? 1 : 0;
    shown.flags.out_of_range += (bits & analysis::kTaxelOutOfRange) != 0 ? 1 : 0;
    shown.flags.dead += (bits & analysis::kTaxelDead) != 0 ? 1 : 0;
    shown.flags.lost += (bits & analysis::kTaxelLost) != 0 ? 1 : 0;
    shown.flags.outside += (bits & analysis::kTaxelOutside) != 0 ? 1 : 0;
    if ((bits & analysis::kTaxelDead) != 0) continue;
    ++counted;
    const auto psi = static_cast<double>(frame.pressure_psi[t]);
    shown.mean_psi += psi;
    if (counted == 1 || psi > shown.highest_psi) {
      shown.highest_psi = psi;
      shown.highest = t;
    }
  }
  if (counted > 0) shown.mean_psi /= counted;
  return shown;
}

constexpr const char* kFramesHead = "frame,time_s,taxel,pressure_psi,uncertainty_psi,status\n";

class CsvFile {
 public:
  explicit CsvFile(const std::string& path)
      : path_(path), file_(path.empty() ? nullptr : std::fopen(path.c_str(), "w")) {
    if (!path.empty() && !file_) failed();
    if (file_) put(kFramesHead);
  }
  void write(const LiveFrame& frame) {
    if (!file_) return;
    for (std::size_t t = 0; t < frame.status.size(); ++t)
      put(fmt::format("{},{:.6f},{},{:.4f},{:.4f},{}\n", frame.number, frame.time_s, t, frame.pressure_psi[t],
                      frame.uncertainty_psi[t], frame.status[t]));
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
  [[noreturn]] void failed() const {
    throw Error(ExitCode::kUsage, "TB-FILE-WRITE", "cannot write the frames", path_,
                "check folder, space and permissions");
  }
  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
};

void live(const LiveVerbOptions& options, const Session& session) {
  const BenchConfig config = read_bench(find_config(options.bench), split_overrides(options.set).bench);
  const analysis::SensorModel model = load_model(options.model, session);
  if (!options.csv.empty()) check_output(options.csv, kind_of_file(kFramesHead), session.replace);
  CsvFile csv(options.csv);
  const auto columns = static_cast<std::size_t>(model.columns);
  const analysis::PressureUnit unit = session.unit();
  Shown last;
  double next_line = 0.0;
  const LiveSummary summary = live_frames(config, model, options.live, [&](const LiveFrame& frame) {
    csv.write(frame);
    last = summed(frame);
    if (session.json || session.quiet || frame.time_s < next_line) return true;
    next_line = frame.time_s + kBetweenLines;
    tty::print(
        "frame {:>6}  mean {:>6} {}  highest {:>6} {} at {},{}  flat {} unknown {} out of range {} dead {} "
        "lost {}  {:.0f} us\n",
        frame.number, unit.fixed(last.mean_psi, 2), unit.symbol(), unit.fixed(last.highest_psi, 2), unit.symbol(),
        last.highest / columns, last.highest % columns, last.flags.flat, last.flags.unknown, last.flags.out_of_range,
        last.flags.dead, last.flags.lost, frame.latency_us);
    std::fflush(stdout);
    return !output_is_lost() || !options.csv.empty();
  });
  csv.close();
  if (session.json) {
    const Flags& flags = last.flags;
    print_json("live", {{"bench", config.id},
                        {"origin", config.origin == devices::Origin::kSimulated ? "simulated" : "hardware"},
                        {"model", model.source},
                        {"other_scanner", summary.other_scanner},
                        {"outside_validity", summary.outside},
                        {"frames", summary.frames},
                        {"lost_frames", summary.lost},
                        {"latency_us",
                         {{"median", summary.median_us},
                          {"p99", summary.p99_us},
                          {"worst", summary.worst_us},
                          {"compensation_median", summary.compensation_median_us}}},
                        {"last_frame",
                         {{"mean_psi", last.mean_psi},
                          {"highest_psi", last.highest_psi},
                          {"flat", flags.flat},
                          {"unknown", flags.unknown},
                          {"out_of_range", flags.out_of_range},
                          {"dead", flags.dead},
                          {"outside_validity", flags.outside},
                          {"lost", flags.lost}}}});
    return;
  }
  for (const std::string& line : summary.outside)
    tty::print(stderr, "outside the model's validity, all values are flagged: {}\n", line);
  tty::print(
      "{}, {} lost; request to compensated values: median {:.0f} us, p99 {:.0f} us, worst {:.0f} us (of it "
      "the compensation, median {:.1f} us)\n",
      analysis::counted(summary.frames, "frame"), summary.lost, summary.median_us, summary.p99_us, summary.worst_us,
      summary.compensation_median_us);
}

}  // namespace

void add_live(CLI::App& app, Session& session) {
  auto options = std::make_shared<LiveVerbOptions>();
  CLI::App* verb = app.add_subcommand("live", "read the tactile array and print compensated frames until Ctrl-C");
  session.profile.add_bench(*verb, options->bench);
  verb->add_option("--model", options->model, "a .json that fit -o wrote, or RUN or RUN:FIT of the store")->required();
  verb->add_option("--set", options->set, "override table.key=value of the bench file")->take_all();
  verb->add_option("--frames", options->live.frames, "end after so many; 0: at Ctrl-C")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  verb->add_option("--interval", options->live.interval_s, "seconds between two requests")
      ->check(CLI::Range(0.0, 60.0))
      ->capture_default_str();
  verb->add_option("--scans", options->live.scans, "averaged into a frame")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  verb->add_option("--csv", options->csv, "write every frame there: frame,time_s,taxel,pressure,uncertainty,status");
  add_replace(*verb, session);
  add_void_too(*verb, session);
  add_units(*verb, session);
  add_common(*verb, session);
  verb->callback([options, &session] { live(*options, session); });
}

}  // namespace tactbench::bench
