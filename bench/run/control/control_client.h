// The client's side of the commands: finds the live runs of this machine and collects their answers. All are queried in
// parallel, so that a stopped process does not delay the others.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bench/run/control/control.h"
#include "bench/run/control/locks.h"

namespace tactbench::bench {

struct LiveRun {
  std::string name;   // where it listens (bench/run/control/locks.h)
  std::string bench;  // its id
  Peer server;
  RunStatus status;
  bool taken = false;   // the command was accepted
  bool denied = false;  // the caller may not command it; `text` holds the reason, `status` is empty
  std::string text;     // the answer
};

// Parses the text from a server; none: it is not the answer of a run.
std::optional<LiveRun> read_answer(const std::string& name, const Peer& server, const std::string& text);

// A bench whose name is held by a process that did not answer.
struct SilentBench {
  std::string name, bench;  // bench: its id as far as it can be read from the name
  std::int64_t run = 0;     // 0: not known
  std::optional<Peer> server;
  bool stranger =
      false;          // not trusted: the process does not belong to root, the caller's user or a member of the group
  bool lied = false;  // it answered, but does not carry out a run of the store that it names
};

struct RunReplies {
  std::vector<LiveRun> answers;  // by name
  std::vector<SilentBench> silent;
};

// Names under which runs listen, of one bench or (empty) of all.
std::vector<std::string> run_names(const std::string& bench_id = {});

struct ListenOptions {
  // Waits at most `longest`; once a `wanted` answer has come, at most `stragglers` more.
  std::chrono::milliseconds stragglers{200}, longest{2000};
  std::function<bool(const LiveRun&)> wanted;  // empty: any
  std::function<bool(const LiveRun&)> enough;  // true for an answer after which no further one is needed; empty: never
  std::optional<Peer> known;                   // process that was trusted before: it may be ending now
};

// Sends `command` to the runs with these names and collects the answers. Untrusted processes count as silent: root
// queries them, but trusts only those that carry out a run of the store that they name (locks.h); other users do not
// query them.
RunReplies send_to_runs(const std::vector<std::string>& names, Command command, const ListenOptions& options = {});

// The same for one run; none: no trusted answer.
std::optional<LiveRun> send_command(const std::string& name, Command command, const std::optional<Peer>& known = {});

// Requests of a client of the control socket, one packet of text each: a command word with its arguments, and on a
// second line the person for whom the client asks. `follow`: sends the run's status repeatedly. `answer ID TEXT`:
// answers the question with that number. All other words are commands (control.h).
inline constexpr std::size_t kMaxRequestBytes = 2048;  // bytes of a packet; longer text is cut
inline constexpr std::size_t kMaxReplyColumns = 300;   // columns of an answer's text
inline constexpr std::size_t kMaxBehalfColumns = 120;  // columns of the name for whom a client asks

enum class ClientRequestKind { kCommand, kFollow, kAnswer };

struct ClientRequest {
  ClientRequestKind word = ClientRequestKind::kCommand;
  Command command = Command::kStatus;  // for kCommand; an unknown word requests the status
  int question = 0;                    // for kAnswer; 0: not a valid number
  std::string text;                    // for kAnswer, one line
  std::string behalf;                  // "bob on the page, from 127.0.0.1"; empty: the client itself asks
};

ClientRequest parse_client_request(std::string_view packet);
std::string command_packet(Command command, const std::string& behalf);
std::string answer_packet(int question, const std::string& text, const std::string& behalf);

// Non-blocking connection to one live run: requests are sent immediately, answers are polled. For a process with other
// work meanwhile (bench/page); the functions above query several runs and wait.
class RunConnection {
 public:
  // Connects to the name of a bench and sends `text`. Not open if nobody listens on the name, or an
  // untrusted process that does not carry out a run of the store `db` (locks.h).
  RunConnection(std::string name, const std::string& text, const std::string& db = {});
  ~RunConnection();
  RunConnection(const RunConnection&) = delete;
  RunConnection& operator=(const RunConnection&) = delete;
  [[nodiscard]] bool open() const { return descriptor_ >= 0; }
  [[nodiscard]] int descriptor() const { return descriptor_; }  // readable once data has arrived
  // The newest answer received; older ones are dropped. Once the run has closed its side, the connection is closed.
  std::optional<LiveRun> newest();

 private:
  void close();
  std::string name_;
  Peer server_;
  int descriptor_ = -1;
};

}  // namespace tactbench::bench
