// For the benchmark of the page: its process, and viewers that read its stream.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "bench/common/child_process.h"

namespace tactbench::bench {

// Of the text of /proc/<process>/stat: user and system time in seconds, of ticks of which a second has so many.
double processor_seconds_of(const std::string& stat, double ticks_per_second);
// Of the text of /proc/<process>/status: the most memory so far; 0 where it says nothing of it.
double resident_mb_of(const std::string& status);

// When each picture of a stream of events first came, by its position.
class PictureTimes {
 public:
  using Time = std::chrono::steady_clock::time_point;
  void take(const std::string& bytes, Time now);  // pieces of any length
  [[nodiscard]] const std::map<std::int64_t, Time>& times() const { return times_; }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
  std::size_t looked_ = 0;
  std::map<std::int64_t, Time> times_;
};

// `tactbench page` on that store; what it says goes to page.log in `folder`. `program`: its file; empty: that of this
// process. Throws std::runtime_error when it does not start, with what it said.
class PageProcess {
 public:
  PageProcess(const std::string& db, const std::string& folder, const std::string& program = {});
  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] const std::string& token() const { return token_; }
  [[nodiscard]] double processor_s() const;  // user and system time so far
  [[nodiscard]] double resident_mb() const;  // the most so far

 private:
  ChildProgram child_;
  std::uint16_t port_ = 0;
  std::string token_;
};

// Streams read by one thread, but for the last `frozen`, which read nothing.
class PageViewers {
 public:
  using RealClock = std::chrono::steady_clock;
  PageViewers(std::uint16_t port, const std::string& token, int viewers, int frozen);
  ~PageViewers();
  PageViewers(const PageViewers&) = delete;
  PageViewers& operator=(const PageViewers&) = delete;
  // Ends the reading. When each picture first came to the first viewer, by its position; and what that viewer got.
  const std::map<std::int64_t, RealClock::time_point>& pictures();
  const std::string& text();

 private:
  void read();
  std::vector<int> descriptors_;
  std::size_t reading_;
  std::atomic<bool> ended_{false};
  PictureTimes pictures_;
  std::thread thread_;
};

}  // namespace tactbench::bench
