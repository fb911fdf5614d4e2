// Finds the live run that belongs to a store and follows it through its control socket; when it ends, looks for the
// next one.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "bench/page/http/http_server.h"
#include "bench/run/control/run_connection.h"

namespace tactbench::bench {

class RunFollower {
 public:
  // `bench`: its id; empty: any bench whose run writes to the store `db`. `heard`: called with each status received,
  // and with none once the run has closed the connection. `server` must outlive this.
  RunFollower(HttpServer& server, std::string db, std::string bench, std::function<void()> heard);
  void look();  // looks for a run if none is followed; to be called a few times per second
  // The newest status; none: no run is followed.
  [[nodiscard]] const std::optional<LiveRun>& live() const { return live_; }
  [[nodiscard]] double silent_s() const;  // since the last status; a run sends one twice a second

 private:
  using RealClock = std::chrono::steady_clock;
  void receive();
  void let_go(bool ours);

  HttpServer& server_;
  std::string db_, bench_;
  std::function<void()> heard_;
  std::unique_ptr<RunConnection> connection_;
  std::shared_ptr<void> watching_;
  std::string name_;       // name of the connected bench
  std::string our_store_;  // the store's path in the run's status; empty: not compared yet
  std::optional<LiveRun> live_;
  RealClock::time_point last_{};
  std::map<std::string, RealClock::time_point>
      foreign_;  // benches with other stores or of untrusted users, and when they were queried
};

}  // namespace tactbench::bench
