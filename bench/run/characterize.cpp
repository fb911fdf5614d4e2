#include "bench/run/characterize.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <thread>

#include "analysis/counted.h"
#include "bench/common/utc.h"
#include "bench/config/config.h"
#include "bench/config/config_calibration.h"
#include "bench/guard/trip.h"
#include "bench/rig/rig.h"
#include "bench/run/conductor.h"
#include "bench/run/control/control_socket.h"
#include "bench/run/control/locks.h"
#include "bench/run/end_reason.h"
#include "bench/run/recipe_check.h"
#include "bench/run/recorder.h"
#include "bench/run/resume.h"
#include "bench/run/run_record.h"
#include "bench/run/set_up.h"
#include "bench/run/time_estimate.h"
#include "bench/safety/safe_state.h"
#include "devices/device.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

namespace {

constexpr double kShortLock = 5.0;  // s, of the store by another program

// One run from its row to its end. Each part of the teardown is bounded in time, and a failure in one does not skip the
// next.
class RunLifecycle {
 public:
  RunLifecycle(const RunRequest& request, db::RunStore& store, Progress& progress)
      : request_(request), store_(store), progress_(progress), notify_(request.on_event), lock_(store.path()) {
    check_recipes(request.recipes, request.bench);
    refuse_placeholders(request.bench);
    check_geometry(request);
    refuse_tripped(request.bench);
    work_.recipes = request.recipes;
    work_.steps = sequences::compile(request.recipes);
    work_.on_step = request.on_step;
    work_.on_poll = [this] { check_store_in_place(); };
    work_.estimate = request.estimate;
    work_.assume_yes = request.assume_yes;
    if (!request.attended) control_.end_by_first_interrupt();
    if (request.resume != 0) {
      lock_.lock_for_resume(request.resume);
      ResumePoint point = reopen(store, request.resume, request.recipes, work_.steps);
      result_.run = request.resume;
      frames_before_ = store.frame_count(request.resume);
      offset_ = point.offset;
      work_.done = std::move(point.done);
    } else {
      result_.run = store.begin_run(record_of(request));
      lock_.lock_new_run(result_.run);
      if (const auto rest = rest_of_sensor(store, request.sensor.serial, result_.run)) {
        store.set_rest(result_.run, *rest);
      }
    }
    if (request.on_begun) request.on_begun(result_.run);
  }

  RunResult execute() {
    try {
      set_up();
      conductor_->run();
      if (conductor_) conductor_->press_steps().register_mount(request_.sensor_type.pitch_mm, baseline_);
      record_environment(*rig_, *recorder_);
      control_.finish(signals_);
    } catch (...) {
      ending_.by_exception(place());
    }
    board_.phase("venting, retracting, proving the safe state");
    progress_.finish();
    moment(RigMoment::kTearingDown);
    tear_down();
    close();
    moment(RigMoment::kLeft);
    return result_;
  }

 private:
  void moment(RigMoment which) {
    if (rig_ && request_.on_rig) request_.on_rig(*rig_, which);
  }

  [[nodiscard]] std::string place() const { return fmt::format("run {}, after frame {}", result_.run, frames_kept()); }
  [[nodiscard]] std::int64_t frames_kept() const { return frames_before_ + (recorder_ ? recorder_->frames() : 0); }

  void set_up() {
    RunStatus& status = board_.now();
    status.run = result_.run;
    status.store = std::filesystem::absolute(store_.path()).string();  // the client may have another working directory
    status.label = request_.label;
    status.frames_void = store_.void_frame_count(result_.run);
    status.frames = frames_before_ - status.frames_void;
    status.rate = request_.bench.in_process ? request_.pace : request_.bench.rate;
    board_.phase("opening the devices");
    control_.on_panic([this] {
      if (DeadManProcess* const dead_man = dead_man_) dead_man->fire();
    });
    socket_ = std::make_unique<ControlSocket>(request_.bench, control_, result_.run, request_.bench_name);
    BenchConfig bench = with_object(request_.bench, request_.recipes);
    devices::FrameSourceOptions& source = bench.scanner.frame_source;
    if (source.rows == 0) source.rows = request_.sensor_type.rows;
    if (source.columns == 0) source.columns = request_.sensor_type.columns;
    rig_ = std::make_unique<Rig>(std::move(bench));
    recorder_ = std::make_unique<Recorder>(store_, result_.run, rig_->clock(), offset_);
    recorder_->name_by([this](const std::string& text) { return rig_->as_stored(text); });
    rig_->guard().set_run(result_.run);
    rig_->guard().set_log(
        [this](devices::Nanoseconds, const std::string& actuator, const std::string& text, bool let_through) {
          if (!let_through || actuator != "pressure") log_command(let_through ? "command" : "refused", actuator, text);
        });
    sequencer_ = std::make_unique<Sequencer>(*rig_, *recorder_, control_, signals_);
    sequencer_->pace(request_.bench.in_process ? request_.pace : 0.0);
    sequencer_->follow(work_.recipes.front());
    recorder_->when_locked([this](const db::StoreError& locked, double waited_s) {
      if (waited_s > kShortLock) throw db::StoreError(locked);  // there is no pressure and no measurement yet
      sequencer_->stand();
      return true;
    });
    load_specimen(*rig_, request_.specimen_state_file);
    moment(RigMoment::kMade);
    rig_->open();
    moment(RigMoment::kOpened);
    dead_man_ = rig_->dead_man();
    if (rig_->dead_man() != nullptr) rig_->dead_man()->name_run(result_.run);
    keep_devices();
    control_.poll(signals_);  // commands that came while the devices opened
    board_.phase("reading the unloaded array");
    for (const std::string& layer : fail_safe_layers(request_.bench)) recorder_->event("fail-safe", "", layer);
    record_environment(*rig_, *recorder_);
    check_scanner(request_, rig_->array().identity().serial);
    baseline_ = sequencer_->read_unloaded_frame();
    conductor_ =
        std::make_unique<Conductor>(*sequencer_, *recorder_, control_, board_, notify_, std::move(work_), baseline_);
    conductor_->set_state(RunState::kRunning, "devices open, chamber unloaded");
    conductor_->run_through_suspensions(
        [&] { prepare_sensor(*sequencer_, *recorder_, store_, request_, baseline_, board_); });
  }

  void keep_devices() {
    if (needs_press(request_.recipes)) rig_->name_press_instruments();
    const std::vector<db::DeviceRecord> devices = rig_->devices();
    recorder_->write([this, devices] { bench::keep_devices(store_, result_.run, devices); });
    for (const std::string& line :
         calibration_warnings(request_.bench, devices, utc_now().substr(0, 10), sequences::compile(request_.recipes),
                              analysis::PressureUnit::kPsi))
      recorder_->event("warning", "TB-CALIBRATION", line);
  }

  void check_store_in_place() {
    store_.require_in_place();
    if (!lock_.renew(result_.run)) return;
    recorder_->event(
        "warning", "TB-STORE-LOCK",
        fmt::format("the lock file {}-lock was removed or replaced, and has been recreated: do not remove it",
                    store_.path()));
  }

  // A store that cannot be written delays or ends the run at its next frame or step, never a command.
  void log_command(const std::string& kind, const std::string& actuator, const std::string& text) {
    if (store_lost_) return;
    try {
      recorder_->log(kind, actuator, text);
    } catch (const db::StoreError&) {
      store_lost_ = true;
    }
  }

  void tear_down() {
    store_lost_ = store_lost_ || ending_.store_failed();
    proof_ = {db::SafeState::kVerified, std::string("no device was opened")};
    if (!rig_) return;
    if (sequencer_) (void)sequencer_->times().start(Spent::kTeardown);
    proof_ = make_safe(*rig_, baseline_);
    if (proof_.state == db::SafeState::kVerified) {
      rig_->dismiss_dead_man();
    } else if (rig_->dead_man() != nullptr) {
      dead_man_works_ = !rig_->dead_man()->take_over();
    }
    if (sequencer_) {
      (void)sequencer_->times().start(Spent::kTeardown);
      result_.time_spent = sequencer_->times().text();
      result_.waiting_seconds = sequencer_->times().seconds(Spent::kWaiting);
    }
    result_.process_seconds = devices::in_seconds(rig_->clock().now());
    if (ending_.error()) return;
    try {
      save_specimen(*rig_, request_.specimen_state_file);
    } catch (...) {
      ending_.by_exception(place());
    }
  }

  void close() {
    const devices::SteadyClock no_rig_clock;
    if (!recorder_) recorder_ = std::make_unique<Recorder>(store_, result_.run, no_rig_clock, offset_);
    result_.frames = recorder_->frames();
    result_.frames_kept = frames_kept();
    result_.most_exchanges_a_step = recorder_->max_exchanges();
    result_.store_seconds = recorder_->store_seconds();
    result_.branches_redone = conductor_ ? conductor_->redone() : 0;
    result_.safe = proof_.state;
    result_.safe_text = proof_.text;
    ending_.record_last_command(place());
    const bool safe = proof_.state == db::SafeState::kVerified;
    if (!safe) {
      ending_.by(Error("TB-SAFE-UNVERIFIED", "the safe state could not be proved", fmt::format("run {}", result_.run)));
    }
    result_.outcome = ending_.outcome();
    const std::string reason =
        ending_.error() ? fmt::format("{}: {}", ending_.error()->id(), ending_.error()->what()) : "all steps done";
    recorder_->when_locked(
        [this](const db::StoreError& locked, double waited_s) { return handle_store_lock(locked, waited_s); });
    try {
      write_end(reason);
    } catch (...) {  // the store itself failed: the row stays open and the next start marks it interrupted
      if (!ending_.error()) ending_.by_exception(place());
    }
    const std::optional<std::string> path_to_branch = save_lost_store();
    if (const std::optional<Error>& error = ending_.error()) {
      result_.error_state = proof_.text;
      result_.error_state +=
          fmt::format("; run {} kept with {}", result_.run, analysis::counted(result_.frames_kept, "frame"));
      StopRequest::keep();
      result_.error = error->with_rig_state(result_.error_state.in(analysis::PressureUnit::kPsi), safe)
                          .with_remedy(path_to_branch.value_or(error->remedy()));
    }
    notify_.run_command(ending_.error() ? "failed" : "done", result_.run, reason);
  }

  // The rig is safe, so the lock of another program is waited for; not long where something else has ended the run.
  bool handle_store_lock(const db::StoreError& locked, double waited_s) {
    constexpr double kLongest = 600.0;  // s
    const bool hurried = ending_.error() || signals_.signal() != 0;
    if (waited_s > (hurried ? kShortLock : kLongest)) throw db::StoreError(locked);
    if (!end_delayed_ && waited_s > kShortLock)
      board_.note("the run's end is not stored yet: " + std::string(locked.what()));
    end_delayed_ = end_delayed_ || waited_s > kShortLock;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return true;
  }

  // None: the store is in its place.
  std::optional<std::string> save_lost_store() {
    try {
      store_.require_in_place();
      return std::nullopt;
    } catch (const db::StoreError&) {
      if (!ending_.error()) ending_.by_exception(place());
    }
    try {
      return fmt::format(
          "the whole store, including this run, is saved as '{}': name it with --db, or move it to the place of the "
          "store",
          store_.rescue());
    } catch (const std::exception& error) {
      return fmt::format(
          "it could not be saved either ({}): if it was only moved, move {}-wal to it; if it was cut off, restore your "
          "last snapshot",
          error.what(), store_.path());
    }
  }

  void write_end(const std::string& reason) {
    if (rig_ && !rig_->relay_operations().empty()) {
      recorder_->event("relays", "",
                       fmt::format("closed {} times, row by row", fmt::join(rig_->relay_operations(), " ")));
    }
    if (rig_) record_notices(*rig_, *recorder_, progress_);
    if (dead_man_works_) {
      recorder_->event("dead-man", "",
                       fmt::format("it had not ended when the run was closed; its actions will be recorded in {}",
                                   TripFile(request_.bench.id).dead_man_path()));
    }
    ending_.write(*recorder_);
    if (!result_.time_spent.empty()) recorder_->event("time", "", result_.time_spent);
    if (conductor_) {
      conductor_->set_state(RunState::kStopping, reason);
    } else {
      recorder_->state(RunState::kStopping, reason);
    }
    recorder_->event("safe", to_string(proof_.state), proof_.text.in(analysis::PressureUnit::kPsi));
    recorder_->end(result_.outcome, reason, proof_.state);
    result_.content_sha256 = store_.run(result_.run).content_sha256;
  }

  const RunRequest& request_;
  db::RunStore& store_;
  Progress& progress_;
  Notify notify_;
  const StopRequest signals_;
  Control control_;
  StatusBoard board_{control_, progress_};
  EndReason ending_{control_, signals_};
  Work work_;
  RunLock lock_;  // of the run in its store
  devices::Nanoseconds offset_{0};
  std::int64_t frames_before_ = 0;  // of a resumed run
  RunResult result_;
  std::unique_ptr<Rig> rig_;
  std::unique_ptr<Recorder> recorder_;
  std::unique_ptr<Sequencer> sequencer_;
  std::unique_ptr<Conductor> conductor_;
  std::atomic<DeadManProcess*> dead_man_{nullptr};  // the rig's, for a panic
  std::unique_ptr<ControlSocket> socket_;
  UnloadedFrame baseline_;
  SafeProof proof_;
  bool end_delayed_ = false;     // and this was reported
  bool dead_man_works_ = false;  // it makes the bench safe, and had not ended in time
  bool store_lost_ = false;      // then the teardown does not wait for its locks
};

}  // namespace

RunResult characterize(const RunRequest& request, db::RunStore& store, Progress& progress) {
  return RunLifecycle(request, store, progress).execute();
}

}  // namespace tactbench::bench
