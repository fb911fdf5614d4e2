#include "analysis/dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "analysis/counted.h"
#include "analysis/json_io.h"
#include "analysis/scanner_scale.h"
#include "db/record.h"

namespace tactbench::analysis {
namespace {

constexpr const char* kScannerRole = "tactile scanner";

}  // namespace

TimePassed time_passed(const Sample& sample, double before_s) {
  constexpr double kAccounted = 5.0;  // seconds that settling may take in addition to the commanded time
  const double passed = sample.time_s - std::max(before_s, 0.0);
  const bool worked = passed > sample.held_s + kAccounted;
  return {worked ? passed - sample.held_s : 0.0,
          worked || before_s < 0.0 ? std::min(passed, sample.held_s) : std::max(passed, 0.0)};
}

double volts_per_count(const db::RunRecord& run) {
  for (const db::DeviceRecord& device : run.devices) {
    if (device.role != kScannerRole) continue;
    const auto json = try_json(device.calibration_json);
    if (json.is_object() && json.contains("volts_per_count") && json["volts_per_count"].is_number()) {
      const double value = json["volts_per_count"].get<double>();
      if (std::isfinite(value) && value > 0.0) return value;
    }
    throw AnalysisError("TB-ANALYSIS-NO-CALIBRATION",
                        fmt::format("run {}: the scanner's calibration \"{}\" has no positive volts_per_count", run.run,
                                    device.calibration_json),
                        "record the scanner's volts_per_count in the bench file and run again");
  }
  throw AnalysisError("TB-ANALYSIS-NO-CALIBRATION",
                      fmt::format("run {} stores no device of role \"{}\"", run.run, kScannerRole),
                      "without it counts cannot be scaled: choose another run");
}

namespace {

// The frames of one repeat by ordinal; null where missing.
using Slots = std::vector<const db::FrameRecord*>;

// Statistics of the taxels from the frames of a run.
struct Gathered {
  explicit Gathered(std::size_t taxels) : sum_of_squares(taxels, 0.0), at_limit(taxels, 0), disagreeing(taxels, 0) {}
  std::vector<double> sum_of_squares;      // counts^2 about each frame's mean, per taxel
  std::vector<int> at_limit, disagreeing;  // frames
  std::int64_t degrees = 0;                // of freedom, the same for all taxels
  std::int64_t scans = 0, frames = 0, seen = 0;

  void see(const db::FrameRecord& frame) {
    ++seen;
    const auto scans_here = static_cast<std::size_t>(frame.scans);
    if (!db::scans_disagree(frame.counts, scans_here)) return;
    for (std::size_t taxel = 0; taxel < disagreeing.size(); ++taxel)
      if (db::disagree(frame.counts, scans_here, taxel)) ++disagreeing[taxel];
  }
  // True if its scans rarely disagree; frequent disagreement is noise or a loose contact.
  [[nodiscard]] bool alone(std::size_t taxel) const {
    constexpr std::int64_t kFew = 3, kOneIn = 100;
    return disagreeing[taxel] <= std::max(kFew, seen / kOneIn);
  }
};

// The value on which most scans of a frame agree (db::consensus_count), given the previous and next frames of its
// repeat.
double consensus_count(const Slots& slots, std::size_t i, std::size_t taxel) {
  const auto mean = [&](std::size_t at) {
    const std::vector<std::uint16_t>& counts = slots[at]->counts;
    const std::size_t taxels = counts.size() / static_cast<std::size_t>(slots[at]->scans);
    double sum = 0.0;
    for (std::size_t k = taxel; k < counts.size(); k += taxels) sum += counts[k];
    return sum / slots[at]->scans;
  };
  const double before = i > 0 ? mean(i - 1) : std::nan(""), after = i + 1 < slots.size() ? mean(i + 1) : before;
  return db::consensus_count(slots[i]->counts, static_cast<std::size_t>(slots[i]->scans), taxel,
                             {i > 0 ? before : after, after});
}

Repeat make_repeat(const Slots& slots, double scale, Dataset& dataset, Gathered& all) {
  const auto taxels = static_cast<std::size_t>(dataset.taxels());
  Repeat repeat;
  repeat.steps.reserve(slots.size());
  repeat.volts.reserve(slots.size() * taxels);
  for (std::size_t i = 0; i < slots.size(); ++i) {
    const db::FrameRecord* const frame = slots[i];
    repeat.steps.push_back({frame->setpoint_psi, frame->reference_psi, 1e-9 * static_cast<double>(frame->time_ns),
                            1e-9 * static_cast<double>(frame->since_command_ns)});
    const std::span<const std::uint16_t> counts = frame->counts;
    const bool disagree = db::scans_disagree(counts, static_cast<std::size_t>(frame->scans));
    for (std::size_t taxel = 0; taxel < taxels; ++taxel) {
      const double agreed = disagree && all.alone(taxel) ? consensus_count(slots, i, taxel) : std::nan("");
      const auto kept = [agreed](double count) { return !(std::abs(count - agreed) > db::kOutlierCounts); };
      double sum = 0.0, squares = 0.0, number = 0.0;
      bool at_limit = false;
      for (std::size_t k = taxel; k < counts.size(); k += taxels) {
        if (!kept(counts[k])) continue;
        at_limit = at_limit || counts[k] == db::kConverterLimit;
        sum += counts[k];
        number += 1.0;
      }
      const double mean = sum / number;
      for (std::size_t k = taxel; k < counts.size(); k += taxels)
        if (kept(counts[k])) squares += (counts[k] - mean) * (counts[k] - mean);
      dataset.outlying += frame->scans - static_cast<int>(number);
      if (at_limit) ++all.at_limit[taxel];
      all.sum_of_squares[taxel] += squares;
      repeat.volts.push_back(mean * scale);
    }
    all.degrees += frame->scans - 1;
    all.scans += frame->scans;
    ++all.frames;
  }
  return repeat;
}

void check_frame(const db::FrameRecord& frame, const Dataset& dataset, int frames_per_repeat) {
  const auto expected = static_cast<std::size_t>(frame.rows) * static_cast<std::size_t>(frame.columns) *
                        static_cast<std::size_t>(frame.scans);
  const bool geometry = frame.rows == dataset.rows && frame.columns == dataset.columns && frame.scans >= 1 &&
                        frame.counts.size() == expected;
  if (geometry && frame.ordinal >= 0 && frame.ordinal < frames_per_repeat && std::isfinite(frame.setpoint_psi) &&
      std::isfinite(frame.reference_psi))
    return;
  throw AnalysisError(
      "TB-ANALYSIS-FRAME",
      fmt::format("run {}: frame {} of branch {} does not fit the run (rows x columns x scans {} x {} x {}, {})",
                  dataset.run, frame.ordinal, frame.branch, frame.rows, frame.columns, frame.scans,
                  counted(frame.counts.size(), "count")),
      "check the store: tactbench verify");
}

double temperature_in(const db::EventRecord& event, std::int64_t run) {
  double celsius = 0.0;
  const char* end = event.detail.data() + event.detail.size();
  if (std::from_chars(event.detail.data(), end, celsius).ec == std::errc() && std::isfinite(celsius)) return celsius;
  throw AnalysisError("TB-ANALYSIS-FRAME",
                      fmt::format("run {}: the temperature \"{}\" is not a number", run, event.detail),
                      "check the store: tactbench verify");
}

// No recipe has more; a damaged number must not request so much memory.
constexpr int kMostFramesPerRepeat = 10'000'000;

}  // namespace

std::vector<double> temperatures_of(const StoredRun& run) {
  std::vector<double> celsius;
  for (const db::EventRecord& event : run.events)
    if (event.kind == "environment" && event.id == "temperature_c")
      celsius.push_back(temperature_in(event, run.record.run));
  return celsius;
}

Dataset load_dataset(const db::RunReader& store, std::int64_t run) {
  return load_dataset(read_run(store, store.run(run)));
}

Dataset load_dataset(const StoredRun& stored) {
  const db::RunRecord& record = stored.record;
  const std::int64_t run = record.run;
  const double scale = volts_per_count(record);
  const std::vector<db::FrameRecord>& frames = stored.frames;
  std::map<std::int64_t, db::BranchRecord> branches;
  for (const db::BranchRecord& branch : stored.branches) branches.emplace(branch.branch, branch);

  Dataset dataset;
  dataset.run = run;
  dataset.origin = record.origin;
  dataset.sensor_serial = record.sensor_serial;
  dataset.scanner_serial = record.scanner_serial;
  if (!frames.empty()) {
    dataset.rows = frames.front().rows;
    dataset.columns = frames.front().columns;
    dataset.scans = std::max(1, frames.front().scans);
  }
  dataset.temperatures_c = temperatures_of(stored);
  const auto taxels = static_cast<std::size_t>(dataset.taxels());
  dataset.noise_v.assign(taxels, 0.0);
  dataset.at_limit.assign(taxels, false);

  std::map<int, int> lengths;
  for (const db::SequenceRecord& sequence : record.sequences) {
    lengths[sequence.sequence] = sequence.frames_per_repeat;
    if (sequence.frames_per_repeat >= 0 && sequence.frames_per_repeat <= kMostFramesPerRepeat) continue;
    throw AnalysisError("TB-ANALYSIS-FRAME",
                        fmt::format("run {}: sequence {} states a repeat of {}", run, sequence.name,
                                    counted(sequence.frames_per_repeat, "frame")),
                        "check the store: tactbench verify");
  }
  std::map<std::pair<int, int>, Slots> repeats;  // by sequence, repeat
  Gathered all(taxels);
  for (const db::FrameRecord& frame : frames) {
    const auto branch = branches.find(frame.branch);
    if (branch == branches.end() || !lengths.contains(branch->second.sequence))
      throw AnalysisError("TB-ANALYSIS-FRAME",
                          fmt::format("run {}: a frame does not belong to any branch of the run", run),
                          "check the store: tactbench verify");
    if (branch->second.is_void) continue;
    const int length = lengths[branch->second.sequence];
    check_frame(frame, dataset, length);
    all.see(frame);
    Slots& slots = repeats[{branch->second.sequence, branch->second.repeat}];
    slots.resize(static_cast<std::size_t>(length), nullptr);
    const db::FrameRecord*& slot = slots[static_cast<std::size_t>(frame.ordinal)];
    if (slot != nullptr)
      throw AnalysisError(
          "TB-ANALYSIS-FRAME",
          fmt::format("run {}: step {} of repeat {} is stored in two branches, neither of which is void", run,
                      frame.ordinal, branch->second.repeat),
          "void one of the two branches: tactbench runs void");
    slot = &frame;
  }

  std::string missing;
  for (const db::SequenceRecord& sequence : record.sequences) {
    SequenceData data;
    data.name = sequence.name;
    std::int64_t best = 0;
    for (int repeat = 0; repeat < sequence.repeats; ++repeat) {
      const auto found = repeats.find({sequence.sequence, repeat});
      if (found == repeats.end()) continue;
      const auto absent = std::count(found->second.begin(), found->second.end(), nullptr);
      if (absent == 0) data.repeats.push_back(make_repeat(found->second, scale, dataset, all));
      best = std::max(best, static_cast<std::int64_t>(found->second.size()) - absent);
    }
    if (data.repeats.empty())
      missing += fmt::format("{}{}: {} of {} missing in the best repeat", missing.empty() ? "" : "; ", sequence.name,
                             sequence.frames_per_repeat - best, counted(sequence.frames_per_repeat, "frame"));
    else
      dataset.sequences.push_back(std::move(data));
  }
  if (dataset.sequences.empty())
    throw AnalysisError("TB-ANALYSIS-EMPTY",
                        fmt::format("run {} has no complete repeat ({})", run,
                                    missing.empty() ? std::string("it has no sequence") : missing),
                        "resume the run or choose a completed one: tactbench runs list");
  constexpr int kAgain = 2;  // a single frame at the limit does not mean that the load reaches it
  for (std::size_t taxel = 0; taxel < taxels; ++taxel) dataset.at_limit[taxel] = all.at_limit[taxel] >= kAgain;
  if (all.degrees > 0) {
    // Variance of one scan / K scans averaged; at least the converter's rounding error.
    const double mean_scans = static_cast<double>(all.scans) / static_cast<double>(all.frames);
    for (std::size_t taxel = 0; taxel < taxels; ++taxel) {
      const double variance = std::max(all.sum_of_squares[taxel] / static_cast<double>(all.degrees), 1.0 / 12.0);
      dataset.noise_v[taxel] = scale * std::sqrt(variance / mean_scans);
    }
  }
  return dataset;
}

StoredRun read_run(const db::RunReader& store, const db::RunRecord& record) {
  return {record, store.frames(record.run), store.branches(record.run), store.events(record.run),
          store.checks(record.run)};
}

}  // namespace tactbench::analysis
