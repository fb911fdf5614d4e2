// The store of a bench, one SQLite file (WAL): runs, frames, events, models, verdicts. Each frame is one committed
// transaction, so a process that dies loses no acknowledged data. Not thread-safe: one owner; other processes may read.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "db/record.h"

namespace tactbench::db {

// The error type of db/. id: TB-STORE-OPEN, TB-STORE-GONE, TB-STORE-OTHER-SCHEMA, TB-STORE-NETWORK, TB-STORE-LOCKED,
// TB-STORE-FULL, TB-STORE-NOT-FOUND, TB-STORE-SQL, TB-STORE-CONFLICT, TB-STORE-EXISTS, TB-STORE-TAG, TB-STORE-FOREIGN,
// TB-STORE-TOO-LONG, TB-STORE-TOO-LARGE, TB-STORE-NOT-TEXT, TB-STORE-BLANK, TB-STORE-PRUNED.
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
  kFull,    // synchronous=FULL: survives a power failure; for hardware
  kNormal,  // survives the death of the process; for simulations with a manual clock
};

inline constexpr int kSchemaVersion = 1;

// Greatest lengths, in characters, of texts that people enter. Longer texts and texts that are not UTF-8 are refused
// before anything is stored (TB-STORE-TOO-LONG, TB-STORE-NOT-TEXT), and so are names, notes and reasons without a
// visible character (TB-STORE-BLANK).
inline constexpr std::size_t kMaxNameLength = 200;    // names, serials, also those that instruments report
inline constexpr std::size_t kMaxTextLength = 10000;  // purposes, notes, reasons
inline constexpr std::size_t kMaxTags = 100;
void check_text(const std::string& what, const std::string& text, std::size_t longest);
void check_nonblank_text(const std::string& what, const std::string& text,
                         std::size_t longest);  // also refuses a blank text

// Sets the function that receives warnings, one sentence each, for the whole program, since db/ prints nothing. Empty
// (the default): warnings are dropped. Set it before threads are started.
void set_warning_handler(std::function<void(const std::string&)> tell);

struct ContentCheck {
  std::string stored_sha256, computed_sha256;  // in hex; stored is empty until the run ends
  std::int64_t frames = 0;
  // The first difference from what was stored, as text, as far as the stored links of the chain show it; empty: none.
  std::string difference;
  // Set if the frames were removed by a retention rule: the rest of the run was checked, the frames were not.
  std::optional<PrunedRecord> pruned;
  [[nodiscard]] bool holds() const { return difference.empty(); }
};

// Schema version of the file, read without writing or migrating. TB-STORE-OPEN if it is not a store.
int schema_version_of(const std::string& path);
// Name of the backup made when an older store is opened: next to it, first free name ("runs.db.schema-2.backup").
std::string backup_path(const std::string& path, int version);

struct RunFilter {
  std::string sensor_serial = {}, since_utc = {}, content_sha256 = {};  // empty: any
};

class RunStore {
 public:
  // Opens or creates `path`; refuses the store of a build with another schema (TB-STORE-OTHER-SCHEMA), a file that is
  // not a store, further tables, indexes, views or triggers in a store (TB-STORE-FOREIGN), and network file systems. An
  // older schema is migrated to kSchemaVersion after a backup has been made next to it (backup_path).
  static RunStore open(const std::string& path, Durability durability = Durability::kFull);
  // Opens an existing file without ever writing to it. TB-STORE-OPEN when it does not exist. A store on a network file
  // system is read as it is, with a warning (set_warning_handler); TB-STORE-NETWORK when it has a write-ahead log.
  static RunStore open_read_only(const std::string& path);
  RunStore(RunStore&&) noexcept;
  RunStore& operator=(RunStore&&) noexcept;
  ~RunStore();

  // How long each call waits for the lock of another writer before it throws TB-STORE-LOCKED without any effect, so
  // that it may be repeated. Default: 5 s.
  void wait_for_locks(std::chrono::milliseconds at_most);

  // Sensors. add_sensor: TB-STORE-CONFLICT when the serial exists with another type file or scanner.
  void add_sensor(const SensorRecord& sensor);
  [[nodiscard]] std::optional<SensorRecord> sensor(const std::string& serial) const;
  [[nodiscard]] std::vector<SensorRecord> sensors() const;

  // Writing a run. begin_run stores the row (outcome incomplete) with its sequences and devices and returns the run's
  // number; every call is one durable commit.
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
  // Users' remarks on a run; they are not part of the canonical content. All except void_run are possible in any state
  // of the run. A tag is one word of letters, digits and . _ : / + -; adding one twice or removing an absent one is not
  // an error. TB-STORE-TAG for an invalid tag.
  void set_tags(std::int64_t run, const std::vector<std::string>& add, const std::vector<std::string>& remove);
  void add_note(std::int64_t run, const std::string& text);  // appends a line
  // Declares the run void, permanently; its rows stay. TB-STORE-BLANK without reason or name, TB-STORE-CONFLICT
  // without date, or if the run has not ended or is already void.
  void void_run(std::int64_t run, const std::string& reason, const std::string& by, const std::string& utc);
  // Closes the run: state ended, outcome, reason, safe state, content hash.
  void end_run(std::int64_t run, Outcome outcome, const std::string& reason, SafeState safe, const std::string& utc);
  // Marks every run that has not ended as interrupted, with an event and its content hash; returns their number. Call
  // it only when it is certain that no process is writing a run to this store.
  int mark_interrupted(const std::string& utc);
  // Reopens an ended run that was not completed: state prepared, outcome incomplete; `event` holds the reason and the
  // cause of its end. TB-STORE-CONFLICT for a completed or running run, and for a run that has changed since it was
  // stored, because its next end would hash the changed content.
  void reopen_run(std::int64_t run, const EventRecord& event);

  // Reading. TB-STORE-NOT-FOUND names the existing runs. frames() and for_each_frame(): TB-STORE-PRUNED for a run whose
  // frames were removed.
  // Newest last; without sequences and devices. Uses an index: runs left out by the filter cost no time.
  [[nodiscard]] std::vector<RunRecord> runs() const;
  [[nodiscard]] std::vector<RunRecord> runs(const RunFilter& filter) const;
  [[nodiscard]] RunRecord run(std::int64_t number) const;
  [[nodiscard]] std::vector<BranchRecord> branches(std::int64_t run) const;
  [[nodiscard]] std::vector<FrameRecord> frames(std::int64_t run) const;  // in the order written
  void for_each_frame(std::int64_t run,
                      const std::function<void(const FrameRecord&)>& see) const;  // only one in memory at a time
  [[nodiscard]] std::int64_t frame_count(std::int64_t run) const;
  [[nodiscard]] std::int64_t void_frame_count(std::int64_t run) const;     // in void branches
  [[nodiscard]] std::int64_t flagged_frame_count(std::int64_t run) const;  // with any flag, also in void branches
  [[nodiscard]] int scans_of_first_frame(std::int64_t run) const;          // 0: the run has no frame
  [[nodiscard]] std::vector<EventRecord> events(std::int64_t run) const;
  // Newest first, until `see` returns false; the others are not read.
  void newest_events(std::int64_t run, const std::function<bool(const EventRecord&)>& see) const;
  [[nodiscard]] std::vector<CheckRecord> checks(std::int64_t run) const;
  [[nodiscard]] std::vector<SeriesRecord> series(std::int64_t run) const;  // by sequence, then taxel
  // The newest check of that kind and verdict from an earlier run of this sensor; void runs do not count.
  [[nodiscard]] std::optional<CheckRecord> last_check(const std::string& sensor_serial, const std::string& kind,
                                                      const std::string& verdict, std::int64_t before_run) const;
  [[nodiscard]] std::int64_t last_time_ns(std::int64_t run) const;  // time of its newest frame or event; 0: none

  // For time estimates; fast, because no frame is read. The sequences of the `newest` completed runs of a bench, newest
  // first.
  [[nodiscard]] std::vector<TimedSequence> timed_sequences(const std::string& bench_id, int newest) const;
  [[nodiscard]] std::int64_t last_position(
      std::int64_t run) const;  // position of the run's last frame, from 1; 0: no frame
  [[nodiscard]] std::optional<FrameTime> frame_time(std::int64_t run, std::int64_t position) const;
  [[nodiscard]] std::vector<TimedEvent> timed_events(std::int64_t run) const;  // in the order written

  // Checks that a run's rows are unchanged since it ended. Accepts any run; one that has not ended has no stored hash,
  // so only the chain's links are checked.
  [[nodiscard]] ContentCheck check_content(std::int64_t run) const;
  // Checks that the run's fits, verdicts, approvals and void are unchanged since they were stored: one line per
  // difference.
  [[nodiscard]] std::vector<std::string> check_seals(std::int64_t run) const;
  // SQLite's own checks of the file (integrity_check, foreign_key_check), foreign objects, and gaps in the numbers of
  // runs and baselines, because none is ever deleted: one line per defect; empty: none.
  [[nodiscard]] std::vector<std::string> check_structure() const;
  // Copies the present state of the store into a new file, even while another process writes a run. TB-STORE-EXISTS
  // when the file exists already; a copy that fails leaves no file.
  void snapshot(const std::string& path) const;
  // Copies ended runs of another store with their sensors, fits and verdicts; returns their numbers here. Copies all or
  // none: TB-STORE-EXISTS if one is here already (same UUID), TB-STORE-CONFLICT if one has changed since it was stored,
  // has not ended, or its sensor is registered differently here. Models, verdicts and approvals must also be unchanged.
  // Verdicts are copied with the judged run; without it they are left out, even if the run of the models is copied.
  std::vector<std::int64_t> copy_runs_from(const RunStore& other, const std::vector<std::int64_t>& runs);
  // For copies of runs from several stores with one run each. number_next_run(): the next run gets this number, or the
  // next free one above it. The second function sets the fits of the run's verdicts, in the order of verdicts(); 0:
  // unchanged.
  void number_next_run(std::int64_t number);
  void link_verdicts(std::int64_t run, const std::vector<std::int64_t>& fits);
  // The run with this UUID, which is the same run in every store; 0: none.
  [[nodiscard]] std::int64_t run_of_uuid(const std::string& uuid) const;

  // SHA-256 chained over the run's canonical content: everything except UUID, wall-clock times and time zone, host,
  // tags, notes and the run's number, which belongs to the file (hash_chain.h). Recomputed from the stored rows;
  // TB-STORE-PRUNED if the frames were removed.
  [[nodiscard]] std::string content_hash(std::int64_t run) const;

  // Models and verdicts.
  std::int64_t add_fit(const FitRecord& fit);
  // The newest fit marked `stands`; if there is none, the newest fit.
  [[nodiscard]] std::optional<FitRecord> default_fit(std::int64_t run) const;
  [[nodiscard]] FitRecord fit(std::int64_t fit) const;
  [[nodiscard]] std::vector<FitRecord> fits(std::int64_t run) const;  // oldest first
  // Replaces the run's verdicts by the same limits from any fit of the same model on the same run as `fit`. Verdicts
  // from other models or by other limits stay: a later limits file does not undo a verdict by an earlier one. fit 0:
  // judged without a stored fit.
  void replace_verdicts(std::int64_t run, std::int64_t fit, const std::vector<VerdictRecord>& verdicts);
  [[nodiscard]] std::vector<VerdictRecord> verdicts(
      std::int64_t run) const;  // verdicts on the run, in the order stored
  // Verdicts on any run, from all fits that were made from this run; in the order stored.
  [[nodiscard]] std::vector<VerdictRecord> verdicts_of_models(std::int64_t run) const;

  // Figures tracked over time. Replaces all figures of this subject in this run.
  void replace_figures(std::int64_t run, const std::string& subject, const std::map<std::string, double>& figures);
  // Figures of runs that are not void, by run, then name. Empty subject: figures of all subjects.
  [[nodiscard]] std::vector<FigureRecord> figures(const std::string& subject) const;
  [[nodiscard]] std::vector<std::string> subjects() const;  // of all figures, by name
  [[nodiscard]] std::vector<std::string> subjects_of(std::int64_t run) const;
  [[nodiscard]] std::map<std::string, double> figures_of(std::int64_t run, const std::string& subject) const;
  // TB-STORE-BLANK without reason or name. TB-STORE-CONFLICT without date or runs, for a void run, for a run without
  // figures of the subject, for runs of several origins, and for several runs that all repeat the same run, so that no
  // figure has a spread.
  std::int64_t add_baseline(const BaselineRecord& baseline);
  // Copies a baseline that was accepted in another store, with the numbers of its runs here; it is not judged again.
  // TB-STORE-CONFLICT when a run does not exist.
  std::int64_t copy_baseline(const BaselineRecord& baseline);
  [[nodiscard]] std::vector<BaselineRecord> baselines() const;  // oldest first; the last one of a subject is in use
  [[nodiscard]] std::optional<BaselineRecord> last_baseline(const std::string& subject) const;
  // The runs of `runs` that repeat an earlier one, each with that earlier run: they have the same content (and so the
  // same seeds), or the same value of every figure of the subject, unless all figures are whole numbers. A repetition
  // adds nothing to the spread.
  [[nodiscard]] std::map<std::int64_t, std::int64_t> repeated_runs(const std::string& subject,
                                                                   std::vector<std::int64_t> runs) const;
  // The newest run before `before` with these seeds and figures of this subject; 0: none.
  [[nodiscard]] std::int64_t last_run_of(const std::string& subject, std::int64_t seed, std::int64_t sensor_seed,
                                         std::int64_t before) const;
  // Approved reports. TB-STORE-BLANK without name, TB-STORE-CONFLICT when that number is approved already, or when
  // `replaces` is not the last approved report; a report that replaces another needs a reason (TB-STORE-BLANK), others
  // must not have one.
  void add_report(const ReportRecord& report);
  [[nodiscard]] std::vector<ReportRecord> reports(std::int64_t run) const;  // oldest first
  [[nodiscard]] std::vector<ReportRecord> reports() const;                  // of all runs

  // Nights. add_night: TB-STORE-CONFLICT when a result names a run that is not there.
  std::int64_t add_night(const NightRecord& night);
  [[nodiscard]] std::vector<NightRecord> nights() const;  // oldest first

  // Removal of frames by a retention rule (run_store_copy.cpp); all other data of the run stay. Empty: the frames may
  // be removed; else why not: not simulated, not of a night, not ended, void, pinned (tag), in an approved report, used
  // by the models of such a run, no frames.
  [[nodiscard]] std::string why_not_pruned(std::int64_t run) const;
  // One transaction. TB-STORE-CONFLICT if they may not be removed, or if the run has changed since it was stored.
  PrunedRecord prune_frames(std::int64_t run, const std::string& rule, const std::string& utc);
  [[nodiscard]] std::optional<PrunedRecord> pruned(std::int64_t run) const;
  void shrink();  // returns the file's free pages to the file system; needs as much free space as the store, and
                  // exclusive use of it

  [[nodiscard]] const std::string& path() const;
  // TB-STORE-GONE when the file was removed, moved, replaced or cut off; data that is written still goes into the open
  // file.
  void require_in_place() const;
  // Saves a complete copy of the open store, whose file was moved or removed, next to its old path (or in the system's
  // temporary folder) and returns the name. Removes the log at the old path, which would damage the next store there.
  // Throws TB-STORE-GONE if the open store is no longer complete.
  [[nodiscard]] std::string rescue() const;

 private:
  class Database;
  struct Sealed {
    std::int64_t count = 0;
    std::string sha256;
  };
  explicit RunStore(std::unique_ptr<Database> database);
  [[nodiscard]] Sealed sealed_now(std::int64_t run, const std::string& kind) const;
  void seal(std::int64_t run, const std::string& kind);  // part of the caller's transaction
  std::unique_ptr<Database> database_;
};

// SHA-256 of `text` as 64 hex digits.
std::string sha256_hex(const std::string& text);
// Random UUID, version 4 (RFC 9562).
std::string new_uuid();

}  // namespace tactbench::db
