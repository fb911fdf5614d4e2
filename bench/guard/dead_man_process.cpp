#include "bench/guard/dead_man_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "analysis/json_io.h"
#include "bench/common/process_time.h"
#include "devices/device.h"
#include "devices/wire/byte_stream.h"

namespace tactbench::bench {

using devices::Fault;
using devices::Nanoseconds;

namespace {

constexpr int kSocket = 3;  // in the dead-man
constexpr Nanoseconds kLongestStart = std::chrono::seconds(10);
constexpr Nanoseconds kLine = std::chrono::seconds(5);
constexpr Nanoseconds kEnd = std::chrono::seconds(1);
constexpr Nanoseconds kTakeOver = std::chrono::seconds(15);
constexpr Nanoseconds kEndPoll = std::chrono::milliseconds(50);
constexpr int kSignsATimeout = 8;
constexpr double kOwnShare = 0.9;  // of the timeout: this process counts itself as stopped before the dead-man fires

// Throws with `why`; a second line of it is the remedy.
[[noreturn]] void fail(const std::string& why) {
  const std::size_t end = std::min(why.find('\n'), why.size());
  throw Fault("TB-DEADMAN-START", "dead-man", fmt::format("starting the dead-man: {}", why.substr(0, end)),
              why.substr(std::min(end + 1, why.size())));
}

// Between fork() and exec(): system calls only.
void become_dead_man(int socket, char* const* arguments) {
  ::setsid();
  struct sigaction ignore {};
  ignore.sa_handler = SIG_IGN;
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGTSTP, SIGQUIT}) ::sigaction(number, &ignore, nullptr);
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  // dup2() on itself would leave the descriptor to be closed.
  const int away = ::fcntl(socket, F_DUPFD, kSocket + 1);
  const int null = ::open("/dev/null", O_RDWR);
  if (away < 0 || null < 0 || ::dup2(null, 0) < 0 || ::dup2(null, 1) < 0 || ::dup2(away, kSocket) < 0) ::_exit(126);
  ::close_range(kSocket + 1, ~0U, 0);
  ::execv(arguments[0], arguments);
  ::_exit(127);
}

}  // namespace

void share_lines(BenchConfig& config, bool as_dead_man) {
  const auto share = [&](devices::ModbusEndpoint& endpoint) {
    endpoint.exclusive = false;
    if (as_dead_man) endpoint.lock = false;
  };
  share(config.module.endpoint);
  config.controller_address.exclusive = false;
  if (as_dead_man) config.controller_address.lock = false;
  if (config.input_module) share(config.input_module->endpoint);
  if (config.reference_gauge) share(config.reference_gauge->endpoint);
  for (EnvironmentSensor& sensor : config.environment) share(sensor.endpoint);
}

DeadManProcess::DeadManProcess(const BenchConfig& config)
    : timeout_(seconds(config.dead_man.timeout_s)),
      progress_(seconds(config.dead_man.progress_s)),
      reports_(timeout_, config.dead_man.blind_ends) {
  if (config.stage) stage_address_ = config.stage->address;
  start(config.dead_man.program);
  const nlohmann::json bench = {{"name", config.file}, {"bench", config.resolved}};
  if (!channel_->send(analysis::json_line(bench))) fail("it does not accept the bench's description");
  const std::optional<devices::ChannelPacket> answer = channel_->receive(kLongestStart);
  if (!answer || answer->text != "ready") {
    fail(answer ? answer->text : channel_->closed() ? "it ended at once" : "it did not answer");
  }
  shown_ = now().count();
  feed();
  relay_ = std::thread([this] { relay(); });
}

void DeadManProcess::start(const std::string& program) {
  const auto [ours, theirs] = devices::DescriptorChannel::make_pair();
  channel_ = std::make_unique<devices::DescriptorChannel>(ours);
  std::string texts[] = {program, "dead-man", "--socket", std::to_string(kSocket)};
  const std::array<char*, 5> arguments{texts[0].data(), texts[1].data(), texts[2].data(), texts[3].data(), nullptr};
  child_ = ::fork();
  if (child_ == 0) become_dead_man(theirs, arguments.data());
  ::close(theirs);
  if (child_ < 0) fail("no further process can be made");
}

DeadManProcess::~DeadManProcess() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  if (relay_.joinable()) relay_.join();
  channel_.reset();
  // A dead-man that is making the bench safe is left alone.
  (void)::waitpid(child_, nullptr, WNOHANG);
}

// The thread that reports that this process runs and makes progress, and receives the answers.
void DeadManProcess::relay() {
  const auto own_limit = Nanoseconds(static_cast<Nanoseconds::rep>(kOwnShare * static_cast<double>(timeout_.count())));
  std::unique_lock lock(mutex_);
  while (!stop_ && !fired_) {
    const Nanoseconds time = now();
    if (time - Nanoseconds(shown_) > own_limit) {
      fired_ = true;  // this process was stopped: the dead-man may have vented, so no command may follow
    } else if (time.count() < due_ && (channel_->send("feed") || reports_.lost())) {
      shown_ = time.count();  // a lost dead-man may no longer read, which says nothing about this process
      reports_.asked(time);
    }
    // The thread that holds the lock receives them meanwhile.
    if (const std::unique_lock receiving(receiving_, std::try_to_lock); receiving) {
      listen_to_all();
      reports_.judge(now());
    }
    wake_.wait_for(lock, timeout_ / kSignsATimeout, [this] { return stop_; });
  }
}

void DeadManProcess::feed() { due_ = (now() + progress_).count(); }

void DeadManProcess::allow(Nanoseconds span) { due_ = (now() + std::max(span, progress_)).count(); }

void DeadManProcess::listen(const devices::ChannelPacket& packet) {
  reports_.heard(packet.text);
  if (packet.descriptor >= 0) ::close(packet.descriptor);  // answers a request that timed out
}

void DeadManProcess::listen_to_all() {
  while (const auto packet = channel_->receive(Nanoseconds(0))) listen(*packet);
  if (channel_->closed()) reports_.ended();
}

bool DeadManProcess::fired() {
  {
    const std::lock_guard lock(receiving_);
    listen_to_all();
  }
  if (reports_.fired() || now() - Nanoseconds(shown_) > timeout_) fired_ = true;
  return fired_;
}

std::optional<WatcherLost> DeadManProcess::lost() { return fired_ || dismissed_ ? std::nullopt : reports_.lost(); }

bool DeadManProcess::wait_ended(Nanoseconds longest) {
  const Nanoseconds end = now() + longest;
  for (;;) {
    const std::lock_guard lock(receiving_);
    const Nanoseconds left = std::clamp(end - now(), Nanoseconds(0), kEndPoll);
    if (const auto packet = channel_->receive(left)) listen(*packet);
    if (channel_->closed() || now() >= end) return channel_->closed();
  }
}

std::unique_ptr<devices::ByteStream> DeadManProcess::open_line() {
  const std::lock_guard lock(receiving_);
  // The dead-man does not answer while it opens a line.
  struct Excused {
    DeadManReports& reports;
    ~Excused() { reports.excuse(); }
  } const excused{reports_};
  return ask_for_line();
}

std::unique_ptr<devices::ByteStream> DeadManProcess::ask_for_line() {
  if (channel_->closed()) return devices::open_serial(stage_address_);
  allow(kLine);
  (void)channel_->send("line");
  const Nanoseconds end = now() + kLine;
  const std::string address = stage_address_.port.empty() ? stage_address_.usb_serial : stage_address_.port;
  while (now() < end && !channel_->closed()) {
    const auto packet = channel_->receive(end - now());
    if (!packet) continue;
    if (packet->text == "line" && packet->descriptor >= 0) return devices::adopt_stream(packet->descriptor, address);
    if (packet->text.starts_with("no line: ")) {
      throw Fault("TB-SERIAL-OPEN", address, packet->text.substr(9) + " (asked of the dead-man)",
                  "Check the stage's power and cable, and port or usb_serial in the bench file.");
    }
    listen(*packet);
  }
  throw Fault("TB-SERIAL-OPEN", address, "the dead-man did not pass on the stage's line",
              "Read its messages on standard error, then start again.");
}

void DeadManProcess::name_run(std::int64_t run) { (void)channel_->send(fmt::format("run {}", run)); }

void DeadManProcess::fire() noexcept {
  fired_ = true;
  (void)channel_->send("fire");
}

bool DeadManProcess::take_over() {
  const std::optional<WatcherLost> lost = reports_.lost();
  const bool answers = !lost || lost->id == kDeadManBlind;
  if (!fired() && (!answers || !channel_->send("unproved"))) return true;
  fired_ = true;
  return wait_ended(kTakeOver);
}

void DeadManProcess::goodbye() {
  dismissed_ = true;
  const bool ended = channel_->send("goodbye") && wait_ended(kEnd);
  // It has nothing left to do and would keep the bench's next run waiting.
  const std::optional<WatcherLost> lost = reports_.lost();
  if (!ended && !fired() && lost && lost->id == kDeadManSilent) (void)::kill(child_, SIGKILL);
}

using devices::Nanoseconds;

namespace {

constexpr int kFailedReadsToBeBlind = 2;
constexpr std::string_view kBlindPrefix = "blind: ", kBusyPrefix = "busy: ";

}  // namespace

void DeadManReports::asked(Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  if (!owed_since_) owed_since_ = now;
}

void DeadManReports::excuse() {
  const std::lock_guard lock(mutex_);
  owed_since_.reset();
}

void DeadManReports::heard(const std::string& word) {
  const std::lock_guard lock(mutex_);
  if (word == "fed") {
    owed_since_.reset();
  } else if (word == "fired") {
    fired_ = true;
  } else if (word.starts_with(kBlindPrefix)) {
    record_blind(word.substr(kBlindPrefix.size()));
  } else if (word.starts_with(kBusyPrefix)) {
    news_.push_back({"TB-MODBUS-BUSY", word.substr(kBusyPrefix.size())});
  } else if (word.starts_with(kDidPrefix)) {
    news_.push_back({"", word.substr(kDidPrefix.size())});
  } else if (word == "sees") {
    if (failed_reads_ > 0) news_.push_back({"", "the dead-man reaches the module again"});
    failed_reads_ = 0;
  }
}

void DeadManReports::record_blind(const std::string& why) {
  ++failed_reads_;
  const std::string what = fmt::format("the dead-man cannot reach the module: {}", why);
  if (failed_reads_ == 1) news_.push_back({kDeadManBlind, what});
  if (failed_reads_ < kFailedReadsToBeBlind || !blind_ends_ || lost_) return;
  lost_ = WatcherLost{kDeadManBlind, fmt::format("{}, {} times in a row", what, failed_reads_),
                      "Check that the module accepts a second connection and that no other program uses it; then start "
                      "again or `tactbench resume`."};
}

void DeadManReports::ended() {
  const std::lock_guard lock(mutex_);
  if (fired_ || lost_) return;
  lost_ = WatcherLost{kDeadManEnded, "the dead-man's process has ended",
                      "Find out what ended it (system log, memory), then start again or `tactbench resume`."};
}

void DeadManReports::judge(Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  if (fired_ || lost_ || !owed_since_ || now - *owed_since_ <= timeout_) return;
  lost_ = WatcherLost{
      kDeadManSilent,
      fmt::format("the dead-man does not answer: no message from it for {:.2f} s, {:g} s are allowed",
                  devices::in_seconds(now - *owed_since_), devices::in_seconds(timeout_)),
      "Its process is stopped, or the computer is overloaded: find out why, then start again or `tactbench resume`."};
}

bool DeadManReports::fired() const {
  const std::lock_guard lock(mutex_);
  return fired_;
}

std::optional<WatcherLost> DeadManReports::lost() const {
  const std::lock_guard lock(mutex_);
  return lost_;
}

std::vector<DeadManNotice> DeadManReports::take_notices() {
  const std::lock_guard lock(mutex_);
  return std::exchange(news_, {});
}

}  // namespace tactbench::bench
