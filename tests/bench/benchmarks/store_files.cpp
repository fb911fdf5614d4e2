// `benchmark store` writes the same frames in each of its ways; here it writes few of them, and its files are read.
#include <catch2/catch.hpp>
#include <cstring>
#include <string>
#include <vector>

#include "bench/benchmarks/store.h"
#include "db/run_store.h"
#include "db/sqlite.h"
#include "tests/bench/benchmarks/counted_time.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench;

namespace {

constexpr std::size_t kWritten = 120, kWrittenDurably = 105;

// Frame i has thousandths of i psi, came at each second second, and counts of 7 i + 251 t, 16 bit.
std::vector<std::uint16_t> counts_of_frame(std::size_t i) {
  std::vector<std::uint16_t> counts(256);
  for (std::size_t t = 0; t < 256; ++t) counts[t] = static_cast<std::uint16_t>((7 * i + 251 * t) % 65536);
  return counts;
}

void check_stored_run(const std::string& path, std::size_t frames) {
  INFO(path);
  const db::RunStore store = db::RunStore::open_read_only(path);
  CHECK(store.check_structure().empty());
  const std::vector<db::FrameRecord> read = store.frames(1);
  REQUIRE(read.size() == frames);
  CHECK(store.run(1).sequences.front().frames_per_repeat == static_cast<int>(frames));
  CHECK(store.run(1).state == "prepared");
  for (std::size_t i = 0; i < frames; ++i) {
    INFO("frame " << i);
    CHECK(read[i].ordinal == static_cast<int>(i));
    CHECK(read[i].setpoint_psi == Approx(0.001 * static_cast<double>(i)));
    CHECK(read[i].feedback_psi == read[i].setpoint_psi);
    CHECK(read[i].reference_psi == read[i].setpoint_psi);
    CHECK(read[i].time_ns == 2'000'000'000LL * static_cast<std::int64_t>(i));
    CHECK((read[i].rows == 16 && read[i].columns == 16 && read[i].scans == 1));
    CHECK(read[i].counts == counts_of_frame(i));
  }
}

void check_bare_table(const std::string& path) {
  INFO(path);
  db::sqlite::Connection table(path, db::sqlite::Access::kReadOnly);
  CHECK(table.integer("SELECT count(*) FROM frames") == static_cast<std::int64_t>(kWritten));
  CHECK(table.text("PRAGMA journal_mode") == "wal");
  db::sqlite::Statement rows(table,
                             "SELECT frame, branch, ordinal, setpoint_psi, feedback_psi, reference_psi, time_ns, "
                             "\"rows\", columns, scans, counts FROM frames ORDER BY frame");
  for (std::size_t i = 0; rows.step(); ++i) {
    INFO("frame " << i);
    std::int64_t key = 0, time = 0;
    db::FrameRecord f;
    rows.read(key, f.branch, f.ordinal, f.setpoint_psi, f.feedback_psi, f.reference_psi, time, f.rows, f.columns,
              f.scans, f.counts);
    CHECK(key == static_cast<std::int64_t>(i) + 1);
    CHECK(f.ordinal == static_cast<int>(i));
    CHECK(f.setpoint_psi == Approx(0.001 * static_cast<double>(i)));
    CHECK(f.feedback_psi == f.setpoint_psi);
    CHECK(f.reference_psi == f.setpoint_psi);
    CHECK(time == 2'000'000'000LL * static_cast<std::int64_t>(i));
    CHECK((f.rows == 16 && f.columns == 16 && f.scans == 1));
    CHECK(f.counts == counts_of_frame(i));
  }
}

}  // namespace

TEST_CASE("benchmark store: a plain file, stores and bare tables hold the same frames, in new files each round") {
  const tests::TemporaryFolder folder;
  const std::ptrdiff_t descriptors = tests::descriptors_left_open();
  const std::vector<bench::Figure> figures = [&] {
    const tests::CountedTime time;  // a system's own may say that a reading takes no time
    return bench::benchmark_store(2, folder.path(), {kWritten, kWrittenDurably});
  }();
  CHECK(tests::descriptors_left_open() == descriptors);
  std::string names;
  for (const bench::Figure& figure : figures) {
    INFO(figure.name);
    CHECK(figure.value > 0.0);
    names += figure.name.substr(6) + " ";
  }
  CHECK(names ==
        "append_and_fdatasync full full_over_floor full_over_floor_goal_at_most bare_insert normal normal_over_bare "
        "normal_over_bare_goal_at_most bare_insert_groups_of_100 bare_read read read_over_bare "
        "read_over_bare_goal_at_most ");
  for (const char* round : {"0", "1"}) {
    const std::string plain = tests::read_file(folder.path(std::string("plain-") + round));
    REQUIRE(plain.size() == 544 * kWrittenDurably);  // a frame, and room for 32 bytes of numbers
    for (std::size_t i = 0; i < kWrittenDurably; ++i) {
      const std::vector<std::uint16_t> counts = counts_of_frame(i);
      CHECK(std::memcmp(plain.data() + 544 * i, counts.data(), 512) == 0);
      CHECK(plain.substr(544 * i + 512, 32) == std::string(32, '\0'));
    }
    check_stored_run(folder.path(std::string("full.db-") + round), kWrittenDurably);
    check_stored_run(folder.path(std::string("normal.db-") + round), kWritten);
    check_bare_table(folder.path(std::string("bare.db-") + round));
    check_bare_table(folder.path(std::string("grouped.db-") + round));
  }
}
