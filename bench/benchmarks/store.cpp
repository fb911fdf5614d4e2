#include "bench/benchmarks/store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <optional>
#include <system_error>

#include "bench/benchmarks/synthetic_array.h"
#include "db/sqlite.h"

namespace tactbench::bench {

namespace {

constexpr std::size_t kFrames = 3310, kDurable = 1000, kGroup = 100;
constexpr std::size_t kBytes = 512 + 32;  // a frame and its numbers

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

// A run that takes frames, ready for the first.
class OpenRun {
 public:
  OpenRun(const std::string& path, db::Durability durability) : store_(db::RunStore::open(path, durability)) {
    store_.add_sensor({"B-1", "synthetic", "", db::sha256_hex(""), "SIM-SCANNER-1", "", ""});
    db::RunRecord run;
    run.uuid = db::new_uuid();
    run.origin = "simulated";
    run.state = "prepared";
    run.sensor_serial = "B-1";
    run.sequences = {{0, "frames", "", "", 1, static_cast<int>(kFrames)}};
    run_ = store_.begin_run(run);
    branch_ = store_.begin_branch(run_, {});
  }
  void append(std::vector<db::FrameRecord>& frames) {
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
  void append(const std::vector<db::FrameRecord>& frames) const {
    std::array<std::byte, kBytes> bytes{};
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
  // One transaction for `group` frames.
  void append(const std::vector<db::FrameRecord>& frames, std::size_t group) {
    db::sqlite::Statement row(
        connection_, "INSERT INTO frames VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)", true);
    std::optional<db::sqlite::Transaction> transaction;
    std::int64_t key = 0;
    for (const db::FrameRecord& f : frames) {
      if (group > 1 && !transaction) transaction.emplace(connection_);
      row.bind(++key, f.branch, f.ordinal, f.setpoint_psi, f.feedback_psi, f.reference_psi, f.setpoint_counts,
               f.feedback_counts, f.reference_counts, f.time_ns, f.since_command_ns, f.in_band_ns, f.device_time_us,
               f.status, f.exchanges, f.rows, f.columns, f.scans, f.counts)
          .run();
      if (!transaction || static_cast<std::size_t>(key) % group != 0) continue;
      transaction->commit();
      transaction.reset();
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
};

}  // namespace

std::vector<Figure> benchmark_store(int rounds, const std::string& folder) {
  std::vector<db::FrameRecord> durable = frames_of(kDurable), all = frames_of(kFrames);
  std::vector<double> best(8, 1e9);
  for (int round = 0; round < rounds; ++round) {
    const auto path = [&](const char* name) { return fmt::format("{}/{}-{}", folder, name, round); };
    const PlainFile file(path("plain"));
    OpenRun full(path("full.db"), db::Durability::kFull), normal(path("normal.db"), db::Durability::kNormal);
    BareTable bare(path("bare.db")), grouped(path("grouped.db"));
    const std::vector<double> taken =
        best_seconds(1, {[&] { file.append(durable); }, [&] { full.append(durable); }, [&] { bare.append(all, 1); },
                         [&] { normal.append(all); }, [&] { grouped.append(all, kGroup); },
                         [&] { keep(bare.read().size()); }, [&] { keep(normal.read().size()); }});
    for (std::size_t i = 0; i < taken.size(); ++i) best[i] = std::min(best[i], taken[i]);
  }
  const double per_durable = 1e6 / static_cast<double>(kDurable), per_frame = 1e6 / static_cast<double>(kFrames);
  FigureList figures("store");
  figures.add("append_and_fdatasync", per_durable * best[0], "us/frame");
  figures.add("full", per_durable * best[1], "us/frame");
  figures.add_at_most("full_over_floor", best[1] / best[0], 1.5);
  figures.add("bare_insert", per_frame * best[2], "us/frame");
  figures.add("normal", per_frame * best[3], "us/frame");
  figures.add_at_most("normal_over_bare", best[3] / best[2], 1.25);
  figures.add("bare_insert_groups_of_100", per_frame * best[4], "us/frame");
  figures.add("bare_read", per_frame * best[5], "us/frame");
  figures.add("read", per_frame * best[6], "us/frame");
  figures.add_at_most("read_over_bare", best[6] / best[5], 1.3);
  return figures.take();
}

}  // namespace tactbench::bench
