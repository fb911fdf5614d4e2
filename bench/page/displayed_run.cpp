#include "bench/page/displayed_run.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "analysis/json_fields.h"
#include "bench/common/error_table.h"
#include "bench/common/terminal.h"
#include "bench/page/lists.h"
#include "bench/run/control/locks.h"

namespace tactbench::bench {
namespace {

constexpr std::size_t kShownEvents = 12;
constexpr std::chrono::milliseconds kReadAgain{3000};
constexpr std::chrono::milliseconds kReadAtMost{500};

// Commands to actuators, readings and accounts do not show progress.
bool is_displayed(const db::EventRecord& event) {
  constexpr std::array kQuiet{"command", "stage", "environment", "fail-safe", "relays", "time"};
  return std::ranges::find(kQuiet, event.kind) == kQuiet.end();
}

std::string current_readings_text(const RunReadings& now) {
  const auto tenths = [](double psi) { return std::round(10.0 * psi) / 10.0 + 0.0; };  // no "-0.0"
  std::string text =
      fmt::format("feedback {:.1f} psi, reference {:.1f} psi", tenths(now.feedback_psi), tenths(now.reference_psi));
  if (now.force_n) text += fmt::format(", force {:.2f} N", *now.force_n);
  return text;
}

bool rests(RunState state) { return state == RunState::kPaused || state == RunState::kSuspended; }

std::uint64_t inode_of(const std::string& path) {
  struct stat file {};
  return ::stat(path.c_str(), &file) == 0 ? file.st_ino : 0;
}

nlohmann::json event_json(const db::EventRecord& event) {
  const ErrorRow* error = error_row(event.id);
  return {{"time_s", static_cast<double>(event.time_ns) * 1e-9},
          JSON_FIELDS(event, kind, id),
          {"detail", one_line(event.detail, kMaxTextLength)},
          {"try", error != nullptr ? error->remedy : std::string_view()}};
}

}  // namespace

SafeStateText safe_state_text(const LiveRun* live, const StoredRun* stored,
                              const std::optional<db::EventRecord>& newest_safe) {
  if (live != nullptr) {
    const RunStatus& status = live->status;
    const std::string readings = status.readings ? current_readings_text(*status.readings) : "nothing is read yet";
    if (rests(status.state) && newest_safe && newest_safe->id == db::to_string(db::SafeState::kVerified))
      return {"proved", fmt::format("vented and proved: {} ({})", newest_safe->detail, readings)};
    if (rests(status.state)) return {"unknown", "not proved: " + readings};
    return {"loaded", "not vented: " + readings};
  }
  if (stored == nullptr) return {"none", ""};
  const db::RunRecord& run = stored->record;
  if (run.outcome == db::Outcome::kIncomplete || run.outcome == db::Outcome::kInterrupted)
    return {"unknown",
            "the run's process ended without a proof: on hardware its dead-man vents; read the chamber's own gauge"};
  const std::string detail = newest_safe ? newest_safe->detail : run.reason;
  if (run.safe_state == db::SafeState::kVerified) return {"proved", "proved at the end: " + detail};
  return {"unknown",
          fmt::format("{} at the end: {}; read the chamber's own gauge", db::to_string(run.safe_state), detail)};
}

const db::RunStore* DisplayedRun::store(std::string* why) {
  if (store_ && inode_of(db_) != file_) close();
  if (!store_) {
    try {
      file_ = inode_of(db_);
      store_ = db::RunStore::open_read_only(db_);
      unread_.clear();
    } catch (const db::StoreError& error) {
      unread_ = file_ == 0 ? fmt::format("there is no store {} yet: the first run makes it", db_) : error.what();
    }
  }
  if (why != nullptr) *why = unread_;
  return store_ ? &*store_ : nullptr;
}

void DisplayedRun::close() {
  frames_.reset();
  stored_.reset();
  store_.reset();
}

std::int64_t DisplayedRun::last_run() {
  std::int64_t last = 0;
  for (const db::RunRecord& run : store_->runs())
    if (bench_.empty() || run.bench_id == bench_) last = run.run;
  return last;
}

void DisplayedRun::look(const LiveRun* live) {
  const auto now = RealClock::now();
  std::string seen;
  if (live != nullptr)
    seen = fmt::format("{} {} {}", live->status.run, to_string(live->status.state), live->status.frames);
  const bool other = live != nullptr ? run() != live->status.run : was_live_;  // the end is also shown as stored
  new_picture_ =
      new_picture_ || (frames_ && was_live_ != (live != nullptr));  // the newest, or that at the highest load
  was_live_ = live != nullptr;
  const auto since = now - read_;
  if (since >= kReadAgain || (seen != seen_ && (since >= kReadAtMost || other))) {
    seen_ = seen;
    read_ = now;
    read_store(live);
  } else if (frames_ && !other &&
             frames_->position() < (live != nullptr ? live->status.frames + live->status.frames_void : last_frame_)) {
    update_frames();
  }
}

void DisplayedRun::update_frames() {
  try {
    new_picture_ = frames_->advance() || new_picture_;
  } catch (const db::StoreError& error) {
    unread_ = error.what();
    close();
  }
}

void DisplayedRun::read_store(const LiveRun* live) {
  if (store() == nullptr) return;
  try {
    read_run(live != nullptr ? live->status.run : last_run());
  } catch (const db::StoreError& error) {
    unread_ = error.what();
    return close();
  }
  if (frames_) update_frames();
}

void DisplayedRun::read_run(std::int64_t run) {
  if (run == 0) return;
  const bool other = !stored_ || stored_->record.run != run;
  if (other) {
    frames_.reset();
    frames_.emplace(*store_, store_->run(run));
  }
  stored_ = stored_run(*store_, run);
  const db::RunRecord& record = stored_->record;
  carried_out_.reset();
  if (record.outcome == db::Outcome::kIncomplete) carried_out_ = is_carried_out(store_->path(), run);
  events_.clear();
  newest_safe_.reset();
  store_->newest_events(run, [&](const db::EventRecord& event) {
    if (!newest_safe_ && event.kind == "safe") newest_safe_ = event;
    if (is_displayed(event) && events_.size() < kShownEvents) events_.push_back(event);
    return !newest_safe_ || events_.size() < kShownEvents;
  });
  last_frame_ = store_->last_position(run);
  calibration_ = record.outcome == db::Outcome::kIncomplete ? Standing() : calibration_of(*store_, run);
  if (!other) return;
  nights_ = stored_nights(*store_);
  before_ = 0;
  for (const db::RunRecord& earlier : store_->runs())
    if (earlier.run < run && earlier.sensor_serial == record.sensor_serial && !earlier.is_void() &&
        earlier.outcome == db::Outcome::kCompleted && earlier.origin == record.origin)
      before_ = earlier.run;
}

bool DisplayedRun::consume_new_picture() { return std::exchange(new_picture_, false); }

nlohmann::json DisplayedRun::picture() const { return frames_ ? frames_->picture(!was_live_) : nlohmann::json(); }

nlohmann::json readings_json(const LiveRun& live) {
  const RunStatus& status = live.status;
  nlohmann::json data = {{"run", status.run},
                         {"phase", one_line(status.phase, kMaxAnswerColumns)},
                         JSON_FIELDS(status, step, steps, frames, left_s, left_low_s, left_high_s)};
  if (status.target_n) data["target_n"] = *status.target_n;
  if (const auto& now = status.readings) {
    data.update({{"time_s", now->time_s},
                 {"setpoint_psi", now->setpoint_psi},
                 {"feedback_psi", now->feedback_psi},
                 {"reference_psi", now->reference_psi},
                 {"settled", now->settled}});
    if (now->force_n) data["force_n"] = *now->force_n;
  }
  return data;
}

nlohmann::json DisplayedRun::state(const LiveRun* live, double silent_s) const {
  const bool ours = live != nullptr && stored_ && stored_->record.run == live->status.run;
  nlohmann::json data = {
      {"live", live != nullptr}, {"silent_s", silent_s}, {"store", db_}, {"unread", unread_}, {"nights", nights_}};
  if (live != nullptr) {
    RunView view{*live, {}, unread_};
    if (ours) view.stored = stored_;
    data["view"] = view_json(view);
    data["view"]["question_id"] = live->status.question_id;
    if (const auto& answer = live->status.answer)
      data["view"]["answer"] = {{"question", answer->question}, {"text", answer->text}, {"who", answer->who}};
  } else if (stored_) {
    data["view"] = stored_json(*stored_, carried_out_);
    data["next"] = next_command(*stored_, db_);
    data["verdict"] = verdict_json(calibration_);
  }
  data["origin"] = stored_ ? stored_->record.origin : "";
  const bool shown = ours || live == nullptr;
  const SafeStateText safe =
      safe_state_text(live, shown && stored_ ? &*stored_ : nullptr, shown ? newest_safe_ : std::nullopt);
  data["safe"] = {{"state", safe.state}, {"words", one_line(safe.text, kMaxTextLength)}};
  data["before"] = shown ? before_ : 0;
  data["events"] = nlohmann::json::array();
  if (shown)
    for (const db::EventRecord& event : events_) data["events"].push_back(event_json(event));
  return data;
}

namespace {

constexpr std::chrono::seconds kAskForeignAgain{5};
constexpr std::chrono::seconds kFirstAnswer{
    5};  // a bench that sends nothing for so long is dropped in favour of the next one

bool same_file(const std::string& one, const std::string& other) {
  std::error_code ignored;
  return std::filesystem::weakly_canonical(one, ignored) == std::filesystem::weakly_canonical(other, ignored);
}

}  // namespace

RunFollower::RunFollower(HttpServer& server, std::string db, std::string bench, std::function<void()> heard)
    : server_(server), db_(std::move(db)), bench_(std::move(bench)), heard_(std::move(heard)) {}

double RunFollower::silent_s() const {
  return live_ ? std::chrono::duration<double>(RealClock::now() - last_).count() : 0.0;
}

void RunFollower::look() {
  const auto now = RealClock::now();
  if (connection_) {
    if (live_ || now - last_ < kFirstAnswer) return;
    let_go(false);
  }
  std::erase_if(foreign_, [now](const auto& asked) { return now - asked.second >= kAskForeignAgain; });
  for (const std::string& name : run_names(bench_)) {
    if (foreign_.contains(name)) continue;
    auto made = std::make_unique<RunConnection>(name, "follow", db_);
    if (!made->open()) {
      foreign_[name] = now;
      continue;
    }
    connection_ = std::move(made);
    name_ = name;
    last_ = now;
    watching_ = server_.watch(connection_->descriptor(), [this] { receive(); });
    return;
  }
}

void RunFollower::let_go(bool ours) {
  watching_.reset();
  connection_.reset();
  our_store_.clear();
  if (!ours) foreign_[name_] = RealClock::now();
  const bool was_live = live_.has_value();
  live_.reset();
  if (was_live) heard_();
}

void RunFollower::receive() {
  if (!connection_) return;
  std::optional<LiveRun> newest = connection_->newest();
  if (newest && newest->denied) return let_go(false);
  if (newest && newest->status.store != our_store_) {  // the file system is queried once, not at each message
    if (!same_file(newest->status.store, db_)) return let_go(false);
    our_store_ = newest->status.store;
  }
  if (newest) {
    live_ = std::move(newest);
    last_ = RealClock::now();
    heard_();
  }
  if (!connection_->open()) let_go(live_.has_value());
}

}  // namespace tactbench::bench
