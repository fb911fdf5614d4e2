#include "db/run_frame_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "db/run_store_database.h"
#include "db/scan_means.h"

namespace tactbench::db {

namespace {

constexpr const char* kColumns =
    "SELECT f.frame, f.time_ns, f.setpoint_psi, f.feedback_psi, f.reference_psi, f.\"rows\", f.columns, f.scans, "
    "f.counts, f.flags, coalesce(b.void, 0), f.wrench IS NOT NULL, f.target_n, f.force_start_n, f.wrench, f.place_mm "
    "FROM frames f LEFT JOIN branches b ON b.branch = f.branch WHERE f.frame > ? AND f.frame < ? ORDER BY f.frame ";

StoredFrame frame_of(const sqlite::Statement& row, std::int64_t above, const std::string& path) {
  StoredFrame seen;
  FrameRecord shape;
  row.read(seen.position, seen.time_ns, seen.setpoint_psi, seen.feedback_psi, seen.reference_psi, shape.rows,
           shape.columns, shape.scans, shape.counts, seen.flags, seen.is_void);
  if (!has_consistent_shape(shape)) {
    throw StoreError("TB-STORE-SQL",
                     fmt::format("store {}: frame {} does not hold scans x rows x columns counts", path, seen.position),
                     "another program changed the file: restore your last snapshot");
  }
  seen.position -= above;
  seen.rows = shape.rows;
  seen.columns = shape.columns;
  seen.scans = shape.scans;
  seen.counts = std::move(shape.counts);
  if (row.value<bool>(11)) {
    WrenchRecord& wrench = seen.wrench.emplace();
    row.read_from(12, wrench.target_n, wrench.force_start_n, wrench.wrench, wrench.place_mm);
  }
  return seen;
}

struct ResetAtEnd {
  sqlite::Statement& statement;
  ~ResetAtEnd() { statement.reset(); }
};

}  // namespace

std::vector<double> mean_counts(const StoredFrame& frame) {
  return scan_means(frame.counts, static_cast<std::size_t>(frame.scans));
}

struct RunFrameReader::Queries {
  explicit Queries(const RunStore& store)
      : connection(std::filesystem::absolute(store.path()).string(), sqlite::Access::kReadOnly) {
    connection.disable_triggers_and_views();
  }
  sqlite::Connection connection;
  sqlite::Statement after{connection, std::string(kColumns) + "LIMIT ?"};  // asked for at every frame
};

RunFrameReader::RunFrameReader(const RunStore& store, std::int64_t run)
    : run_(run), queries_(std::make_unique<Queries>(store)) {}
RunFrameReader::RunFrameReader(RunFrameReader&&) noexcept = default;
RunFrameReader& RunFrameReader::operator=(RunFrameReader&&) noexcept = default;
RunFrameReader::~RunFrameReader() = default;

void RunFrameReader::frames_after(std::int64_t position, int most, const std::function<void(const StoredFrame&)>& see) {
  const std::int64_t above = frames_above(run_);
  sqlite::Statement& rows = queries_->after;
  const ResetAtEnd reset{rows};  // otherwise the writer's log could not be moved into the file
  rows.bind(above + std::max<std::int64_t>(position, 0), frames_below(run_), most);
  while (rows.step()) see(frame_of(rows, above, queries_->connection.path()));
}

std::optional<StoredFrame> RunFrameReader::newest() {
  const std::int64_t above = frames_above(run_);
  sqlite::Statement row(queries_->connection, std::string(kColumns) + "DESC LIMIT 1");
  if (!row.bind(above, frames_below(run_)).step()) return std::nullopt;
  return frame_of(row, above, queries_->connection.path());
}

std::int64_t RunFrameReader::before_newest(int most) {
  sqlite::Statement row(queries_->connection,
                        "SELECT frame FROM frames WHERE frame > ? AND frame < ? ORDER BY frame DESC LIMIT 1 OFFSET ?");
  const auto frame = row.bind(frames_above(run_), frames_below(run_), most).first<std::int64_t>();
  return frame ? *frame - frames_above(run_) : 0;
}

}  // namespace tactbench::db
