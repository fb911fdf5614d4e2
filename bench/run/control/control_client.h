// The client's side of the commands: which runs live on this machine, and their answers. All are asked at once, so that
// one that stands still costs the others nothing.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/run/control/control.h"
#include "bench/run/control/peer.h"

namespace tactbench::bench {

struct LiveRun {
  std::string name;   // where it listens (bench/run/control/machine_name.h)
  std::string bench;  // its id
  Peer server;
  RunStatus status;
  bool taken = false;   // of the command sent
  bool denied = false;  // the caller may not command it; `text` holds the reason, `status` is empty
  std::string text;     // the answer
};

// The answer in a server's text; none: not written by a run.
std::optional<LiveRun> read_answer(const std::string& name, const Peer& server, const std::string& text);

// A name that is held by a process that did not answer.
struct SilentBench {
  std::string name, bench;  // bench: its id as far as the name shows it
  std::int64_t run = 0;     // 0: not known
  std::optional<Peer> server;
  bool stranger = false;  // not believed: neither root, nor the caller's user, nor of the group
};

struct Heard {
  std::vector<LiveRun> answers;  // by name
  std::vector<SilentBench> silent;
};

// Names under which runs listen; of one bench, or (empty) of all.
std::vector<std::string> run_names(const std::string& bench_id = {});

struct ListenOptions {
  // Once a `wanted` answer has come, the others have `stragglers` longer; until then all have `longest`.
  std::chrono::milliseconds stragglers{200}, longest{2000};
  std::function<bool(const LiveRun&)> wanted;  // empty: any
  std::function<bool(const LiveRun&)> enough;  // after this no further answer is needed; empty: none
};

// Sends `command` to all of them. Root accepts any answer; for other users, runs of strangers count as silent, and the
// command is not sent to them.
Heard say_to(const std::vector<std::string>& names, Command command, const ListenOptions& options = {});

// The same to one; none: no answer.
std::optional<LiveRun> send_command(const std::string& name, Command command);
// All that answer.
std::vector<LiveRun> live_runs();

}  // namespace tactbench::bench
