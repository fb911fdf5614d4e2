// The one file of a bench: runs, frames, events, models, verdicts in SQLite (WAL). One committed transaction a frame:
// a process that dies loses nothing that was acknowledged. Not thread-safe: one owner; other processes may read.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "db/record.h"

namespace tactbench::db {

// The one error type of this room. id: TB-STORE-OPEN, TB-STORE-NEWER, TB-STORE-NETWORK, TB-STORE-LOCKED,
// TB-STORE-FULL, TB-STORE-NOT-FOUND, TB-STORE-SQL, TB-STORE-CONFLICT, TB-STORE-EXISTS, TB-STORE-TAG.
class StoreError : public std::runtime_error {
 public:
  StoreError(std::string id, const std::string& message, std::string remedy)
      : std::runtime_error(message), id_(std::move(id)), remedy_(std::move(remedy)) {}
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const std::string& remedy() const { return remedy_; }

 private:
  std::string id_, remedy_;
};

enum class Durability {
  kFull,    // synchronous=FULL: survives a power cut; on hardware
  kNormal,  // survives the process's death; under the turned clock
};

inline constexpr int kSchemaVersion = 5;

struct ContentCheck {
  std::string stored_sha256, computed_sha256;  // in hex; stored is empty until the run ends
  std::int64_t frames = 0;
  // The first thing that is not as it was stored, in words, as far as the links kept with the frames tell; empty: none.
  std::string difference;
  [[nodiscard]] bool holds() const { return difference.empty(); }
};

// Schema of the file, without opening it for writing and without migrating it. TB-STORE-OPEN when it is no store.
int schema_version_of(const std::string& path);
// Where opening an older store keeps it as it was: beside it, first name that is free ("runs.db.schema-2.backup").
std::string backup_path(const std::string& path, int version);

class RunStore {
 public:
  // Opens or makes `path`, refuses a newer schema (TB-STORE-NEWER), a file that is not ours, and network file systems.
  // An older schema is brought up to kSchemaVersion, after a backup was made beside it (backup_path).
  static RunStore open(const std::string& path, Durability durability = Durability::kFull);
  // Opens an existing file without ever writing to it. TB-STORE-OPEN when it does not exist.
  static RunStore open_read_only(const std::string& path);
  RunStore(RunStore&&) noexcept;
  RunStore& operator=(RunStore&&) noexcept;
  ~RunStore();

  // Sensors. add_sensor: TB-STORE-CONFLICT when the serial exists with another type file or scanner.
  void add_sensor(const SensorRecord& sensor);
  [[nodiscard]] std::optional<SensorRecord> sensor(const std::string& serial) const;
  [[nodiscard]] std::vector<SensorRecord> sensors() const;

  // Writing a run. begin_run stores the row (outcome incomplete) with its sequences and devices and returns the
  // number; every call is one durable commit.
  std::int64_t begin_run(const RunRecord& run);
  void set_devices(std::int64_t run, const std::vector<DeviceRecord>& devices);  // once known, before the first frame
  void set_state(std::int64_t run, const std::string& state, const EventRecord& event);
  std::int64_t begin_branch(std::int64_t run, const BranchRecord& branch);
  void void_branch(std::int64_t branch, const std::string& reason);
  void append_frame(std::int64_t run, const FrameRecord& frame);
  void append_event(std::int64_t run, const EventRecord& event);
  void append_check(std::int64_t run, const CheckRecord& check);
  // TB-STORE-CONFLICT when a series is there already, or has not one output for each input.
  void append_series(std::int64_t run, const std::vector<SeriesRecord>& series);
  void set_rest(std::int64_t run, double rest_s);           // wall clock: no part of the canonical content
  void set_seen(std::int64_t run, const std::string& utc);  // a sign of life, for who resumes it
  // What people say of a run; none of it is canonical content, all of it goes for a run of any state but void_run.
  // A tag is one word of letters, digits and . _ : / + -; adding one twice or removing one that is not there is no
  // error. TB-STORE-TAG for another kind of tag.
  void set_tags(std::int64_t run, const std::vector<std::string>& add, const std::vector<std::string>& remove);
  void add_note(std::int64_t run, const std::string& text);  // a line more
  // The run counts no more, for good; it stays. TB-STORE-CONFLICT when it has not ended, is void already, or reason or
  // name are missing.
  void void_run(std::int64_t run, const std::string& reason, const std::string& by, const std::string& utc);
  // Closes the run: state ended, outcome, reason, safe state, content hash.
  void end_run(std::int64_t run, Outcome outcome, const std::string& reason, SafeState safe, const std::string& utc);
  // The runs that have not ended become interrupted, with an event and their content hash; returns how many. Only for
  // a caller who knows that nobody is writing a run to this store.
  int mark_interrupted(const std::string& utc);
  // An ended run that was not completed takes rows again: state prepared, outcome incomplete; `event` says why and what
  // had ended it. TB-STORE-CONFLICT for a completed or a running one.
  void reopen_run(std::int64_t run, const EventRecord& event);

  // Reading. TB-STORE-NOT-FOUND names the runs there are.
  [[nodiscard]] std::vector<RunRecord> runs() const;  // newest last; without sequences and devices
  [[nodiscard]] RunRecord run(std::int64_t number) const;
  [[nodiscard]] std::vector<BranchRecord> branches(std::int64_t run) const;
  [[nodiscard]] std::vector<FrameRecord> frames(std::int64_t run) const;  // in the order written
  [[nodiscard]] std::int64_t frame_count(std::int64_t run) const;
  [[nodiscard]] std::vector<EventRecord> events(std::int64_t run) const;
  [[nodiscard]] std::vector<CheckRecord> checks(std::int64_t run) const;
  [[nodiscard]] std::vector<SeriesRecord> series(std::int64_t run) const;  // by sequence, then taxel
  // The newest check of that kind of an earlier run of this sensor with that verdict; void runs do not count.
  [[nodiscard]] std::optional<CheckRecord> last_check(const std::string& sensor_serial, const std::string& kind,
                                                      const std::string& verdict, std::int64_t before_run) const;
  [[nodiscard]] std::int64_t last_time_ns(std::int64_t run) const;  // of its newest frame or event; 0: none

  // For time estimates, cheap: no frame is read. The sequences of the `newest` completed runs of a bench, newest first.
  [[nodiscard]] std::vector<TimedSequence> timed_sequences(const std::string& bench_id, int newest) const;
  [[nodiscard]] std::int64_t last_position(std::int64_t run) const;  // of a frame within the run, from 1; 0: none
  [[nodiscard]] std::optional<FrameTime> frame_time(std::int64_t run, std::int64_t position) const;

  // Looks whether a run's rows are those it was ended with. It may be asked of any run; one that has not ended has no
  // stored hash, and its links alone are looked at.
  [[nodiscard]] ContentCheck check_content(std::int64_t run) const;
  // SQLite's own look at the file (integrity_check, foreign_key_check): what is wrong, a line each; empty: nothing.
  [[nodiscard]] std::vector<std::string> check_structure() const;
  // Copies the store as it stands at this moment into a new file, also while another process writes a run.
  // TB-STORE-EXISTS when the file is there already; what fails half-way leaves no file.
  void snapshot(const std::string& path) const;
  // Takes ended runs of another store with their sensors, fits and verdicts; returns their numbers here. All of them or
  // none: TB-STORE-EXISTS when one is here already (by its UUID), TB-STORE-CONFLICT when one is not what was stored,
  // has not ended, or its sensor is known here as another.
  std::vector<std::int64_t> copy_runs_from(const RunStore& other, const std::vector<std::int64_t>& runs);

  // SHA-256 chained over the run's canonical content: everything but UUID, wall-clock times and time zone, host, tags,
  // notes and the run's number, which is an accident of the file (hash_chain.h). Recomputed from what is stored.
  [[nodiscard]] std::string content_hash(std::int64_t run) const;

  // Models and verdicts.
  std::int64_t add_fit(const FitRecord& fit, const std::vector<FitTaxelRecord>& taxels);
  [[nodiscard]] std::optional<FitRecord> latest_fit(std::int64_t run, const std::string& model) const;
  [[nodiscard]] std::optional<FitRecord> latest_fit(std::int64_t run) const;  // of any model
  [[nodiscard]] FitRecord fit(std::int64_t fit) const;
  [[nodiscard]] std::vector<FitRecord> fits(std::int64_t run) const;  // oldest first
  [[nodiscard]] std::vector<FitTaxelRecord> fit_taxels(std::int64_t fit) const;
  // All verdicts of the run, by whatever fit, give way to these; fit 0: judged without a stored fit.
  void replace_verdicts(std::int64_t run, std::int64_t fit, const std::vector<VerdictRecord>& verdicts);
  [[nodiscard]] std::vector<VerdictRecord> verdicts(std::int64_t run) const;  // fit 0: without a stored fit

  // What is followed over time. All figures of that subject in that run give way to these.
  void replace_figures(std::int64_t run, const std::string& subject, const std::map<std::string, double>& figures);
  // Of runs that are not void, by run, then name. An empty subject: of all.
  [[nodiscard]] std::vector<FigureRecord> figures(const std::string& subject) const;
  // TB-STORE-CONFLICT without reason, name or runs, for a void run, one without figures of
  // the subject, and when runs of several origins are mixed.
  std::int64_t add_baseline(const BaselineRecord& baseline);
  [[nodiscard]] std::vector<BaselineRecord> baselines() const;  // oldest first; of a subject the last one counts
  // Approved reports. TB-STORE-CONFLICT when that number is approved already, or without a name.
  void add_report(const ReportRecord& report);
  [[nodiscard]] std::vector<ReportRecord> reports(std::int64_t run) const;  // oldest first

  [[nodiscard]] const std::string& path() const;

 private:
  class Database;
  explicit RunStore(std::unique_ptr<Database> database);
  std::unique_ptr<Database> database_;
};

// SHA-256 of `text` as 64 hex digits.
std::string sha256_hex(const std::string& text);
// Random UUID, version 4 (RFC 9562).
std::string new_uuid();

}  // namespace tactbench::db
