// The dead-man's process as the sequencer sees it: started before any device is opened and fed by progress; it makes
// the bench safe over its own connection when the feeding stops. dead_man_server.h is the other side.
//
// There are two deadlines. Within every `timeout` the run's process must send a sign of life; a thread does so, which
// SIGSTOP and SIGKILL stop together with the process. Within every `progress` its work must have advanced. So a stopped
// process is detected soon, and a slow exchange that fails does not trigger the dead-man. The dead-man answers each
// sign of life, and is itself watched by these answers: the thread receives them, and the functions here never wait.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "bench/config/config.h"
#include "bench/guard/dead_man.h"
#include "devices/wire/byte_stream.h"
#include "devices/wire/descriptor_channel.h"

namespace tactbench::bench {

// State of a dead-man process derived from its answers: watching, fired, ended, frozen, or blind (it cannot reach the
// module). Thread-safe.
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

class DeadManProcess final : public Watcher {
 public:
  // Returns once the dead-man has reached the module over its own connection, at most 10 s. Throws Fault
  // TB-DEADMAN-START.
  explicit DeadManProcess(const BenchConfig& config);
  // Unless goodbye() was called, the dead-man makes the bench safe.
  ~DeadManProcess() override;
  DeadManProcess(const DeadManProcess&) = delete;
  DeadManProcess& operator=(const DeadManProcess&) = delete;

  void feed() override;
  // Announces slow work while nothing is loaded, such as opening an instrument: the next feeding is due after it.
  void allow(devices::Nanoseconds span);
  // True once it has fired, or must have fired because this process was stopped. Stays true.
  [[nodiscard]] bool fired() override;
  [[nodiscard]] std::optional<WatcherLost> lost() override;
  // What it reported about reaching the module since the last call.
  [[nodiscard]] std::vector<DeadManNotice> take_notices() { return reports_.take_notices(); }
  [[nodiscard]] bool wait_ended(devices::Nanoseconds longest) override;
  // The stage's line, which the dead-man opens at each call. Throws Fault TB-SERIAL-OPEN with the dead-man's reason.
  // Once the dead-man has ended, the line is opened here.
  [[nodiscard]] std::unique_ptr<devices::ByteStream> open_line();
  void name_run(std::int64_t run);  // for its record
  void fire() noexcept;             // immediately; from any thread
  // The safe state could not be proved: it makes the bench safe now over its own connection, and reports what it did
  // (take_notices()). Waits for that, at most 15 s; false: it still works.
  bool take_over();
  void goodbye();  // the safe state was proved: the dead-man ends without acting; a frozen one is killed

 private:
  void start(const std::string& program);
  void relay();
  void listen(const devices::ChannelPacket& packet);
  void listen_to_all();  // reads all messages received; receiving_ is locked
  std::unique_ptr<devices::ByteStream> ask_for_line();
  static devices::Nanoseconds now() { return std::chrono::steady_clock::now().time_since_epoch(); }

  devices::SerialAddress stage_address_;
  devices::Nanoseconds timeout_, progress_;
  std::unique_ptr<devices::DescriptorChannel> channel_;
  pid_t child_ = -1;
  std::atomic<devices::Nanoseconds::rep> due_{0};    // when the next feeding is due
  std::atomic<devices::Nanoseconds::rep> shown_{0};  // time of this process's last sign of life
  std::atomic<bool> fired_{false};
  std::atomic<bool> dismissed_{false};
  DeadManReports reports_;
  std::mutex receiving_;  // a halt may come from any thread
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stop_ = false;
  std::thread relay_;
};

// The dead-man must reach a serial line of the pressure side that a stopped program still holds open: neither opens it
// exclusively, and the dead-man takes no lock.
void share_lines(BenchConfig& config, bool as_dead_man);

}  // namespace tactbench::bench
