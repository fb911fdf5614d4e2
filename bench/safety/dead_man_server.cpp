#include "bench/safety/dead_man_server.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "analysis/json_io.h"
#include "bench/common/error.h"
#include "bench/common/process_time.h"
#include "bench/common/terminal.h"
#include "bench/common/utc.h"
#include "bench/config/instrument_kinds.h"
#include "bench/guard/dead_man.h"
#include "bench/guard/dead_man_process.h"
#include "bench/guard/trip.h"
#include "bench/rig/rig.h"
#include "bench/run/control/locks.h"
#include "bench/safety/safe_state.h"
#include "devices/device.h"
#include "devices/wire/byte_stream.h"
#include "devices/wire/descriptor_channel.h"

namespace tactbench::bench {

using devices::Nanoseconds;

namespace {

constexpr Nanoseconds kFirstPacket = std::chrono::seconds(10);
constexpr Nanoseconds kEarlierEnds = std::chrono::seconds(8);  // less than the starter waits
constexpr Nanoseconds kLongestPoll = std::chrono::seconds(5);
constexpr Nanoseconds kSeldom = std::chrono::seconds(5);
constexpr Nanoseconds kLineSilence = std::chrono::milliseconds(50);  // longer than the answer to the last request
constexpr Nanoseconds kBackOff = std::chrono::seconds(10);
constexpr int kDeadManTries = 2;

Nanoseconds now() { return std::chrono::steady_clock::now().time_since_epoch(); }
BenchConfig read_description(devices::DescriptorChannel& channel) {
  const auto packet = channel.receive(kFirstPacket);
  if (!packet) throw std::runtime_error("no bench was described to it");
  const auto json = analysis::parse_json(packet->text);
  BenchConfig config = parse_bench(json.at("bench"), json.at("name"), {});
  share_lines(config, true);
  config.dead_man.enabled = false;  // this process is the dead-man
  return config;
}

// Time between two readings of the module. A watchdog that was set by the module's own web page may accept any request
// as a sign of life: such a module is read so rarely that the watchdog still expires when nothing writes.
Nanoseconds poll_interval(const BenchConfig& config) {
  const bool may_feed = config.watchdog_s <= 0.0 && !config.module.profile.fail_safe.layers.empty();
  return may_feed ? kSeldom : seconds(config.dead_man.timeout_s);
}

class Server {
 public:
  Server(devices::DescriptorChannel& channel, const BenchConfig& config)
      : channel_(channel), config_(config), rig_(config) {
    if (!on_serial_line(config)) rig_.look();  // a serial line has one user at a time: opened only when needed
  }
  ~Server() { stop_reading(); }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  int serve() {
    if (!on_serial_line(config_)) reading_ = std::thread([this] { keep_reading(); });
    const DeadMan fresh(seconds(config_.dead_man.timeout_s));
    DeadMan dead_man = fresh;
    dead_man.feed(now());
    for (;;) {
      bool fed = false;
      auto packet = channel_.receive(std::clamp(dead_man.left(now()), Nanoseconds(0), kLongestPoll));
      // Waiting messages count as sent now: a dead-man that was itself delayed must not blame the sequencer, which
      // checks itself whether it was stopped.
      for (; packet; packet = channel_.receive(Nanoseconds(0))) {
        if (packet->text == "goodbye") return 0;
        if (packet->text == "fire") return fire("commanded", false);
        if (packet->text == "unproved") return fire("the sequencer could not prove the safe state", true);
        if (packet->text == "feed") (void)channel_.send("fed");
        if (packet->text == "line") hand_line_over();
        if (packet->text.starts_with("run ")) run_ = std::stoll(packet->text.substr(4));
        fed = true;
      }
      if (channel_.closed()) return fire("the sequencer ended without a goodbye", true);
      if (fed) {
        dead_man = fresh;
        dead_man.feed(now());
      } else if (dead_man.late(now())) {
        return fire(fmt::format("the sequencer gave no sign of life for {:g} ms", 1000.0 * config_.dead_man.timeout_s),
                    false);
      }
    }
  }

 private:
  // In a separate thread: an exchange that times out must not delay the answers to the sequencer.
  void keep_reading() {
    const Nanoseconds pause = poll_interval(config_);
    for (bool blind = false;;) {
      {
        std::unique_lock lock(mutex_);
        if (wake_.wait_for(lock, pause, [this] { return stop_; })) return;
      }
      try {
        rig_.look();
        for (const std::string& words : rig_.take_busy_report()) (void)channel_.send("busy: " + words);
        if (blind) (void)channel_.send("sees");
        blind = false;
      } catch (const std::exception& error) {  // firing opens a new connection
        blind = true;
        (void)channel_.send(fmt::format("blind: {}", error.what()));
      }
    }
  }

  void stop_reading() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake_.notify_all();
    if (reading_.joinable()) reading_.join();
  }

  void hand_line_over() {
    stage_used_ = true;
    line_.reset();
    try {
      line_ = devices::open_serial(config_.stage.value().address);
      (void)channel_.send("line", line_->descriptor());
    } catch (const std::exception& error) {
      (void)channel_.send(fmt::format("no line: {}", error.what()));
    }
  }

  // `gone`: the sequencer has ended or has done its part; this alone needs no person once everything is proved safe.
  int fire(const std::string& why, bool gone) {
    const Nanoseconds start = now();
    (void)channel_.send("fired");
    devices::StageRetreat stage;
    double stage_s = 0.0;
    std::thread retreating([&] {
      if (stage_used_) stage = retreat_stage();
      stage_s = devices::in_seconds(now() - start);
    });
    SafeProof proof;
    stop_reading();  // from now on this thread owns the connection
    if (on_serial_line(config_)) std::this_thread::sleep_for(kLineSilence);
    for (int i = 0; i < kDeadManTries && proof.state != db::SafeState::kVerified; ++i) proof = make_safe(rig_, {});
    const double pressure_s = devices::in_seconds(now() - start);
    retreating.join();
    const bool stage_safe = !stage_used_ || (stage.stands && stage.backed_off);
    const bool safe = proof.state == db::SafeState::kVerified && stage_safe;
    const std::string stage_text = stage_used_ ? stage.text : "stage not in use";
    const std::string what = fmt::format("dead-man fired ({}); {} after {:.2f} s; {} after {:.2f} s", why,
                                         proof.text.in(analysis::PressureUnit::kPsi), pressure_s, stage_text, stage_s);
    tty::print(stderr, "tactbench: bench '{}': {}\n", config_.id, what);
    (void)channel_.send(std::string(kDidPrefix) + what);
    const TripFile trip(config_.id);
    const bool latched = !(gone && safe);
    if (latched) (void)trip.store({kDeadManFired, what, run_, {}});
    record(trip, {{"utc", utc_now()},
                  {"why", why},
                  {"run", run_},
                  {"ended", safe ? "safe, verified" : "NOT verified"},
                  {"pressure", proof.text.in(analysis::PressureUnit::kPsi)},
                  {"pressure_s", pressure_s},
                  {"stage", stage_text},
                  {"stage_s", stage_s},
                  {"tripped", latched}});
    return safe ? 0 : static_cast<int>(ExitCode::kUnsafe);
  }

  void record(const TripFile& trip, const nlohmann::ordered_json& json) {
    try {
      write_durably(trip.dead_man_path(), analysis::printable_json(json, 2) + "\n");
    } catch (const std::exception& error) {
      tty::print(stderr, "tactbench: dead-man's record: {}\n", error.what());
    }
  }

  devices::StageRetreat retreat_stage() {
    devices::StageRetreat result;
    for (int i = 0; i < kDeadManTries && !(result.stands && result.backed_off); ++i) {
      try {
        if (!line_) line_ = devices::open_serial(config_.stage.value().address);
        // A copy of the descriptor: the line cannot be opened again while a stopped sequencer holds it.
        const int copy = ::fcntl(line_->descriptor(), F_DUPFD_CLOEXEC, 0);
        const StageRow& kind = row_of(stage_kinds(), config_.stage->kind);
        result = kind.retreat(devices::adopt_stream(copy, line_->description()), *config_.stage,
                              devices::Millimetres(config_.dead_man.back_off_mm), kBackOff);
      } catch (const std::exception& error) {
        line_.reset();
        result.text = error.what();
      }
    }
    return result;
  }

  devices::DescriptorChannel& channel_;
  const BenchConfig config_;
  Rig rig_;
  std::unique_ptr<devices::ByteStream> line_;  // as opened for the sequencer
  bool stage_used_ = false;
  std::int64_t run_ = 0;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stop_ = false;
  std::thread reading_;  // until the dead-man fires
};

// So that a busy computer does not look like a dead one: in real time where that is allowed (`ulimit -r`), else with a
// higher priority. The latter is not enough by itself: Linux shares a busy processor among sessions first (autogroup),
// and this process is a session of its own.
void raise_priority() {
  const sched_param lowest{.sched_priority = 1};
  if (::sched_setscheduler(0, SCHED_RR, &lowest) != 0) (void)::setpriority(PRIO_PROCESS, 0, -10);
}

}  // namespace

int serve_dead_man(int socket) {
  raise_priority();
  devices::DescriptorChannel channel(socket);
  std::unique_ptr<MachineName> lock;
  std::unique_ptr<Server> server;
  try {
    const BenchConfig config = read_description(channel);
    lock = std::make_unique<MachineName>(dead_man_name(config.id, kEarlierEnds));
    if (!lock->held()) throw std::runtime_error("an earlier one (" + lock->owner() + ") still makes the bench safe");
    server = std::make_unique<Server>(channel, config);
  } catch (const std::exception& error) {
    // The advice for a dead-man that does not start fits a module that cannot be reached, no other fault.
    const auto* const fault = dynamic_cast<const devices::Fault*>(&error);
    const bool reached = fault != nullptr && fault->id() != "TB-MODBUS-CONNECT" && fault->id() != "TB-MODBUS-TIMEOUT";
    const std::string remedy = reached ? as_error(std::current_exception()).remedy() : std::string();
    (void)channel.send(remedy.empty() ? error.what() : fmt::format("{}\n{}", error.what(), remedy));
    return static_cast<int>(ExitCode::kDevice);
  }
  (void)channel.send("ready");
  return server->serve();
}

}  // namespace tactbench::bench
