// A run's record as a Dataset, sample by sample: scales, noise, times, temperatures, and records that do not fit.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>

#include "analysis/dataset.h"
#include "analysis/scanner_scale.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

db::FrameRecord frame_of_two(std::int64_t branch, int ordinal, std::vector<std::uint16_t> counts) {
  db::FrameRecord frame;
  frame.branch = branch;
  frame.ordinal = ordinal;
  frame.setpoint_psi = 10.0 * ordinal;
  frame.reference_psi = 10.0 * ordinal + 0.5;
  frame.time_ns = 1'500'000'000 + 1'000'000'000LL * ordinal;
  frame.since_command_ns = 250'000'000;
  frame.rows = 1;
  frame.columns = 2;
  frame.scans = static_cast<int>(counts.size() / 2);
  frame.counts = std::move(counts);
  return frame;
}

// One sequence of two frames per repeat, two repeats; a scan has two taxels.
StoredRun record_of_four() {
  StoredRun run;
  run.record.run = 6;
  run.record.sequences = {{0, "s", "", "", 2, 2}};
  run.record.devices = {{"force sensor", "", "", "", "", "{}"},
                        {"tactile scanner", "", "", "", "", R"({"volts_per_count":0.001})"}};
  for (int repeat = 0; repeat < 2; ++repeat) {
    db::BranchRecord branch;
    branch.branch = 11 + repeat;
    branch.repeat = repeat;
    run.branches.push_back(branch);
  }
  run.frames = {frame_of_two(11, 0, {100, 7, 104, 7, 108, 7}), frame_of_two(11, 1, {200, 7, 200, 7, 200, 7}),
                frame_of_two(12, 1, {300, 7, 300, 7, 300, 7}), frame_of_two(12, 0, {150, 7, 150, 7, 150, 7})};
  return run;
}

std::string refusal_of(const StoredRun& run) {
  try {
    (void)load_dataset(run);
  } catch (const AnalysisError& error) {
    return error.id();
  }
  return {};
}

}  // namespace

TEST_CASE("load_dataset: times, references, mean volts of the scans, noise and step order match hand-computed values") {
  const Dataset data = load_dataset(record_of_four());
  CHECK((data.run == 6 && data.rows == 1 && data.columns == 2 && data.scans == 3));
  REQUIRE(data.sequences.size() == 1);
  REQUIRE(data.sequences[0].repeats.size() == 2);
  const Repeat &first = data.sequences[0].repeats[0], &second = data.sequences[0].repeats[1];
  CHECK((first.steps[1].setpoint_psi == 10.0 && first.steps[1].reference_psi == 10.5));
  CHECK(first.steps[1].time_s == Approx(2.5));
  CHECK(first.steps[1].held_s == Approx(0.25));
  CHECK(first.volts[0] == Approx(0.104));
  CHECK(first.volts[2] == Approx(0.2));
  CHECK(second.volts[0] == Approx(0.15));  // stored last, and the first step
  CHECK(second.volts[2] == Approx(0.3));
  // One frame of four has squares of 16 + 16 about its mean: 32 over 4 x 2 degrees of freedom, of a mean of three.
  CHECK(data.noise_v[0] == Approx(0.001 * std::sqrt(4.0 / 3.0)));
  CHECK(data.noise_v[1] == Approx(0.001 * std::sqrt(1.0 / 12.0 / 3.0)));  // the converter's own rounding
  CHECK((!data.at_limit[0] && !data.at_limit[1]));
}

TEST_CASE("load_dataset: unequal scan counts are weighted in the noise, single scans give no noise") {
  StoredRun run = record_of_four();
  run.frames[3] = frame_of_two(12, 0, {150, 65535});
  const Dataset data = load_dataset(run);
  // 3 + 3 + 3 + 1 scans of four frames: 2.5 in the mean, six degrees of freedom.
  CHECK(data.noise_v[0] == Approx(0.001 * std::sqrt(32.0 / 6.0 / 2.5)));
  CHECK((!data.at_limit[0] && !data.at_limit[1]));  // in one frame alone
  for (int i = 0; i < 4; ++i) run.frames[static_cast<std::size_t>(i)] = frame_of_two(11 + i / 2, i % 2, {5, 65534});
  const Dataset single = load_dataset(run);
  CHECK(single.noise_v == std::vector<double>{0.0, 0.0});
  CHECK(single.scans == 1);
  CHECK_FALSE(single.at_limit[1]);
}

TEST_CASE("load_dataset: incomplete repeats are left out, and a run without a complete repeat is refused") {
  StoredRun run = record_of_four();
  run.frames.erase(run.frames.begin());
  CHECK(load_dataset(run).sequences[0].repeats.size() == 1);
  CHECK(load_dataset(run).sequences[0].repeats[0].volts[0] == Approx(0.15));
  run.frames.pop_back();
  run.record.sequences.push_back({1, "t", "", "", 1, 5});
  CHECK(refusal_of(run) == "TB-ANALYSIS-EMPTY");
  run.record.sequences.clear();
  run.frames.clear();
  CHECK(refusal_of(run) == "TB-ANALYSIS-EMPTY");
}

TEST_CASE("load_dataset: frames that do not fit the run are refused, frames of void branches are not checked") {
  const auto with = [](auto change) {
    StoredRun run = record_of_four();
    change(run);
    return refusal_of(run);
  };
  CHECK(with([](StoredRun&) {}).empty());
  const double none = std::numeric_limits<double>::infinity();
  const std::vector<std::function<void(StoredRun&)>> changes = {
      [](StoredRun& run) { run.frames[1].rows = 2; },
      [](StoredRun& run) { run.frames[1].columns = 1; },
      [](StoredRun& run) { run.frames[1].scans = 0; },
      [](StoredRun& run) { run.frames[1].counts.pop_back(); },
      [](StoredRun& run) { run.frames[1].ordinal = 2; },
      [](StoredRun& run) { run.frames[1].ordinal = -1; },
      [=](StoredRun& run) { run.frames[1].setpoint_psi = none; },
      [=](StoredRun& run) { run.frames[1].reference_psi = none; },
      [](StoredRun& run) { run.frames[1].branch = 99; },
      [](StoredRun& run) { run.branches[1].sequence = 5; },
      [](StoredRun& run) { run.frames[1].ordinal = 0; },  // stored twice
      [](StoredRun& run) { run.record.sequences[0].frames_per_repeat = 10'000'001; },
      [](StoredRun& run) { run.record.sequences[0].frames_per_repeat = -1; }};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    CAPTURE(i);
    CHECK(with(changes[i]) == "TB-ANALYSIS-FRAME");
  }
  // A void branch of unknown frames is not checked.
  CHECK(with([](StoredRun& run) {
          run.branches[1].is_void = true;
          run.frames[2].rows = 9;
        }).empty());
}

TEST_CASE("volts per count: comes from the tactile scanner, and is refused unless it is a positive number") {
  const auto scale = [](const std::string& role, const std::string& json) {
    db::RunRecord run;
    run.devices = {{"tactile array", "", "", "", "", R"({"volts_per_count":9})"}, {role, "", "", "", "", json}};
    return volts_per_count(run);
  };
  CHECK(scale("tactile scanner", R"({"volts_per_count":0.25})") == 0.25);
  const std::string good = R"({"volts_per_count":1})";
  for (const auto& [role, json] :
       {std::pair("tactile scanner", std::string(R"({"volts_per_count":0})")),
        std::pair("tactile scanner", std::string(R"({"volts_per_count":-1})")),
        std::pair("tactile scanner", std::string(R"({"volts_per_count":"1"})")),
        std::pair("tactile scanner", std::string("{}")), std::pair("tactile scanner", std::string("[]")),
        std::pair("tactile scanner", std::string("no json")), std::pair("scanner", good)}) {
    CAPTURE(role, json);
    try {
      (void)scale(role, json);
      FAIL_CHECK("accepted");
    } catch (const AnalysisError& error) {
      CHECK(error.id() == "TB-ANALYSIS-NO-CALIBRATION");
    }
  }
}

TEST_CASE("load_dataset: temperatures come from environment events only, values that are not finite are refused") {
  StoredRun run = record_of_four();
  const auto event = [](const char* kind, const char* id, const char* detail) {
    db::EventRecord record;
    record.kind = kind;
    record.id = id;
    record.detail = detail;
    return record;
  };
  run.events = {event("environment", "temperature_c", "23.5"), event("environment", "humidity", "40"),
                event("note", "temperature_c", "9"), event("environment", "temperature_c", "-1e1")};
  CHECK(load_dataset(run).temperatures_c == std::vector<double>{23.5, -10.0});
  for (const char* odd : {"", "warm", "inf", "nan"}) {
    run.events = {event("environment", "temperature_c", odd)};
    CHECK(refusal_of(run) == "TB-ANALYSIS-FRAME");
  }
}

TEST_CASE("elapsed time: counts from the command, and a gap beyond 5 s of settling counts as conditioning") {
  const auto passed = [](double time_s, double held_s, double before_s) {
    const TimePassed found = time_passed({0, 0, time_s, held_s}, before_s);
    return std::pair(found.worked_s, found.step_s);
  };
  CHECK(passed(10, 2, 7) == std::pair(0.0, 3.0));    // one second of settling in addition to the command
  CHECK(passed(14, 2, 7) == std::pair(0.0, 7.0));    // five
  CHECK(passed(14.5, 2, 7) == std::pair(5.5, 2.0));  // more than that was conditioning
  CHECK(passed(6, 2, 7) == std::pair(0.0, 0.0));     // the clock went back
  // The first sample of a run: what passed since its start.
  CHECK(passed(1, 2, -1) == std::pair(0.0, 1.0));
  CHECK(passed(6, 2, -1) == std::pair(0.0, 2.0));
  CHECK(passed(30, 2, -1) == std::pair(28.0, 2.0));
  CHECK(passed(30, 2, 0) == std::pair(28.0, 2.0));
  CHECK(passed(4, 2, 0) == std::pair(0.0, 4.0));
}
