#include "tests/faults/faulty_run.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "analysis/dataset.h"
#include "bench/simulation/plant.h"

namespace tactbench::tests {

using bench::Rig;
using bench::RigMoment;
using sequences::Step;
using sequences::StepKind;

namespace {

constexpr double kPatience_s = 30.0;  // of process time, after the end of the run
constexpr int kRepeats = 2;
const std::string kSerialBench = "simulated-serial.toml";
constexpr int kHeldUp = 2;  // times that a run may end by a time-out before its fault strikes, and is done anew

const std::string kLevels = R"(unit = "psi"
turning_points = [0, 60, 20, 60, 0]
step = 20
dwell_s = 0.5
repeats = 2
[conditioning]
cycles = 1
peak = 60
[guard]
tolerance_psi = 0.5
[retry]
branch = 1
)";

const std::string kPress = press_text(2) + "[retry]\nbranch = 1\n";

// Lost replies cost real time. A busy machine may need longer for an answer, though seldom: see kHeldUp.
std::vector<sequences::Override> impatient(const std::string& bench_file) {
  std::vector<sequences::Override> all = {
      {"scanner.frame_timeout_ms", "100"}, {"force.reply_timeout_ms", "100"}, {"stage.reply_timeout_ms", "100"}};
  const bool serial = bench_file == kSerialBench;
  all.push_back({serial ? "regulator.reply_timeout_ms" : "module.response_timeout_ms", "100"});
  return all;
}

bench::RunRequest request_for(Bench bench, const std::string& bench_file,
                              const std::vector<sequences::Override>& overrides) {
  bench::RunRequest request = small_request(overrides, {}, bench_file);
  request.recipes = {recipe_of(bench == Bench::kChamber ? kLevels : kPress)};
  request.assume_yes = true;
  return request;
}

// Whether the fault strikes (or the request to stop comes) before this step.
bool is_at(Point point, const Step& step) {
  const bool first = step.sequence == 0 && step.repeat == 0;
  const double psi = step.setpoint.value();
  switch (point) {
    case Point::kConditioning:
      return step.kind == StepKind::kConditioning && psi > 0.0;
    case Point::kRising:
      return first && step.kind == StepKind::kMeasure && step.branch == 0 && psi == 40.0;
    case Point::kTurning:
    case Point::kVent:
      return first && step.kind == StepKind::kMeasure && step.branch == 1 && psi == 40.0;
    case Point::kFalling:
      return first && step.kind == StepKind::kMeasure && step.branch == 1 && psi == 20.0;
    case Point::kLastBranch:
      return step.kind == StepKind::kMeasure && step.repeat == 1 && step.branch == 3;
    case Point::kHoming:
      return step.kind == StepKind::kHome;
    case Point::kApproach:
      return first && step.kind == StepKind::kApproach && step.branch >= 0;
    case Point::kPressing:
      return first && step.kind == StepKind::kPress && step.branch == 0 && step.force_n == 30.0;
    case Point::kReleasing:
    case Point::kRetreat:
      return first && step.kind == StepKind::kPress && step.branch == 1;
    case Point::kRetract:
      return first && step.kind == StepKind::kRetract && step.branch >= 0;
    default:
      return false;
  }
}

struct Truth {
  double psi = 0.0, force_n = 0.0;
  [[nodiscard]] bool safe() const { return psi < 1.0 && force_n < 0.5; }
};

// Strikes where it has to, and looks at the plant when the run has ended.
class Fate {
 public:
  Fate(Point point, const Breakage& breakage, bench::RunRequest& request, std::string store)
      : point_(point), breakage_(breakage), store_(std::move(store)) {
    request.on_rig = [this](Rig& rig, RigMoment moment) { see(rig, moment); };
    request.on_step = [this](const Step& step) { before(step); };
    if (point != Point::kPressing || !breakage.plan) return;
    bench::PlannedFault plan = *breakage.plan;
    plan.at_n = 15.0;
    request.bench.simulation->plant.faults.push_back(plan);
  }
  bool struck = false;
  Truth at_end, later;  // when the run ended, and half a minute on

 private:
  void see(Rig& rig, RigMoment moment) {
    rig_ = &rig;
    if (moment == RigMoment::kMade && point_ == Point::kOpening) strike();
    if (moment == RigMoment::kOpened && point_ == Point::kBaseline) strike();
    if (moment == RigMoment::kTearingDown && terminated_) strike();
    if (moment != RigMoment::kLeft) return;
    if (point_ == Point::kPressing && breakage_.plan) {
      struck = rig.plant()->faults().last(breakage_.plan->kind, rig.clock().now()).from.has_value();
    }
    at_end = truth();
    rig.clock().wait_until(rig.clock().now() + std::chrono::seconds(static_cast<int>(kPatience_s)));
    later = truth();
  }
  void before(const Step& step) {
    if (struck && breakage_.holds && !std::exchange(waited_, true)) {
      CHECK_FALSE(breakage_.holds());
      CHECK(truth().safe());
    }
    if (struck || terminated_ || (point_ == Point::kPressing && breakage_.plan) || !is_at(point_, step)) return;
    if (point_ == Point::kVent || point_ == Point::kRetreat) {
      terminated_ = true;
      raise(SIGTERM);
    } else {
      strike();
    }
  }
  void strike() {
    if (struck) return;
    struck = true;
    breakage_.strike(*rig_, store_);
  }
  [[nodiscard]] Truth truth() const {
    return {rig_->plant()->true_pressure().value(), rig_->plant()->true_force().value()};
  }
  const Point point_;
  const Breakage& breakage_;
  const std::string store_;
  Rig* rig_ = nullptr;
  bool terminated_ = false, waited_ = false;
};

// Nothing that was acknowledged is lost, nothing is there twice, and the hash is that of what is stored.
void check_frames(const db::RunStore& store, std::int64_t run, int acknowledged) {
  std::map<std::int64_t, db::BranchRecord> branches;
  for (const db::BranchRecord& branch : store.branches(run)) branches[branch.branch] = branch;
  const std::vector<db::FrameRecord> frames = store.frames(run);
  CHECK(static_cast<int>(frames.size()) == acknowledged);
  std::set<std::tuple<int, int, int>> valid;
  std::set<std::pair<std::int64_t, int>> all;
  for (const db::FrameRecord& frame : frames) {
    const db::BranchRecord& branch = branches.at(frame.branch);
    CHECK(all.emplace(frame.branch, frame.ordinal).second);
    if (branch.is_void) continue;
    CHECK(valid.emplace(branch.sequence, branch.repeat, frame.ordinal).second);
  }
  CHECK(store.run(run).content_sha256 == store.content_hash(run));
}

void check_complete(const db::RunStore& store, std::int64_t run) {
  const db::RunRecord row = store.run(run);
  CHECK(row.outcome == db::Outcome::kCompleted);
  CHECK(row.safe_state == db::SafeState::kVerified);
  const analysis::Dataset data = analysis::load_dataset(store, run);
  if (data.sequences.size() != 1) throw std::runtime_error("no data set of one sequence");
  CHECK(data.sequences[0].repeats.size() == kRepeats);
  for (const analysis::Repeat& repeat : data.sequences[0].repeats) {
    CHECK(static_cast<int>(repeat.steps.size()) == row.sequences[0].frames_per_repeat);
  }
}

void check_end(const bench::RunResult& result, const Fate& fate, const Breakage& breakage) {
  INFO("truth at the end: " << fate.at_end.psi << " psi, " << fate.at_end.force_n << " N");
  INFO("truth later: " << fate.later.psi << " psi, " << fate.later.force_n << " N");
  if (!breakage.beyond_reach) CHECK(fate.later.safe());
  if (result.safe == db::SafeState::kVerified) {
    CHECK(fate.at_end.safe());
    CHECK(fate.later.safe());
  } else {
    CHECK((result.error && result.error->code() == bench::ExitCode::kUnsafe));
  }
  CHECK((result.outcome == db::Outcome::kCompleted) == !result.error);
}

void check_row_closed(const db::RunStore& store, const bench::RunResult& result) {
  const db::RunRecord row = store.run(result.run);
  CHECK(row.state == "ended");
  CHECK(row.outcome == result.outcome);
  CHECK(row.safe_state == result.safe);
  CHECK(!row.ended_utc.empty());
  CHECK_THAT(row.reason, Catch::StartsWith(result.error ? result.error->id() + ": " : "all steps done"));
}

std::string text_of(const bench::RunResult& result, const std::string& after) {
  std::string cause;
  if (result.error) {
    cause = " " + result.error->id().substr(3);
  } else if (result.branches_redone > 0) {
    cause = fmt::format(", {} redone", result.branches_redone);
  }
  return fmt::format("{} {}{}, {}{}", db::to_string(result.outcome),
                     result.error ? static_cast<int>(result.error->code()) : 0, cause, db::to_string(result.safe),
                     after);
}

}  // namespace

namespace {

// The instruments answer as long as nothing has struck, so the machine has held them up.
bool held_up(const bench::RunResult& result, const Fate& fate) {
  return !fate.struck && result.error && Catch::EndsWith("-TIMEOUT").match(result.error->id());
}

std::string suffered(Bench bench, Point point, const Breakage& breakage, int held_up_before = 0) {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  std::vector<sequences::Override> settings = breakage.bench;
  const std::vector<sequences::Override> times = impatient(breakage.bench_file);
  settings.insert(settings.end(), times.begin(), times.end());
  bench::RunRequest request = request_for(bench, breakage.bench_file, settings);
  Fate fate(point, breakage, request, store.path());
  const bench::RunResult result = run_small(request, store);
  INFO((result.error ? result.error->id() + ": " + result.error->what() : std::string("completed"))
       << " / " << result.safe_text.in(tactbench::analysis::PressureUnit::kPsi));
  check_end(result, fate, breakage);
  if (held_up_before < kHeldUp && held_up(result, fate)) {
    WARN("before the fault the machine held an instrument up for longer than its time-out: done anew");
    return suffered(bench, point, breakage, held_up_before + 1);
  }
  CHECK(fate.struck);
  breakage.mend();
  if (breakage.store_gone) {
    CHECK(store.mark_interrupted(bench::utc_now()) == 1);
    CHECK(store.run(result.run).outcome == db::Outcome::kInterrupted);
  } else {
    check_row_closed(store, result);
  }
  check_frames(store, result.run, result.frames);
  if (!result.error) {
    check_complete(store, result.run);
    return text_of(result, "");
  }
  bench::RunRequest again = request_for(bench, breakage.bench_file, breakage.bench);
  again.resume = result.run;
  const bench::RunResult resumed = run_small(again, store);
  INFO("resumed: " << (resumed.error ? resumed.error->id() + ": " + resumed.error->what() : std::string("completed")));
  CHECK(!resumed.error);
  check_frames(store, result.run, result.frames + resumed.frames);
  check_complete(store, result.run);
  return text_of(result, std::string(breakage.store_gone ? ", interrupted" : "") +
                             (resumed.error ? ", NOT resumed" : ", resumed"));
}

}  // namespace

Breakage on_serial_bench(Breakage breakage) {
  breakage.bench_file = kSerialBench;
  return breakage;
}

std::string cell_of(Bench bench, Point point, const Breakage& breakage) {
  INFO(breakage.name << ", " << keyword_of(point));
  try {
    return suffered(bench, point, breakage);
  } catch (const std::exception& error) {
    FAIL_CHECK(error.what());
    return "BROKEN";
  }
}

}  // namespace tactbench::tests
