// What a dead-man's process is known to be by its answers: at watch, fired, ended, frozen, or blind to the module. Any
// thread may tell and ask.
#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "bench/guard/dead_man.h"

namespace tactbench::bench {

struct DeadManNews {  // for the record and for people
  std::string id;     // empty: good news
  std::string what;
};

class DeadManReports {
 public:
  // An answer is owed within `timeout`. `blind_ends`: the second failed reading of the module in a row makes it lost.
  DeadManReports(devices::Nanoseconds timeout, bool blind_ends) : timeout_(timeout), blind_ends_(blind_ends) {}

  void asked(devices::Nanoseconds now);  // a feeding was sent, which it answers
  // Its words: "fed", "fired", "blind: REASON" at each failed reading, "sees". Others are not for here.
  void heard(const std::string& word);
  void ended();  // nobody is at the other end of its channel
  // To be called when all that had come by `now` was heard: is an answer overdue?
  void judge(devices::Nanoseconds now);
  void excuse();  // it was kept busy at our wish: what it owes is asked for anew

  [[nodiscard]] bool fired() const;
  [[nodiscard]] std::optional<WatcherLost> lost() const;  // stays
  [[nodiscard]] std::vector<DeadManNews> take_news();     // since the last call, oldest first

 private:
  void heard_blind(const std::string& why);
  const devices::Nanoseconds timeout_;
  const bool blind_ends_;
  mutable std::mutex mutex_;
  std::optional<devices::Nanoseconds> owed_since_;  // the oldest feeding without an answer
  bool fired_ = false;
  int failed_reads_ = 0;  // in a row
  std::optional<WatcherLost> lost_;
  std::vector<DeadManNews> news_;
};

}  // namespace tactbench::bench
