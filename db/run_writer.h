// Writes a run to the store: begins it, adds branches, frames, events and checks, ends it; and marks or reopens runs
// that did not complete.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "db/run_reader.h"

namespace tactbench::db {

// Part of a RunStore, with what it wrote. begin_run stores the row (outcome incomplete) with its sequences and devices
// and returns the run's number; every call is one durable commit.
class RunWriter : public RunReader {
 public:
  using RunReader::RunReader;

  // How long each call waits for the lock of another writer before it throws TB-STORE-LOCKED without any effect, so
  // that it may be repeated. Default: 5 s. Of the whole store.
  void wait_for_locks(std::chrono::milliseconds at_most);

  // TB-STORE-CONFLICT when the serial exists with another type file or scanner.
  void add_sensor(const SensorRecord& sensor);

  std::int64_t begin_run(const RunRecord& run);
  void set_devices(std::int64_t run, const std::vector<DeviceRecord>& devices);  // once known, before the first frame
  void set_state(std::int64_t run, const std::string& state, const EventRecord& event);
  std::int64_t begin_branch(std::int64_t run, const BranchRecord& branch);
  void void_branch(std::int64_t branch, const std::string& reason);
  void append_frame(std::int64_t run, const FrameRecord& frame);
  void append_event(std::int64_t run, const EventRecord& event);
  void append_check(std::int64_t run, const CheckRecord& check);
  // TB-STORE-CONFLICT when the series exists already, or does not have one output for each input.
  void append_series(std::int64_t run, const std::vector<SeriesRecord>& series);
  void set_rest(std::int64_t run, double rest_s);  // wall-clock time, which is not part of the canonical content
  void set_seen(std::int64_t run, const std::string& utc);  // last sign of life, for a resume
  // Closes the run: state ended, outcome, reason, safe state, content hash.
  void end_run(std::int64_t run, Outcome outcome, const std::string& reason, SafeState safe, const std::string& utc);
  // Marks every run that has not ended as interrupted, with an event and its content hash; returns their number. Call
  // it only when it is certain that no process is writing a run to this store.
  int mark_interrupted(const std::string& utc);
  // Reopens an ended run that was not completed: state prepared, outcome incomplete; `event` holds the reason and the
  // cause of its end. TB-STORE-CONFLICT for a completed or running run, and for a run that has changed since it was
  // stored, because its next end would hash the changed content.
  void reopen_run(std::int64_t run, const EventRecord& event);
};

}  // namespace tactbench::db
