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

// `tactbench page` on that store.
class PageProcess {
 public:
  PageProcess(const std::string& db, const std::string& folder);
  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] const std::string& token() const { return token_; }
  [[nodiscard]] double processor_s() const;  // user and system time so far
  [[nodiscard]] double resident_mb() const;  // the most so far

 private:
  ChildProgram child_;
  std::uint16_t port_ = 0;
  std::string token_;
  pid_t process_ = 0;
};

// Streams read by one thread, but for the last `frozen`, which read nothing.
class PageViewers {
 public:
  using RealClock = std::chrono::steady_clock;
  PageViewers(const PageProcess& page, int viewers, int frozen);
  ~PageViewers();
  PageViewers(const PageViewers&) = delete;
  PageViewers& operator=(const PageViewers&) = delete;
  // Ends the reading. When each picture first came to the first viewer, by its position; and what that viewer got.
  const std::map<std::int64_t, RealClock::time_point>& pictures();
  const std::string& text();

 private:
  void read();
  void take(const std::string& bytes);
  std::vector<int> descriptors_;
  std::size_t reading_;
  std::atomic<bool> ended_{false};
  std::string text_;
  std::size_t looked_ = 0;
  std::map<std::int64_t, RealClock::time_point> pictures_;
  std::thread thread_;
};

}  // namespace tactbench::bench
