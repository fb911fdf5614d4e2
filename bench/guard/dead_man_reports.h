// State of a dead-man process derived from its answers: watching, fired, ended, frozen, or blind (it cannot reach the
// module). Thread-safe.
#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bench/guard/dead_man.h"

namespace tactbench::bench {

struct DeadManNotice {  // for the store and the operator
  std::string id;       // empty: good news
  std::string what;
};

inline constexpr std::string_view kDidPrefix = "did: ";  // a dead-man's last message, with what it has done

class DeadManReports {
 public:
  // An answer is due within `timeout`. `blind_ends`: a second failed reading of the module in a row makes the dead-man
  // lost.
  DeadManReports(devices::Nanoseconds timeout, bool blind_ends) : timeout_(timeout), blind_ends_(blind_ends) {}

  void asked(devices::Nanoseconds now);  // a feeding was sent, which it answers
  // The dead-man's messages: "fed", "fired", "blind: REASON" at each failed reading, "sees", "busy: WHAT" when the
  // module made it wait, and finally what it did. Others are ignored here.
  void heard(const std::string& word);
  void ended();  // the other end of its channel is closed
  // To be called once everything received by `now` was passed on: checks whether an answer is overdue.
  void judge(devices::Nanoseconds now);
  void excuse();  // this process kept it busy: the deadline of its answer starts again

  [[nodiscard]] bool fired() const;
  [[nodiscard]] std::optional<WatcherLost> lost() const;    // once set, stays set
  [[nodiscard]] std::vector<DeadManNotice> take_notices();  // since the last call, oldest first

 private:
  void record_blind(const std::string& why);
  const devices::Nanoseconds timeout_;
  const bool blind_ends_;
  mutable std::mutex mutex_;
  std::optional<devices::Nanoseconds> owed_since_;  // time of the oldest feeding without an answer
  bool fired_ = false;
  int failed_reads_ = 0;  // in a row
  std::optional<WatcherLost> lost_;
  std::vector<DeadManNotice> news_;
};

}  // namespace tactbench::bench
