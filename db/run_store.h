// The store of a bench, one SQLite file (WAL): runs, frames, events, models, verdicts. Each frame is one committed
// transaction, so a dying process loses nothing acknowledged. Not thread-safe: one owner; other processes may read.
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
  kFull,    // synchronous=FULL: survives a power failure; on hardware
  kNormal,  // survives the process's death; under the manual clock
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
  // The first difference from what was stored, as text for people, as far as the links kept with the frames show it;
  // empty: none.
  std::string difference;
  // The frames were removed by a rule: what is left of the run was checked, the frames were not.
  std::optional<PrunedRecord> pruned;
  [[nodiscard]] bool holds() const { return difference.empty(); }
};

// Schema version of the file, which is neither opened for writing nor migrated. TB-STORE-OPEN when it is not a store.
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

  // How long each call waits for the lock of another writer before it throws TB-STORE-LOCKED and has done nothing, so
  // that it may be repeated. 5 s without this.
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
  void set_rest(std::int64_t run, double rest_s);           // wall clock: no part of the canonical content
  void set_seen(std::int64_t run, const std::string& utc);  // last sign of life, for a resume
  // People's remarks on a run; none is canonical content, and all but void_run are possible in any state of the run.
  // A tag is one word of letters, digits and . _ : / + -; adding one twice or removing an absent one is not an error.
  // TB-STORE-TAG for another kind of tag.
  void set_tags(std::int64_t run, const std::vector<std::string>& add, const std::vector<std::string>& remove);
  void add_note(std::int64_t run, const std::string& text);  // appends a line
  // The run no longer counts, permanently; its rows stay. TB-STORE-BLANK without reason or name, TB-STORE-CONFLICT
  // without date, or when the run has not ended or is void already.
  void void_run(std::int64_t run, const std::string& reason, const std::string& by, const std::string& utc);
  // Closes the run: state ended, outcome, reason, safe state, content hash.
  void end_run(std::int64_t run, Outcome outcome, const std::string& reason, SafeState safe, const std::string& utc);
  // Marks every run that has not ended as interrupted, with an event and its content hash; returns their number. Call
  // it only when it is certain that no process is writing a run to this store.
  int mark_interrupted(const std::string& utc);
  // Reopens an ended run that was not completed: state prepared, outcome incomplete; `event` holds the reason and the
  // cause of its end. TB-STORE-CONFLICT for a completed or a running run, and for one whose content differs from what
  // was stored, because its next end would put a new hash over the changed content.
  void reopen_run(std::int64_t run, const EventRecord& event);

  // Reading. TB-STORE-NOT-FOUND names the existing runs. frames() and for_each_frame(): TB-STORE-PRUNED for a run whose
  // frames were removed.
  // Newest last; without sequences and devices. Found by index: what a filter leaves out costs nothing.
  [[nodiscard]] std::vector<RunRecord> runs() const;
  [[nodiscard]] std::vector<RunRecord> runs(const RunFilter& filter) const;
  [[nodiscard]] RunRecord run(std::int64_t number) const;
  [[nodiscard]] std::vector<BranchRecord> branches(std::int64_t run) const;
  [[nodiscard]] std::vector<FrameRecord> frames(std::int64_t run) const;  // in the order written
  void for_each_frame(std::int64_t run,
                      const std::function<void(const FrameRecord&)>& see) const;  // one in memory at a time
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
  [[nodiscard]] std::int64_t last_time_ns(std::int64_t run) const;  // of its newest frame or event; 0: none

  // For time estimates; cheap, no frame is read. The sequences of the `newest` completed runs of a bench, newest first.
  [[nodiscard]] std::vector<TimedSequence> timed_sequences(const std::string& bench_id, int newest) const;
  [[nodiscard]] std::int64_t last_position(std::int64_t run) const;  // of a frame in the run, from 1; 0: no frame
  [[nodiscard]] std::optional<FrameTime> frame_time(std::int64_t run, std::int64_t position) const;
  [[nodiscard]] std::vector<TimedEvent> timed_events(std::int64_t run) const;  // in the order written

  // Checks that a run's rows are those present when it ended. Accepts any run; one that has not ended has no stored
  // hash, so only its links are checked.
  [[nodiscard]] ContentCheck check_content(std::int64_t run) const;
  // Checks that the run's fits, verdicts, approvals and void are those that were stored: one line per difference.
  [[nodiscard]] std::vector<std::string> check_seals(std::int64_t run) const;
  // SQLite's own checks of the file (integrity_check, foreign_key_check), foreign objects, and missing runs and
  // baselines, since none is ever deleted: one line per defect; empty: none.
  [[nodiscard]] std::vector<std::string> check_structure() const;
  // Copies the present state of the store into a new file, even while another process writes a run. TB-STORE-EXISTS
  // when the file exists already; a copy that fails leaves no file.
  void snapshot(const std::string& path) const;
  // Copies ended runs of another store with their sensors, fits and verdicts; returns their numbers here. All or none:
  // TB-STORE-EXISTS when one is here already (same UUID), TB-STORE-CONFLICT when one is not as stored, has not ended,
  // or its sensor is registered differently here. Models, verdicts and approvals must be as stored, too. Verdicts are
  // copied with the judged run; without it they are left out, even if the models' run is copied.
  std::vector<std::int64_t> copy_runs_from(const RunStore& other, const std::vector<std::int64_t>& runs);
  // For copies of runs that come from several stores of one run each. The next run gets this number, or the next free
  // one above it. And the fits that the run's verdicts are by, in the order of verdicts(); 0: as it is.
  void number_next_run(std::int64_t number);
  void link_verdicts(std::int64_t run, const std::vector<std::int64_t>& fits);
  // The run with this UUID, which is the same run in every store; 0: none.
  [[nodiscard]] std::int64_t run_of_uuid(const std::string& uuid) const;

  // SHA-256 chained over the run's canonical content: everything except UUID, wall-clock times and time zone, host,
  // tags, notes and the run's number, which belongs to the file (hash_chain.h). Recomputed from the stored rows, frames
  // among them: TB-STORE-PRUNED without.
  [[nodiscard]] std::string content_hash(std::int64_t run) const;

  // Models and verdicts.
  std::int64_t add_fit(const FitRecord& fit);
  // The newest of those that stand for the run; where none does, the newest.
  [[nodiscard]] std::optional<FitRecord> default_fit(std::int64_t run) const;
  [[nodiscard]] FitRecord fit(std::int64_t fit) const;
  [[nodiscard]] std::vector<FitRecord> fits(std::int64_t run) const;  // oldest first
  // Replaces those of the run's verdicts that are by the same limits and from any fit of the same model on the same run
  // as `fit`. Verdicts from other models and by other limits stay: a later file does not undo an earlier one's verdict.
  // fit 0: judged without a stored fit.
  void replace_verdicts(std::int64_t run, std::int64_t fit, const std::vector<VerdictRecord>& verdicts);
  [[nodiscard]] std::vector<VerdictRecord> verdicts(std::int64_t run) const;  // on the run; in the order stored
  // Verdicts on any run, from all fits that were made from this run; in the order stored.
  [[nodiscard]] std::vector<VerdictRecord> verdicts_of_models(std::int64_t run) const;

  // Figures followed over time. Replaces all figures of this subject in this run.
  void replace_figures(std::int64_t run, const std::string& subject, const std::map<std::string, double>& figures);
  // Figures of runs that are not void, by run, then name. Empty subject: figures of all subjects.
  [[nodiscard]] std::vector<FigureRecord> figures(const std::string& subject) const;
  [[nodiscard]] std::vector<std::string> subjects() const;  // of all figures, by name
  [[nodiscard]] std::vector<std::string> subjects_of(std::int64_t run) const;
  [[nodiscard]] std::map<std::string, double> figures_of(std::int64_t run, const std::string& subject) const;
  // TB-STORE-BLANK without reason or name. TB-STORE-CONFLICT without date or runs, for a void run, for a run without
  // figures of the subject, for runs of several origins, and for several runs that all repeat one, so that no figure
  // has a spread.
  std::int64_t add_baseline(const BaselineRecord& baseline);
  // Copies a baseline that was accepted in another store, with the numbers of its runs here; it is not judged again.
  // TB-STORE-CONFLICT when a run does not exist.
  std::int64_t copy_baseline(const BaselineRecord& baseline);
  [[nodiscard]] std::vector<BaselineRecord> baselines() const;  // oldest first; of a subject the last one counts
  [[nodiscard]] std::optional<BaselineRecord> last_baseline(const std::string& subject) const;
  // Those of `runs` that repeat an earlier one of them, each with that earlier run: the same content (and so the same
  // seeds), or the same value of every figure of the subject, not all of them whole numbers. It adds nothing to a
  // spread.
  [[nodiscard]] std::map<std::int64_t, std::int64_t> repeated_runs(const std::string& subject,
                                                                   std::vector<std::int64_t> runs) const;
  // The newest run before `before` with these seeds and figures of this subject; 0: none.
  [[nodiscard]] std::int64_t last_run_of(const std::string& subject, std::int64_t seed, std::int64_t sensor_seed,
                                         std::int64_t before) const;
  // Approved reports. TB-STORE-BLANK without name, TB-STORE-CONFLICT when that number is approved already, or when
  // `replaces` is not the last approved report; one that replaces another has a reason (TB-STORE-BLANK), others none.
  void add_report(const ReportRecord& report);
  [[nodiscard]] std::vector<ReportRecord> reports(std::int64_t run) const;  // oldest first
  [[nodiscard]] std::vector<ReportRecord> reports() const;                  // of all runs

  // Nights. add_night: TB-STORE-CONFLICT when a result names a run that is not there.
  std::int64_t add_night(const NightRecord& night);
  [[nodiscard]] std::vector<NightRecord> nights() const;  // oldest first

  // Removal of frames that a rule gives up (run_store_copy.cpp); all else of the run stays. Empty: the frames may go;
  // else why they stay: not simulated, not of a night, not ended, void, pinned (tag), in an approved report, what the
  // models of such a run rest on, no frames.
  [[nodiscard]] std::string why_not_pruned(std::int64_t run) const;
  // One transaction. TB-STORE-CONFLICT when they may not go, or when the run is not as it was stored.
  PrunedRecord prune_frames(std::int64_t run, const std::string& rule, const std::string& utc);
  [[nodiscard]] std::optional<PrunedRecord> pruned(std::int64_t run) const;
  void shrink();  // gives the file's free pages back; needs as much space again, and nobody else in the store

  [[nodiscard]] const std::string& path() const;
  // TB-STORE-GONE when the file was removed, moved, replaced or cut off; what is written still goes into the open one.
  void require_in_place() const;
  // Saves the open store, whose file is not in its place, whole beside it (or in the system's temporary folder) and
  // returns the name; the log that it left at its old name, which would spoil the next store there, goes. Throws
  // TB-STORE-GONE where it is not whole any more.
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
