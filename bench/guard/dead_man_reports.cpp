#include "bench/guard/dead_man_reports.h"

#include <fmt/format.h>

#include <string_view>
#include <utility>

namespace tactbench::bench {

using devices::Nanoseconds;

namespace {

constexpr int kFailedReadsToBeBlind = 2;
constexpr std::string_view kBlindPrefix = "blind: ", kBusyPrefix = "busy: ";

}  // namespace

void DeadManReports::asked(Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  if (!owed_since_) owed_since_ = now;
}

void DeadManReports::excuse() {
  const std::lock_guard lock(mutex_);
  owed_since_.reset();
}

void DeadManReports::heard(const std::string& word) {
  const std::lock_guard lock(mutex_);
  if (word == "fed") {
    owed_since_.reset();
  } else if (word == "fired") {
    fired_ = true;
  } else if (word.starts_with(kBlindPrefix)) {
    record_blind(word.substr(kBlindPrefix.size()));
  } else if (word.starts_with(kBusyPrefix)) {
    news_.push_back({"TB-MODBUS-BUSY", word.substr(kBusyPrefix.size())});
  } else if (word.starts_with(kDidPrefix)) {
    news_.push_back({"", word.substr(kDidPrefix.size())});
  } else if (word == "sees") {
    if (failed_reads_ > 0) news_.push_back({"", "the dead-man reaches the module again"});
    failed_reads_ = 0;
  }
}

void DeadManReports::record_blind(const std::string& why) {
  ++failed_reads_;
  const std::string what = fmt::format("the dead-man cannot reach the module: {}", why);
  if (failed_reads_ == 1) news_.push_back({kDeadManBlind, what});
  if (failed_reads_ < kFailedReadsToBeBlind || !blind_ends_ || lost_) return;
  lost_ = WatcherLost{kDeadManBlind, fmt::format("{}, {} times in a row", what, failed_reads_),
                      "Check that the module accepts a second connection and that no other program uses it; then start "
                      "again or `tactbench resume`."};
}

void DeadManReports::ended() {
  const std::lock_guard lock(mutex_);
  if (fired_ || lost_) return;
  lost_ = WatcherLost{kDeadManEnded, "the dead-man's process has ended",
                      "Find out what ended it (system log, memory), then start again or `tactbench resume`."};
}

void DeadManReports::judge(Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  if (fired_ || lost_ || !owed_since_ || now - *owed_since_ <= timeout_) return;
  lost_ = WatcherLost{
      kDeadManSilent,
      fmt::format("the dead-man does not answer: no message from it for {:.2f} s, {:g} s are allowed",
                  devices::in_seconds(now - *owed_since_), devices::in_seconds(timeout_)),
      "Its process is stopped, or the computer is overloaded: find out why, then start again or `tactbench resume`."};
}

bool DeadManReports::fired() const {
  const std::lock_guard lock(mutex_);
  return fired_;
}

std::optional<WatcherLost> DeadManReports::lost() const {
  const std::lock_guard lock(mutex_);
  return lost_;
}

std::vector<DeadManNotice> DeadManReports::take_notices() {
  const std::lock_guard lock(mutex_);
  return std::exchange(news_, {});
}

}  // namespace tactbench::bench
