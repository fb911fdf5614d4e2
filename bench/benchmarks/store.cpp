#include "bench/benchmarks/store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <system_error>

#include "bench/benchmarks/synthetic_array.h"
#include "db/sqlite.h"

namespace tactbench::bench {

namespace {

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

std::vector<db::FrameRecord> frames_of(std::size_t count) {
  std::vector<db::FrameRecord> frames;
  for (std::size_t i = 0; i < count; ++i) frames.push_back(frame_number(i));
  return frames;
}
using Frames = std::span<db::FrameRecord>;

// A run that takes frames, ready for the first.
class OpenRun {
 public:
  OpenRun(const std::string& path, db::Durability durability, std::size_t frames)
      : store_(db::RunStore::open(path, durability)) {
    store_.add_sensor({"B-1", "synthetic", "", db::sha256_hex(""), "SIM-SCANNER-1", "", ""});
    db::RunRecord run;
    run.uuid = db::new_uuid();
    run.origin = "simulated";
    run.state = "prepared";
    run.sensor_serial = "B-1";
    run.sequences = {{0, "frames", "", "", 1, static_cast<int>(frames)}};
    run_ = store_.begin_run(run);
    branch_ = store_.begin_branch(run_, {});
  }
  void append(Frames frames) {
    for (db::FrameRecord& frame : frames) {
      frame.branch = branch_;
      store_.append_frame(run_, frame);
    }
  }
  [[nodiscard]] std::vector<db::FrameRecord> read() const { return store_.frames(run_); }

 private:
  db::RunStore store_;
  std::int64_t run_ = 0, branch_ = 0;
};

class PlainFile {
 public:
  explicit PlainFile(const std::string& path)
      : descriptor_(::open(path.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_APPEND | O_CLOEXEC, 0600)) {
    if (descriptor_ < 0) throw std::system_error(errno, std::generic_category(), path);
  }
  ~PlainFile() { ::close(descriptor_); }
  PlainFile(const PlainFile&) = delete;
  PlainFile& operator=(const PlainFile&) = delete;
  void append(Frames frames) const {
    std::array<std::byte, 512 + 32> bytes{};  // a frame and its numbers
    for (const db::FrameRecord& frame : frames) {
      std::memcpy(bytes.data(), frame.counts.data(), 512);
      if (::write(descriptor_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()) ||
          ::fdatasync(descriptor_) != 0)
        throw std::system_error(errno, std::generic_category(), "append");
    }
  }

 private:
  int descriptor_;
};

// A prepared INSERT and nothing else, with the pragmas of the run store.
class BareTable {
 public:
  explicit BareTable(const std::string& path) : connection_(path, db::sqlite::Access::kReadWrite) {
    connection_.execute(
        "PRAGMA page_size = 4096; PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL; "
        "CREATE TABLE frames (frame INTEGER PRIMARY KEY, branch, ordinal, setpoint_psi, feedback_psi, reference_psi, "
        "setpoint_counts, feedback_counts, reference_counts, time_ns, since_command_ns, in_band_ns, device_time_us, "
        "status, exchanges, \"rows\", columns, scans, counts)");
  }
  // Each frame in a transaction of its own, or all of them in one.
  void append(Frames frames, bool at_once) {
    if (!insert_) {
      insert_ = std::make_unique<db::sqlite::Statement>(
          connection_, "INSERT INTO frames VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
    }
    std::optional<db::sqlite::Transaction> transaction;
    if (at_once) transaction.emplace(connection_);
    for (const db::FrameRecord& f : frames) {
      insert_
          ->bind(++key_, f.branch, f.ordinal, f.setpoint_psi, f.feedback_psi, f.reference_psi, f.setpoint_counts,
                 f.feedback_counts, f.reference_counts, f.time_ns, f.since_command_ns, f.in_band_ns, f.device_time_us,
                 f.status, f.exchanges, f.rows, f.columns, f.scans, f.counts)
          .run();
    }
    if (transaction) transaction->commit();
  }
  [[nodiscard]] std::vector<db::FrameRecord> read() {
    db::sqlite::Statement rows(connection_, "SELECT * FROM frames WHERE frame > 0 ORDER BY frame");
    std::vector<db::FrameRecord> frames;
    std::int64_t key = 0;
    db::FrameRecord f;
    while (rows.step()) {
      rows.read(key, f.branch, f.ordinal, f.setpoint_psi, f.feedback_psi, f.reference_psi, f.setpoint_counts,
                f.feedback_counts, f.reference_counts, f.time_ns, f.since_command_ns, f.in_band_ns, f.device_time_us,
                f.status, f.exchanges, f.rows, f.columns, f.scans, f.counts);
      frames.push_back(f);
    }
    return frames;
  }

 private:
  db::sqlite::Connection connection_;
  std::unique_ptr<db::sqlite::Statement> insert_;
  std::int64_t key_ = 0;
};

// Other work on the machine varies: the data are cut into pieces, and each counts with its best round. All subjects are
// measured in this way.
class BestStretches {
 public:
  void write(std::vector<db::FrameRecord>& frames, const std::function<void(Frames)>& append) {
    constexpr std::size_t kGroup = 100;
    const Frames all(frames);
    for (std::size_t first = 0, i = 0; first < all.size(); first += kGroup, ++i) {
      const Frames some = all.subspan(first, std::min(kGroup, all.size() - first));
      take(i, [&] { append(some); });
    }
  }
  // The whole, `times` times, by the processor's clock: it waits for nothing.
  void read(int times, const std::function<void()>& act) {
    if (best_.empty()) best_.push_back(kNone);
    best_[0] = std::min(best_[0], best_seconds(times, act, By::kProcessor));
  }
  [[nodiscard]] double seconds() const { return std::accumulate(best_.begin(), best_.end(), 0.0); }

 private:
  void take(std::size_t stretch, const std::function<void()>& act) {
    const double taken = best_seconds(1, act);
    if (stretch >= best_.size()) best_.resize(stretch + 1, kNone);
    best_[stretch] = std::min(best_[stretch], taken);
  }
  static constexpr double kNone = std::numeric_limits<double>::infinity();
  std::vector<double> best_;
};

}  // namespace

std::vector<Figure> benchmark_store(int rounds, const std::string& folder, const StoreSizes& sizes) {
  constexpr int kReadings = 5;  // a round
  std::vector<db::FrameRecord> durable = frames_of(sizes.durable), all = frames_of(sizes.frames);
  BestStretches plain, full, bare, normal, grouped, bare_read, read;
  for (int round = 0; round < rounds; ++round) {
    const auto path = [&](const char* name) { return fmt::format("{}/{}-{}", folder, name, round); };
    const PlainFile file(path("plain"));
    OpenRun full_run(path("full.db"), db::Durability::kFull, sizes.durable),
        normal_run(path("normal.db"), db::Durability::kNormal, sizes.frames);
    BareTable bare_table(path("bare.db")), grouped_table(path("grouped.db"));
    plain.write(durable, [&](Frames frames) { file.append(frames); });
    full.write(durable, [&](Frames frames) { full_run.append(frames); });
    bare.write(all, [&](Frames frames) { bare_table.append(frames, false); });
    normal.write(all, [&](Frames frames) { normal_run.append(frames); });
    grouped.write(all, [&](Frames frames) { grouped_table.append(frames, true); });
    bare_read.read(kReadings, [&] { keep(bare_table.read().size()); });
    read.read(kReadings, [&] { keep(normal_run.read().size()); });
  }
  return figures_of(StoreTimes{plain.seconds(), full.seconds(), bare.seconds(), normal.seconds(), grouped.seconds(),
                               bare_read.seconds(), read.seconds()},
                    sizes);
}

std::vector<Figure> figures_of(const StoreTimes& times, const StoreSizes& sizes) {
  const double per_durable = 1e6 / static_cast<double>(sizes.durable),
               per_frame = 1e6 / static_cast<double>(sizes.frames);
  FigureList figures("store");
  figures.add("append_and_fdatasync", per_durable * times.plain, "us/frame");
  figures.add("full", per_durable * times.full, "us/frame");
  figures.add_at_most("full_over_floor", times.full / times.plain, 1.5);
  figures.add("bare_insert", per_frame * times.bare, "us/frame");
  figures.add("normal", per_frame * times.normal, "us/frame");
  figures.add_at_most("normal_over_bare", times.normal / times.bare, 1.25);
  figures.add("bare_insert_groups_of_100", per_frame * times.grouped, "us/frame");
  figures.add("bare_read", per_frame * times.bare_read, "us/frame");
  figures.add("read", per_frame * times.read, "us/frame");
  figures.add_at_most("read_over_bare", times.read / times.bare_read, 1.3);
  return figures.take();
}

}  // namespace tactbench::bench
