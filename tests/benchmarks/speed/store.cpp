// The run store beside a plain file and bare SQLite, and the report beside writing its bytes. Files lie where temporary
// files do: TMPDIR chooses the disk.
#include <benchmark/benchmark.h>
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <fstream>
#include <system_error>

#include "analysis/report/gather.h"
#include "bench/common/private_files.h"
#include "db/run_store.h"
#include "db/sqlite.h"
#include "tests/benchmarks/speed/ratios.h"
#include "tests/benchmarks/speed/synthetic_array.h"

namespace tactbench::speed {
namespace {

constexpr int kFrames = 3310, kDurable = 1000;  // durable: those that wait for the disk, one by one

db::FrameRecord frame_number(std::size_t i) {
  db::FrameRecord frame;
  frame.rows = frame.columns = 16;
  frame.scans = 1;
  frame.ordinal = static_cast<int>(i);
  frame.setpoint_psi = frame.feedback_psi = frame.reference_psi = 1e-3 * static_cast<double>(i);
  frame.time_ns = static_cast<std::int64_t>(i) * 2'000'000'000;
  for (std::size_t t = 0; t < 256; ++t) frame.counts.push_back(static_cast<std::uint16_t>(i * 7 + t * 251));
  return frame;
}

// An iteration appends one frame; `append` takes it.
template <class Append>
void for_each_frame(benchmark::State& state, Append append) {
  std::vector<db::FrameRecord> frames;
  for (std::size_t i = 0; i < static_cast<std::size_t>(state.max_iterations); ++i) frames.push_back(frame_number(i));
  auto frame = frames.begin();
  for (auto _ : state) append(*frame++);
}

struct OpenRun {
  bench::ScratchFolder folder{"tactbench-speed"};
  db::RunStore store;
  std::int64_t run = 0, branch = 0;
  explicit OpenRun(db::Durability durability) : store(db::RunStore::open(folder.path() + "/runs.db", durability)) {
    store.add_sensor({"B-1", "synthetic", "", db::sha256_hex(""), "SIM-SCANNER-1", "", ""});
    db::RunRecord record;
    record.uuid = db::new_uuid();
    record.origin = "simulated";
    record.state = "prepared";
    record.sensor_serial = "B-1";
    record.sequences = {{0, "frames", "", "", 1, kFrames}};
    run = store.begin_run(record);
    branch = store.begin_branch(run, {});
  }
  void append(db::FrameRecord& frame) {
    frame.branch = branch;
    store.append_frame(run, frame);
  }
};

void stored(benchmark::State& state, db::Durability durability) {
  OpenRun open(durability);
  for_each_frame(state, [&](db::FrameRecord& frame) { open.append(frame); });
}

void append_and_fdatasync(benchmark::State& state) {
  const bench::ScratchFolder folder("tactbench-speed");
  const int file = ::open((folder.path() + "/plain").c_str(), O_CREAT | O_WRONLY | O_APPEND | O_CLOEXEC, 0600);
  if (file < 0) throw std::system_error(errno, std::generic_category(), folder.path());
  std::array<std::byte, 512 + 32> bytes{};  // a frame and its numbers
  for_each_frame(state, [&](const db::FrameRecord& frame) {
    std::memcpy(bytes.data(), frame.counts.data(), 512);
    if (::write(file, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()) || ::fdatasync(file) != 0)
      state.SkipWithError("append");
  });
  ::close(file);
}

// A prepared INSERT and nothing else, with the pragmas of the run store: no hash chain, checks or references.
struct BareTable {
  bench::ScratchFolder folder{"tactbench-speed"};
  db::sqlite::Connection connection{folder.path() + "/bare.db", db::sqlite::Access::kReadWrite};
  std::int64_t key = 0;
  BareTable() {
    connection.execute(
        "PRAGMA page_size = 4096; PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL; "
        "CREATE TABLE frames (frame INTEGER PRIMARY KEY, branch, ordinal, setpoint_psi, feedback_psi, reference_psi, "
        "setpoint_counts, feedback_counts, reference_counts, time_ns, since_command_ns, in_band_ns, device_time_us, "
        "status, exchanges, \"rows\", columns, scans, counts)");
  }
  auto append() {
    return
        [this, insert = std::make_shared<db::sqlite::Statement>(
                   connection, "INSERT INTO frames VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)")](
            const db::FrameRecord& f) {
          insert
              ->bind(++key, f.branch, f.ordinal, f.setpoint_psi, f.feedback_psi, f.reference_psi, f.setpoint_counts,
                     f.feedback_counts, f.reference_counts, f.time_ns, f.since_command_ns, f.in_band_ns,
                     f.device_time_us, f.status, f.exchanges, f.rows, f.columns, f.scans, f.counts)
              .run();
        };
  }
};

void bare_insert(benchmark::State& state) {
  BareTable table;
  for_each_frame(state, table.append());
}

void bare_read(benchmark::State& state) {
  BareTable table;
  const auto append = table.append();
  for (int i = 0; i < kFrames; ++i) append(frame_number(static_cast<std::size_t>(i)));
  for (auto _ : state) {
    db::sqlite::Statement rows(table.connection, "SELECT * FROM frames WHERE frame > 0 ORDER BY frame");
    std::vector<db::FrameRecord> frames;
    std::int64_t key = 0;
    db::FrameRecord f;
    while (rows.step()) {
      rows.read(key, f.branch, f.ordinal, f.setpoint_psi, f.feedback_psi, f.reference_psi, f.setpoint_counts,
                f.feedback_counts, f.reference_counts, f.time_ns, f.since_command_ns, f.in_band_ns, f.device_time_us,
                f.status, f.exchanges, f.rows, f.columns, f.scans, f.counts);
      frames.push_back(f);
    }
    benchmark::DoNotOptimize(frames.data());
  }
  state.SetItemsProcessed(state.iterations() * kFrames);
}

void read(benchmark::State& state) {
  OpenRun open(db::Durability::kNormal);
  for (int i = 0; i < kFrames; ++i) {
    db::FrameRecord frame = frame_number(static_cast<std::size_t>(i));
    open.append(frame);
  }
  for (auto _ : state) benchmark::DoNotOptimize(open.store.frames(open.run).size());
  state.SetItemsProcessed(state.iterations() * kFrames);
}

BENCHMARK(append_and_fdatasync)->Name("store/append_and_fdatasync")->Iterations(kDurable)->UseRealTime();
BENCHMARK_CAPTURE(stored, full, db::Durability::kFull)
    ->Name("store/append_durable")
    ->Iterations(kDurable)
    ->UseRealTime();
BENCHMARK(bare_insert)->Name("store/bare_insert")->Iterations(kFrames)->UseRealTime();
BENCHMARK_CAPTURE(stored, normal, db::Durability::kNormal)
    ->Name("store/append_normal")
    ->Iterations(kFrames)
    ->UseRealTime();
BENCHMARK(bare_read)->Name("store/bare_read");
BENCHMARK(read)->Name("store/read");

// The report of both sequences of an array with its own fit. Fit and comparison come before: rendering alone counts.
struct Rendered {
  bench::ScratchFolder folder{"tactbench-speed"};
  analysis::ReportInput input;
  std::string bytes;
  Rendered() {
    const analysis::Dataset dataset = synthetic_dataset(16, 16, 5);
    db::RunStore store = db::RunStore::open(folder.path() + "/report.db", db::Durability::kNormal);
    const std::int64_t run = store_run(store, dataset);
    input.fit = analysis::fit_array(dataset);
    input.evaluation = analysis::evaluate(dataset, input.fit);
    analysis::Runs runs(store);
    analysis::gather_run(input, runs, run);
    input.uncertainty = analysis::assess_uncertainty(dataset, input.fit, input.run);
    bytes = analysis::render_report(input).html;
  }
  void write(const std::string& html) const {
    std::ofstream(folder.path() + "/report.html", std::ios::binary)
        .write(html.data(), static_cast<std::streamsize>(html.size()));
  }
};
const Rendered& rendered() {
  static const Rendered made;
  return made;
}

void write_alone(benchmark::State& state) {
  (void)rendered();
  for (auto _ : state) rendered().write(rendered().bytes);
  state.counters["size [MB]"] = 1e-6 * static_cast<double>(rendered().bytes.size());
}
void rendered_and_written(benchmark::State& state) {
  (void)rendered();
  for (auto _ : state) rendered().write(analysis::render_report(rendered().input).html);
}
BENCHMARK(write_alone)->Name("report/write_only")->Unit(benchmark::kMillisecond);
BENCHMARK(rendered_and_written)->Name("report/render_and_write")->Unit(benchmark::kMillisecond);

const bool declared =
    declare({{"store_append_durable_over_fdatasync", "store/append_durable", {"store/append_and_fdatasync"}, 1.5},
             {"store_append_normal_over_bare", "store/append_normal", {"store/bare_insert"}, 1.25},
             {"store_read_over_bare", "store/read", {"store/bare_read"}, 1.3},
             {"report_over_write_only", "report/render_and_write", {"report/write_only"}, 20.0}});

}  // namespace
}  // namespace tactbench::speed
