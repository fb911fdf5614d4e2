#include "db/newest.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>

#include "db/run_store_database.h"

namespace tactbench::db {

namespace {

// Of a store that RunStore has opened and checked.
struct SecondLook {
  explicit SecondLook(const RunStore& store)
      : connection(std::filesystem::absolute(store.path()).string(), sqlite::Access::kReadOnly) {
    connection.trust_no_schema();
  }
  sqlite::Connection connection;
};

}  // namespace

std::optional<NewestFrame> newest_frame(const RunStore& store, std::int64_t run) {
  SecondLook look(store);
  sqlite::Statement row(look.connection,
                        "SELECT frame, setpoint_psi, reference_psi, \"rows\", columns, scans, counts, wrench IS NOT "
                        "NULL, wrench FROM frames WHERE frame > ? AND frame < ? ORDER BY frame DESC LIMIT 1");
  if (!row.bind(frames_above(run), frames_below(run)).step()) return std::nullopt;
  FrameRecord shape;
  NewestFrame frame;
  bool pressed = false;
  row.read(frame.position, frame.setpoint_psi, frame.reference_psi, shape.rows, shape.columns, shape.scans,
           shape.counts, pressed);
  if (!fits_its_shape(shape)) {
    throw StoreError("TB-STORE-SQL",
                     fmt::format("store {}: the last frame of run {} does not hold scans x rows x columns counts",
                                 store.path(), run),
                     "the file was changed by another hand: take your last snapshot");
  }
  frame.position -= frames_above(run);
  frame.rows = shape.rows;
  frame.columns = shape.columns;
  frame.scans = shape.scans;
  frame.counts = std::move(shape.counts);
  if (pressed) {
    std::array<double, 6> wrench{};
    row.read_from(8, wrench);
    frame.force_n = -wrench[2];
  }
  return frame;
}

void newest_events(const RunStore& store, std::int64_t run, const std::function<bool(const EventRecord&)>& see) {
  SecondLook look(store);
  sqlite::Statement rows(look.connection,
                         "SELECT time_ns, kind, id, detail FROM events WHERE run = ? ORDER BY event DESC");
  rows.bind(run);
  EventRecord event;
  while (rows.step()) {
    rows.read(event.time_ns, event.kind, event.id, event.detail);
    if (!see(event)) return;
  }
}

}  // namespace tactbench::db
