// The dead-man as a process of its own, seen from the sequencer: started before any device is opened, fed by progress,
// it makes the bench safe over its own connection when the feeding ends. dead_man_server.h is its other side.
//
// Two times: every `timeout` the process has to show that it runs (a thread does that, which SIGSTOP and SIGKILL stop
// like any other), and every `progress` its work has to have moved on. So a process that is stopped is found soon, and
// an exchange that fails slowly does not fire. The dead-man answers each sign, and is watched by that: the thread hears
// the answers, and whoever asks here waits for nothing.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "bench/config/config.h"
#include "bench/guard/dead_man_reports.h"
#include "devices/wire/byte_stream.h"
#include "devices/wire/descriptor_channel.h"

namespace tactbench::bench {

class DeadManProcess final : public Watcher {
 public:
  // Returns once the dead-man has reached the module over its own connection, at most 10 s. Throws Fault
  // TB-DEADMAN-START.
  explicit DeadManProcess(const BenchConfig& config);
  // Without a goodbye the dead-man makes safe.
  ~DeadManProcess() override;
  DeadManProcess(const DeadManProcess&) = delete;
  DeadManProcess& operator=(const DeadManProcess&) = delete;

  void feed() override;
  // Something slow comes, such as opening an instrument, while nothing is loaded: no feeding is due before.
  void allow(devices::Nanoseconds span);
  // It has fired, or must have fired because this process stood still. Stays true.
  [[nodiscard]] bool fired() override;
  [[nodiscard]] std::optional<WatcherLost> lost() override;
  [[nodiscard]] bool alive() { return !fired() && !lost(); }
  // What it said of its sight of the module since the last call.
  [[nodiscard]] std::vector<DeadManNews> take_news() { return reports_.take_news(); }
  [[nodiscard]] bool wait_ended(devices::Nanoseconds longest) override;
  // The stage's line, opened by the dead-man, anew at each call. Throws Fault TB-SERIAL-OPEN with its reason. Once it
  // has ended the line is opened here.
  [[nodiscard]] std::unique_ptr<devices::ByteStream> open_line();
  void name_run(std::int64_t run);  // for its record
  void fire() noexcept;             // now; any thread
  void goodbye();                   // the safe state was proved: it ends and does nothing; one that is frozen is ended

 private:
  void start(const std::string& program);
  void relay();
  void listen(const devices::ChannelPacket& packet);
  void listen_to_all();  // that has come; under receiving_
  std::unique_ptr<devices::ByteStream> ask_for_line();
  static devices::Nanoseconds now() { return std::chrono::steady_clock::now().time_since_epoch(); }

  devices::SerialAddress stage_address_;
  devices::Nanoseconds timeout_, progress_;
  std::unique_ptr<devices::DescriptorChannel> channel_;
  pid_t child_ = -1;
  std::atomic<devices::Nanoseconds::rep> due_{0};    // when the next feeding is due
  std::atomic<devices::Nanoseconds::rep> shown_{0};  // when this process last showed that it runs
  std::atomic<bool> fired_{false};
  std::atomic<bool> dismissed_{false};
  DeadManReports reports_;
  std::mutex receiving_;  // a halt may come from any thread
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stop_ = false;
  std::thread relay_;
};

// An RTU line that a standing program holds open has to be reachable for its dead-man: neither keeps it exclusively,
// and the dead-man takes no lock.
void share_lines(BenchConfig& config, bool as_dead_man);

}  // namespace tactbench::bench
