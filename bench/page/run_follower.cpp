#include "bench/page/run_follower.h"

#include <filesystem>
#include <utility>

namespace tactbench::bench {

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
