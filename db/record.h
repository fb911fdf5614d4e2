// The rows of the run store as plain structs, for all that write and read it; the last function of
// the file averages the scans of a frame. Units are in the names; times are process time in nanoseconds since the run's
// start unless called utc. The schema is in schema.cpp. For columns that need no conversion, kColumns names them and
// row() ties their members, in the same order, so that writing, reading and hashing (hash_chain.h) use one list.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#define TACTBENCH_ROW_AS(row, columns, names, ...)   \
  auto row() { return std::tie(__VA_ARGS__); }       \
  auto row() const { return std::tie(__VA_ARGS__); } \
  static constexpr const char* columns = names
#define TACTBENCH_ROW(row, columns, ...) TACTBENCH_ROW_AS(row, columns, #__VA_ARGS__, __VA_ARGS__)

namespace tactbench::db {

// How a run ended; separate from its state (set by the sequencer) and from its verdict (judged by limits).
enum class Outcome { kIncomplete, kCompleted, kStopped, kAborted, kFailed, kInterrupted };
enum class SafeState { kUnknown, kVerified, kUnverified, kFailed };
const char* to_string(Outcome outcome);
const char* to_string(SafeState state);
std::optional<Outcome> outcome_from(const std::string& word);
std::optional<SafeState> safe_state_from(const std::string& word);

struct SensorRecord {
  std::string serial;     // primary key
  std::string type;       // name of the type in its sensor file
  std::string type_toml;  // the sensor file's text
  std::string type_sha256;
  std::string scanner_serial;  // a model is bound to sensor and scanner
  std::string note;
  std::string added_utc;
  TACTBENCH_ROW(row, kColumns, serial, type, type_toml, type_sha256, scanner_serial, note, added_utc);
};

struct DeviceRecord {
  std::string role, model, serial, firmware, origin;
  std::string calibration_json;  // spans, certificate, due date: everything that scales the raw counts of this device
  TACTBENCH_ROW(row, kColumns, role, model, serial, firmware, origin, calibration_json);
};

struct SequenceRecord {
  int sequence = 0;  // 0-based within the run
  std::string name;
  std::string recipe_toml;  // text of the recipe file
  std::string recipe_sha256;
  int repeats = 0;
  int frames_per_repeat = 0;
  TACTBENCH_ROW(row, kColumns, sequence, name, recipe_toml, recipe_sha256, repeats, frames_per_repeat);
};

struct RunRecord {
  std::int64_t run = 0;  // short number, assigned by the store
  std::string uuid;
  std::string origin;  // simulated | hardware | imported
  std::string state;   // bench/run/control/run_status.h
  Outcome outcome = Outcome::kIncomplete;
  std::string reason;  // reason of the outcome; starts with the error identifier
  SafeState safe_state = SafeState::kUnknown;
  std::string operator_name, purpose, sensor_serial, scanner_serial;
  std::string bench_id, bench_toml, bench_sha256, sensor_toml, sensor_sha256;
  std::string overrides_json;  // --set k=v and seeds, as given
  std::string program_version, git_commit, build_id, host, time_zone;
  bool git_dirty = false;
  std::int64_t seed = 0, sensor_seed = 0;
  std::string started_utc, ended_utc, seen_utc;
  std::optional<double> rest_s;  // between the sensor's last load and this run, by the wall clock
  std::string content_sha256;    // end of the hash chain over the canonical content; empty until the run ends
  // Users' remarks on the run.
  std::vector<std::string> tags;               // sorted
  std::string notes;                           // lines
  std::string void_reason, void_by, void_utc;  // empty: the run counts
  [[nodiscard]] bool is_void() const { return !void_utc.empty(); }
  std::vector<SequenceRecord> sequences;
  std::vector<DeviceRecord> devices;
  double lowest_psi = 0.0, highest_psi = 0.0;  // of its branches; not written, and not in lists of runs
  // Of its content, in the order of the hash; of what else is known when it begins; of what comes later.
  TACTBENCH_ROW_AS(content, kContent,
                   "origin, operator, purpose, sensor_serial, scanner_serial, bench_id, bench_toml, bench_sha256, "
                   "sensor_toml, sensor_sha256, overrides_json, program_version, git_commit, build_id, git_dirty, "
                   "seed, sensor_seed",
                   origin, operator_name, purpose, sensor_serial, scanner_serial, bench_id, bench_toml, bench_sha256,
                   sensor_toml, sensor_sha256, overrides_json, program_version, git_commit, build_id, git_dirty, seed,
                   sensor_seed);
  TACTBENCH_ROW(begun, kBegun, uuid, state, reason, host, time_zone, started_utc);
  TACTBENCH_ROW(later, kLater, ended_utc, content_sha256, seen_utc, rest_s, notes, void_reason, void_by, void_utc);
};

struct BranchRecord {
  std::int64_t branch = 0;  // assigned by the store
  int sequence = 0;
  int repeat = 0;
  int ordinal = 0;  // within the repeat, from 0
  int attempt = 0;  // 0: first attempt
  bool is_void = false;
  std::string void_reason;
  double from_psi = 0.0;
  double to_psi = 0.0;
  std::optional<double> from_n = {}, to_n = {};  // of a branch of force; then the pressures are 0
  TACTBENCH_ROW_AS(row, kColumns,
                   "sequence, repeat, ordinal, attempt, void, void_reason, from_psi, to_psi, from_n, to_n", sequence,
                   repeat, ordinal, attempt, is_void, void_reason, from_psi, to_psi, from_n, to_n);
};

// Data of a frame taken under an indenter.
struct WrenchRecord {
  double target_n = 0.0;
  double force_start_n = 0.0;        // at the dwell's start; pressing is positive here
  std::array<double, 6> wrench{};    // at frame time: Fx Fy Fz N, Tx Ty Tz N mm, in the sensor's frame
  std::array<double, 6> raw{};       // as read: counts or volts
  std::array<double, 3> place_mm{};  // x, y, z of the stage
  static constexpr const char* kColumns = "target_n, force_start_n, wrench, wrench_raw, place_mm";
};

// One poll of the pressures between two frames.
struct TracePoint {
  float before_frame_s = 0.0F;  // seconds before the frame's time
  float setpoint_psi = 0.0F, feedback_psi = 0.0F, reference_psi = 0.0F;
};

struct FrameRecord {
  std::int64_t branch = 0;
  int ordinal = 0;  // step within the repeat: 0 .. frames_per_repeat - 1
  double setpoint_psi = 0.0, feedback_psi = 0.0, reference_psi = 0.0;
  std::int32_t setpoint_counts = 0, feedback_counts = 0, reference_counts = 0;
  std::int64_t time_ns = 0;           // of the frame
  std::int64_t since_command_ns = 0;  // from the set-point's command to the frame
  std::int64_t in_band_ns = 0;        // time in band before the frame
  std::int64_t device_time_us = 0;    // scanner's own clock
  int status = 0;                     // scanner's status bits
  int exchanges = 0;                  // on all wires for this step
  int rows = 0, columns = 0, scans = 0;
  std::vector<std::uint16_t> counts;  // scans x rows x columns, row-major, scan slowest; stored little-endian
  std::string flags;                  // keywords separated by spaces: why the frame is not comparable; empty: it is
  std::vector<TracePoint> trace;      // polls since the previous frame
  std::optional<WrenchRecord> wrench;
  TACTBENCH_ROW(row, kColumns, branch, ordinal, setpoint_psi, feedback_psi, reference_psi, setpoint_counts,
                feedback_counts, reference_counts, time_ns, since_command_ns, in_band_ns, device_time_us, status,
                exchanges, rows, columns, scans, counts, flags, trace);
};

inline bool has_consistent_shape(const FrameRecord& frame) {
  if (frame.rows <= 0 || frame.columns <= 0 || frame.scans <= 0) return false;
  const auto size = [](int count) { return static_cast<std::size_t>(count); };
  const std::size_t counts = frame.counts.size();  // divides because a product might overflow
  if (counts % size(frame.rows) != 0 || counts / size(frame.rows) % size(frame.columns) != 0) return false;
  return counts / size(frame.rows) / size(frame.columns) == size(frame.scans);
}

// A judgement on the set-up, made before or during a run.
struct CheckRecord {
  std::int64_t run = 0;
  std::int64_t time_ns = 0;
  std::string kind;     // seating | warm-up | conditioning | mount | tare
  std::string verdict;  // pass | fail | warning
  std::string detail_json;
  std::vector<double> data;  // its meaning depends on the kind
  TACTBENCH_ROW(row, kColumns, time_ns, kind, verdict, detail_json, data);
};

// An imported run has series instead of frames: the samples of one taxel in one sequence, in the order of the table's
// rows, in the units named by the run's device of role "table".
struct SeriesRecord {
  int sequence = 0;
  int taxel = 0;
  std::vector<double> input, output;  // of equal length
  TACTBENCH_ROW(row, kColumns, sequence, taxel, input, output);
};

struct TimedSequence {  // identifies the work of a stored sequence, for comparison with a planned one
  std::int64_t run = 0;
  int sequence = 0;
  std::string recipe_sha256, overrides_json;
  int repeats = 0, frames_per_repeat = 0;
};

struct FrameTime {
  int sequence = 0, repeat = 0, ordinal = 0;
  bool is_void = false;  // its branch was redone
  std::int64_t time_ns = 0;
};

struct TimedEvent {  // a change of a run's state, or the beginning of a way back
  std::int64_t time_ns = 0;
  std::string kind, detail;
};

struct EventRecord {
  std::int64_t time_ns = 0;
  std::string kind;  // state | fault | safe | note | conditioning
  std::string id;    // stable identifier if it is a fault
  std::string detail;
  TACTBENCH_ROW(row, kColumns, time_ns, kind, id, detail);
};

// A fit of one run: the models of all taxels of a sensor, or of their mean. The document is complete; model, stands and
// fitted are copied from it.
struct FitRecord {
  std::int64_t fit = 0;
  std::int64_t run = 0;
  std::string model;     // model and its options: "elam", "elam, free run"
  bool stands = false;   // used for its run if no fit is named
  int fitted = 0;        // number of fitted taxels
  std::string document;  // JSON (analysis/identify/stored/model_document.h)
  std::string made_by;   // build and class of processor, for recomputation; empty: not known
  std::string program_version;
  std::string created_utc;
  TACTBENCH_ROW(row, kColumns, stands, fitted, model, document, made_by, program_version, created_utc);
};

struct VerdictRecord {
  std::int64_t run = 0;
  std::int64_t fit = 0;
  std::string criterion = "mean_compensation_error";
  std::string scope_kind = "array";  // array | level | span
  double value = 0.0, limit = 0.0;
  std::string unit = "psi";     // psi | FS | taxels
  std::string rule = "simple";  // decision rule applied
  std::string verdict;          // pass | conditional pass | conditional fail | fail | inconclusive
  std::string limits_toml, limits_sha256;
  std::int64_t model_run = 0;  // run from which the fit's models were made; 0: no stored fit; computed when reading
  double low_psi = 0.0, high_psi = 0.0;                        // range of the scope; equal for a level, 0 for the array
  std::string direction = "both";                              // both | up | down
  double share = 1.0;                                          // share of the taxels for which the figure must hold
  double expanded = std::numeric_limits<double>::quiet_NaN();  // U of the value; NaN: not known
  TACTBENCH_ROW_AS(row, kColumns,
                   "criterion, scope_kind, direction, unit, rule, verdict, limits_toml, limits_sha256, low_psi, "
                   "high_psi, taxel_share, value, expanded, limit_value",
                   criterion, scope_kind, direction, unit, rule, verdict, limits_toml, limits_sha256, low_psi, high_psi,
                   share, value, expanded, limit);
};

// A figure of a subject, tracked over time; from a run's analysis.
struct FigureRecord {
  std::int64_t run = 0;
  std::string subject;  // "nightly/paper", "sensor", "rig"
  std::string name;     // includes the unit
  double value = 0.0;
  // Data of the run; computed when reading.
  std::string origin;
  std::int64_t seed = 0, sensor_seed = 0;
};

// Runs accepted as normal by a person: later runs are compared with their spread.
struct BaselineRecord {
  std::int64_t baseline = 0;  // assigned by the store
  std::string subject, reason, accepted_by, accepted_utc;
  std::vector<std::int64_t> runs;
  TACTBENCH_ROW(row, kColumns, subject, reason, accepted_by, accepted_utc);
};

// A signed report. content_sha256: hash of the report's data.
struct ReportRecord {
  std::int64_t run = 0;
  std::string number, content_sha256, approved_by, approved_utc;
  std::string replaces;  // number of the report that it replaces; empty: none
  std::string reason;    // what changed and why; empty if it replaces none
  // The runs on which the report is based: its own run first, then those of its models and verdicts, then the further
  // runs named for it. A copy of the store gives runs new numbers; their content is unchanged.
  struct Evidence {
    std::int64_t run = 0;
    std::string content_sha256;
  };
  std::vector<Evidence> evidence = {};
  TACTBENCH_ROW(row, kColumns, number, content_sha256, approved_by, approved_utc, replaces);
};

// A night, or one of several parts of it (shard K of N), with the result of each scenario.
struct NightResultRecord {
  int position = 0;   // in the whole suite with its seeds, from 0
  std::string label;  // of the scenario
  std::string json;   // the scenario's result as measured, before it was compared with anything; numbers of runs are
                      // those of this store
  std::int64_t first_run = 0;  // 0: it made none
  TACTBENCH_ROW_AS(row, kColumns, "position, label, first_run, result_json", position, label, first_run, json);
};
struct NightRecord {
  std::int64_t night = 0;  // assigned by the store
  std::string suite, suite_file, suite_toml;
  std::string selection_json;  // which scenarios and seeds of the suite
  int shard = 1, shards = 1;   // 1 of 1: all of it
  std::string begun_utc, ended_utc, program;
  std::vector<NightResultRecord> results;  // by position
  TACTBENCH_ROW(row, kColumns, suite, suite_file, suite_toml, selection_json, shard, shards, begun_utc, ended_utc,
                program);
};

// Record of a run's frames after they were removed by a retention rule.
struct PrunedRecord {
  std::int64_t run = 0, frames = 0;
  std::int64_t bytes = 0;                          // removed bytes of counts and traces
  std::array<std::uint8_t, 32> header{}, chain{};  // first link of the hash chain, and the link of the last frame
  std::string frames_sha256;                       // hash_chain.h
  std::string rule, pruned_utc;
  TACTBENCH_ROW(row, kColumns, run, frames, bytes, header, chain, frames_sha256, rule, pruned_utc);
};

// Mean of the scans of one frame without outliers: samples that the other scans of the frame contradict. Counts are
// scans x taxels, scan slowest. Scans of a frame follow each other within milliseconds: a sample further than 5 % of
// the converter from what the others agree on is an outlier.
inline constexpr double kOutlierCounts = 0.05 * 65535.0;
inline constexpr std::uint16_t kConverterLimit = 65535;

// Outputs of the same taxel in the previous and the next frame, in any order; NaN: there is no such frame.
struct Nearby {
  double one, other;
};

// The value on which most samples of a taxel agree within kOutlierCounts. Of two samples that differ, the one clearly
// nearer to the neighbouring frames or, if there are none, the one that is not at an end of the converter's range. NaN:
// no sample is left out, because all agree or the outlier cannot be identified.
double consensus_count(std::span<const std::uint16_t> counts, std::size_t scans, std::size_t taxel, Nearby nearby);

// True when the scans of a taxel, or of any taxel, differ by more than kOutlierCounts.
bool disagree(std::span<const std::uint16_t> counts, std::size_t scans, std::size_t taxel);
bool scans_disagree(std::span<const std::uint16_t> counts, std::size_t scans);

// The mean of each taxel's scans, without outliers. `before`: the means of the previous frame; empty: there is none.
std::vector<double> scan_means(std::span<const std::uint16_t> counts, std::size_t scans,
                               std::span<const double> before = {});

}  // namespace tactbench::db
