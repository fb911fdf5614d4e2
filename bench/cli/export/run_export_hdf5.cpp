#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <type_traits>

#include "analysis/documents/run_json.h"
#include "analysis/json_io.h"
#include "bench/cli/export/hdf5_file.h"
#include "bench/cli/export/hdf5_nexus.h"
#include "bench/cli/export/run_export.h"
#include "bench/cli/export/run_export_csv.h"
#include "bench/common/error.h"
#include "bench/common/output_file.h"

namespace tactbench::bench {

namespace {

template <class Value, class Row, class Get>
std::vector<Value> hdf5_column(const std::vector<Row>& rows, Get get) {
  std::vector<Value> values;
  for (const Row& row : rows) values.push_back(static_cast<Value>(get(row)));
  return values;
}
using Reals = Hdf5File::Reals;
using Integers = Hdf5File::Integers;
using Texts = Hdf5File::Texts;

template <class Row, class Get>
Reals reals(const std::vector<Row>& rows, Get get) {
  return hdf5_column<double>(rows, get);
}
template <class Row, class Get>
Integers integers(const std::vector<Row>& rows, Get get) {
  return hdf5_column<std::int64_t>(rows, get);
}
template <class Row, class Get>
Texts texts(const std::vector<Row>& rows, Get get) {
  return hdf5_column<std::string>(rows, get);
}

// A column of the group that `path` lies in, along the group's axis.
template <class Value>
void column(Hdf5File& file, const std::string& path, const std::vector<Value>& values, const std::string& unit = {}) {
  static const std::map<std::string, std::string> axes = {{"/frames", "frame"},    {"/trace", "poll"},
                                                          {"/branches", "branch"}, {"/events", "event"},
                                                          {"/checks", "check"},    {"/verdicts", "judgement"}};
  if constexpr (std::is_same_v<Value, std::string>)
    file.array(path, values);
  else
    file.array(path, values, unit);
  file.axes_of(path, {axes.at(path.substr(0, path.rfind('/')))});
}

constexpr double kHdf5Absent = std::numeric_limits<double>::quiet_NaN();

// Texts, numbers and truth (0 or 1) of a document as attributes of the same names. Lists and trees are left to the
// caller, and null, which has no type.
void hdf5_attributes(Hdf5File& file, const std::string& object, const nlohmann::ordered_json& members) {
  for (const auto& [name, value] : members.items()) {
    if (value.is_string()) {
      file.attribute(object, name, value.get<std::string>());
    } else if (value.is_boolean()) {
      file.attribute(object, name, std::int64_t{value.get<bool>() ? 1 : 0});
    } else if (value.is_number_integer()) {
      file.attribute(object, name, value.get<std::int64_t>());
    } else if (value.is_number_float()) {
      file.attribute(object, name, value.get<double>());
    }
  }
}

std::string hdf5_joined(const nlohmann::ordered_json& words, const char* between) {
  return fmt::format("{}", fmt::join(words.get<std::vector<std::string>>(), between));
}

void hdf5_head(Hdf5File& file, const nlohmann::ordered_json& document, const db::RunRecord& run) {
  nlohmann::ordered_json members = document;
  members.erase("notes");  // may be longer than an attribute
  file.attribute("/", "schema", std::string("tactbench.run"));
  file.attribute("/", "version", std::int64_t{analysis::kRunSchemaVersion});
  hdf5_attributes(file, "/", members);
  file.attribute("/", "tags", hdf5_joined(document["tags"], " "));
  if (!run.rest_s) file.attribute("/", "rest_s", kHdf5Absent);
  file.group("/configuration");
  file.text("/configuration/bench_toml", run.bench_toml);
  file.text("/configuration/sensor_toml", run.sensor_toml);
  file.text("/configuration/overrides_json", run.overrides_json);
  file.text("/configuration/notes", run.notes);
}

void hdf5_recipes_and_devices(Hdf5File& file, const nlohmann::ordered_json& document, const db::RunRecord& run) {
  file.group("/recipes");
  for (std::size_t i = 0; i < run.sequences.size(); ++i) {
    const std::string path = fmt::format("/recipes/{}", run.sequences[i].sequence);
    file.group(path);
    hdf5_attributes(file, path, document["recipes"][i]);
    file.text(path + "/toml", run.sequences[i].recipe_toml);
  }
  file.group("/devices");
  for (std::size_t i = 0; i < run.devices.size(); ++i) {
    const std::string path = fmt::format("/devices/{}", i);
    file.group(path);
    hdf5_attributes(file, path, document["devices"][i]);
    file.attribute(path, "remarks", hdf5_joined(document["devices"][i]["remarks"], "; "));
    file.text(path + "/calibration_json", run.devices[i].calibration_json);
  }
}

// Volts per count from the scanner's calibration; absent where that does not state it.
double counts_scale(const db::RunRecord& run) {
  for (const db::DeviceRecord& device : run.devices) {
    const auto json = analysis::try_json(device.calibration_json);
    if (json.is_object() && json.contains("volts_per_count") && json["volts_per_count"].is_number())
      return json["volts_per_count"].get<double>();
  }
  return kHdf5Absent;
}

void hdf5_counts(Hdf5File& file, const db::RunRecord& run, const std::vector<db::FrameRecord>& frames) {
  std::vector<std::size_t> shape = {frames.size(), 0, 0, 0};
  if (!frames.empty()) {
    const db::FrameRecord& f = frames.front();
    shape = {frames.size(), static_cast<std::size_t>(f.scans), static_cast<std::size_t>(f.rows),
             static_cast<std::size_t>(f.columns)};
  }
  std::vector<std::uint16_t> counts;
  counts.reserve(shape[0] * shape[1] * shape[2] * shape[3]);
  for (const db::FrameRecord& f : frames) {
    if (f.counts.size() != shape[1] * shape[2] * shape[3] || f.rows != frames.front().rows ||
        f.columns != frames.front().columns)
      throw Error(ExitCode::kUsage, "TB-EXPORT-HDF5", "the run's frames are not all of one shape",
                  fmt::format("run {}", run.run), "take --format json, which holds frames of any shape");
    counts.insert(counts.end(), f.counts.begin(), f.counts.end());
  }
  file.axis("/frames/scan", shape[1]);
  file.axis("/frames/row", shape[2]);
  file.axis("/frames/column", shape[3]);
  file.array("/frames/counts", counts, "count", shape);
  file.axes_of("/frames/counts", {"frame", "scan", "row", "column"});
  file.attribute("/frames/counts", "volts_per_count", counts_scale(run));
}

void hdf5_wrenches(Hdf5File& file, const std::vector<db::FrameRecord>& frames) {
  if (std::ranges::none_of(frames, [](const db::FrameRecord& f) { return f.wrench.has_value(); })) return;
  db::WrenchRecord absent{kHdf5Absent, kHdf5Absent, {}, {}, {}};
  for (const std::span<double> none : {std::span<double>(absent.wrench), {absent.raw}, {absent.place_mm}})
    std::ranges::fill(none, kHdf5Absent);
  Reals target, start, wrench, raw, place;
  for (const db::FrameRecord& f : frames) {
    const db::WrenchRecord& w = f.wrench ? *f.wrench : absent;
    target.push_back(w.target_n);
    start.push_back(w.force_start_n);
    wrench.insert(wrench.end(), w.wrench.begin(), w.wrench.end());
    raw.insert(raw.end(), w.raw.begin(), w.raw.end());
    place.insert(place.end(), w.place_mm.begin(), w.place_mm.end());
  }
  column(file, "/frames/target_n", target, "N");
  column(file, "/frames/force_start_n", start, "N");
  // An array has one unit, a wrench two: its components say theirs.
  file.axis("/frames/component", {"fx_n", "fy_n", "fz_n", "tx_nmm", "ty_nmm", "tz_nmm"});
  file.axis("/frames/direction", {"x", "y", "z"});
  file.array("/frames/wrench", wrench, "", {frames.size(), 6});
  file.axes_of("/frames/wrench", {"frame", "component"});
  file.array("/frames/wrench_raw", raw, "", {frames.size(), 6});
  file.axis("/frames/channel", 6);
  file.axes_of("/frames/wrench_raw", {"frame", "channel"});
  file.array("/frames/place_mm", place, "mm", {frames.size(), 3});
  file.axes_of("/frames/place_mm", {"frame", "direction"});
}

void hdf5_trace(Hdf5File& file, const std::vector<db::FrameRecord>& frames) {
  Integers of_frame;
  std::vector<db::TracePoint> points;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    of_frame.insert(of_frame.end(), frames[i].trace.size(), static_cast<std::int64_t>(i));
    points.insert(points.end(), frames[i].trace.begin(), frames[i].trace.end());
  }
  file.group("/trace");
  file.axis("/trace/poll", points.size());
  column(file, "/trace/frame", of_frame);
  file.attribute("/trace/frame", "long_name", std::string("row of /frames"));
  column(file, "/trace/before_frame_s", reals(points, [](const auto& p) { return p.before_frame_s; }), "s");
  column(file, "/trace/setpoint_psi", reals(points, [](const auto& p) { return p.setpoint_psi; }), "psi");
  column(file, "/trace/feedback_psi", reals(points, [](const auto& p) { return p.feedback_psi; }), "psi");
  column(file, "/trace/reference_psi", reals(points, [](const auto& p) { return p.reference_psi; }), "psi");
}

void hdf5_frames(Hdf5File& file, const db::RunRecord& run, const std::vector<db::FrameRecord>& frames,
                 const std::vector<db::BranchRecord>& branches) {
  file.group("/frames");
  Integers branch_rows;
  for (const db::FrameRecord& f : frames) branch_rows.push_back(&branch_in(branches, f.branch) - branches.data());
  file.axis("/frames/frame", frames.size());
  column(file, "/frames/branch", branch_rows);
  file.attribute("/frames/branch", "long_name", std::string("row of /branches"));
  column(file, "/frames/step", integers(frames, [](const auto& f) { return f.ordinal; }));
  column(file, "/frames/setpoint_psi", reals(frames, [](const auto& f) { return f.setpoint_psi; }), "psi");
  column(file, "/frames/feedback_psi", reals(frames, [](const auto& f) { return f.feedback_psi; }), "psi");
  column(file, "/frames/reference_psi", reals(frames, [](const auto& f) { return f.reference_psi; }), "psi");
  column(file, "/frames/setpoint_counts", integers(frames, [](const auto& f) { return f.setpoint_counts; }), "count");
  column(file, "/frames/feedback_counts", integers(frames, [](const auto& f) { return f.feedback_counts; }), "count");
  column(file, "/frames/reference_counts", integers(frames, [](const auto& f) { return f.reference_counts; }), "count");
  column(file, "/frames/time_ns", integers(frames, [](const auto& f) { return f.time_ns; }), "ns");
  column(file, "/frames/since_command_ns", integers(frames, [](const auto& f) { return f.since_command_ns; }), "ns");
  column(file, "/frames/in_band_ns", integers(frames, [](const auto& f) { return f.in_band_ns; }), "ns");
  column(file, "/frames/device_time_us", integers(frames, [](const auto& f) { return f.device_time_us; }), "us");
  column(file, "/frames/status", integers(frames, [](const auto& f) { return f.status; }));
  column(file, "/frames/exchanges", integers(frames, [](const auto& f) { return f.exchanges; }));
  column(file, "/frames/flags", texts(frames, [](const auto& f) { return f.flags; }));
  hdf5_counts(file, run, frames);
  hdf5_wrenches(file, frames);
  hdf5_trace(file, frames);
  file.group("/branches");
  file.axis("/branches/branch", branches.size());
  column(file, "/branches/sequence", integers(branches, [](const auto& b) { return b.sequence; }));
  column(file, "/branches/repeat", integers(branches, [](const auto& b) { return b.repeat; }));
  column(file, "/branches/ordinal", integers(branches, [](const auto& b) { return b.ordinal; }));
  column(file, "/branches/attempt", integers(branches, [](const auto& b) { return b.attempt; }));
  column(file, "/branches/void", integers(branches, [](const auto& b) { return b.is_void ? 1 : 0; }));
  column(file, "/branches/void_reason", texts(branches, [](const auto& b) { return b.void_reason; }));
  column(file, "/branches/from_psi", reals(branches, [](const auto& b) { return b.from_psi; }), "psi");
  column(file, "/branches/to_psi", reals(branches, [](const auto& b) { return b.to_psi; }), "psi");
  column(file, "/branches/from_n", reals(branches, [](const auto& b) { return b.from_n.value_or(kHdf5Absent); }), "N");
  column(file, "/branches/to_n", reals(branches, [](const auto& b) { return b.to_n.value_or(kHdf5Absent); }), "N");
}

void hdf5_remarks(Hdf5File& file, const db::RunStore& store, std::int64_t run) {
  const std::vector<db::EventRecord> events = store.events(run);
  file.group("/events");
  file.axis("/events/event", events.size());
  column(file, "/events/time_ns", integers(events, [](const auto& e) { return e.time_ns; }), "ns");
  column(file, "/events/kind", texts(events, [](const auto& e) { return e.kind; }));
  column(file, "/events/id", texts(events, [](const auto& e) { return e.id; }));
  column(file, "/events/detail", texts(events, [](const auto& e) { return e.detail; }));
  const std::vector<db::CheckRecord> checks = store.checks(run);
  file.group("/checks");
  file.axis("/checks/check", checks.size());
  column(file, "/checks/time_ns", integers(checks, [](const auto& c) { return c.time_ns; }), "ns");
  column(file, "/checks/kind", texts(checks, [](const auto& c) { return c.kind; }));
  column(file, "/checks/verdict", texts(checks, [](const auto& c) { return c.verdict; }));
  column(file, "/checks/detail_json", texts(checks, [](const auto& c) { return c.detail_json; }));
  const std::vector<db::VerdictRecord> verdicts = store.verdicts(run);
  file.group("/verdicts");
  file.axis("/verdicts/judgement", verdicts.size());
  column(file, "/verdicts/criterion", texts(verdicts, [](const auto& v) { return v.criterion; }));
  column(file, "/verdicts/scope", texts(verdicts, [](const auto& v) { return v.scope; }));
  column(file, "/verdicts/value", reals(verdicts, [](const auto& v) { return v.value; }));
  column(file, "/verdicts/limit", reals(verdicts, [](const auto& v) { return v.limit; }));
  column(file, "/verdicts/unit", texts(verdicts, [](const auto& v) { return v.unit; }));
  column(file, "/verdicts/rule", texts(verdicts, [](const auto& v) { return v.rule; }));
  column(file, "/verdicts/verdict", texts(verdicts, [](const auto& v) { return v.verdict; }));
  column(file, "/verdicts/limits_sha256", texts(verdicts, [](const auto& v) { return v.limits_sha256; }));
  file.group("/series");
  std::size_t number = 0;
  for (const db::SeriesRecord& series : store.series(run)) {  // units: the device of role "table"
    const std::string path = fmt::format("/series/{}", number++);
    file.group(path);
    file.attribute(path, "sequence", std::int64_t{series.sequence});
    file.attribute(path, "taxel", std::int64_t{series.taxel});
    file.axis(path + "/sample", series.input.size());
    file.array(path + "/input", series.input);
    file.array(path + "/output", series.output);
    for (const char* name : {"/input", "/output"}) file.axes_of(path + name, {"sample"});
  }
}

}  // namespace

void put_run(Hdf5File& file, const db::RunStore& store, const db::RunRecord& run) {
  const nlohmann::ordered_json document = analysis::run_json(run);
  hdf5_head(file, document, run);
  hdf5_recipes_and_devices(file, document, run);
  hdf5_frames(file, run, store.frames(run.run), store.branches(run.run));
  hdf5_remarks(file, store, run.run);
  add_nexus(file, run);
}

std::size_t write_run_hdf5(const db::RunStore& store, const db::RunRecord& run, const std::string& path) {
  const HalfFile half = make_half_file(path);
  std::error_code ignored;
  try {
    const auto made = make_hdf5_file(half.name);
    put_run(*made, store, run);
    made->close();
    std::filesystem::rename(half.name, half.target);
  } catch (...) {
    std::filesystem::remove(half.name, ignored);
    throw;
  }
  return std::filesystem::file_size(half.target);
}

}  // namespace tactbench::bench
