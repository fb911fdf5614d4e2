// Passes commands and answers from the page to the live run: each is sent on a separate connection and answered when
// the run has acknowledged it, or refused if the run does not do so in time.
#pragma once

#include <chrono>
#include <list>
#include <memory>
#include <string>

#include "bench/page/http/http_server.h"
#include "bench/run/control/control_client.h"

namespace tactbench::bench {

class Commands {
 public:
  explicit Commands(HttpServer& server) : server_(server) {}
  // `body`: {"word": "pause"} or {"word": "answer", "question": 3, "text": "done"}, with "run", the run number that the
  // page displayed. `behalf`: the requesting person, for the run's events. The reply is JSON: taken, text, and by whom.
  void send(const std::string& body, const LiveRun* live, const std::string& behalf, Reply reply);
  void look();  // to be called a few times per second: gives up commands that were not acknowledged

 private:
  struct Sent {
    std::unique_ptr<RunConnection> connection;
    std::shared_ptr<void> watching;
    Reply reply;
    std::chrono::steady_clock::time_point begun{};
    bool done = false;
  };
  void receive(Sent& sent);

  HttpServer& server_;
  std::list<Sent> sent_;
};

}  // namespace tactbench::bench
