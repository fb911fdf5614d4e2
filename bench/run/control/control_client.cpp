#include "bench/run/control/control_client.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <nlohmann/json.hpp>
#include <utility>

#include "analysis/json_io.h"
#include "bench/common/private_files.h"
#include "bench/common/terminal.h"
#include "bench/run/control/locks.h"

namespace tactbench::bench {
namespace {

using WordClock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kConnectAgain{5};

}  // namespace

std::optional<LiveRun> read_answer(const std::string& name, const Peer& server, const std::string& text) {
  const nlohmann::json answer = analysis::try_json(text);
  if (!answer.is_object()) return std::nullopt;
  try {
    LiveRun live;
    live.name = name;
    live.server = server;
    live.bench = answer.value("bench", "");
    live.status = status_from_json(answer);
    live.taken = answer.value("taken", false);
    live.denied = answer.value("denied", false);
    live.text = answer.value("text", "");
    return live;
  } catch (const nlohmann::json::exception&) {  // not an answer of tactbench
    return std::nullopt;
  }
}

namespace {

std::string bench_part(const std::string& name) { return name.substr(0, name.find('/')); }

// 7 for "BENCH/run/7"; 0 if there is no such name.
std::int64_t claimed_run(const std::string& name, const std::vector<std::string>& held) {
  const std::string prefix = name + "/run/";
  for (const std::string& other : held) {
    if (!other.starts_with(prefix)) continue;
    std::int64_t run = 0;
    (void)std::from_chars(other.data() + prefix.size(), other.data() + other.size(), run);
    return run;
  }
  return 0;
}

// One non-blocking conversation.
class Asking {
 public:
  enum class State { kToConnect, kAsked, kAnswered, kSilent, kGone };

  Asking(std::string name, std::string word, std::optional<gid_t> group, const std::optional<Peer>& known)
      : name_(std::move(name)), word_(std::move(word)), group_(group), known_(known) {
    connect();
  }
  ~Asking() { hang_up(); }
  Asking(Asking&& other) noexcept
      : name_(std::move(other.name_)),
        word_(std::move(other.word_)),
        group_(other.group_),
        known_(other.known_),
        descriptor_(std::exchange(other.descriptor_, -1)),
        server_(other.server_),
        stranger_(other.stranger_),
        lied_(other.lied_),
        state_(other.state_),
        answer_(std::move(other.answer_)) {}
  Asking& operator=(Asking&&) = delete;

  void connect() {
    descriptor_ = connect_to_name(name_);
    if (descriptor_ < 0) {  // its queue is full: tries again while there is time
      state_ = errno == EAGAIN || errno == EINTR ? State::kToConnect : State::kGone;
      return;
    }
    server_ = peer_of(descriptor_, group_);
    const uid_t own = ::geteuid();
    stranger_ = !server_ || !is_trusted(*server_, own);
    if (!server_ || (stranger_ && own != 0)) {
      state_ = State::kSilent;
      hang_up();
      return;
    }
    // A server that closes the connection immediately may have sent data before.
    (void)::send(descriptor_, word_.data(), word_.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    state_ = State::kAsked;
  }
  void receive() {
    std::array<char, 32768> bytes{};
    const ssize_t size = ::recv(descriptor_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (size > 0) answer_ = read_answer(name_, *server_, std::string(bytes.data(), static_cast<std::size_t>(size)));
    if (answer_ && stranger_ && !believed(*answer_)) {
      lied_ = true;
      answer_.reset();
    }
    // One that hangs up without a word has ended, or had to make room for others before this word came: asked again, it
    // is known which.
    state_ = answer_ ? State::kAnswered : size > 0 ? State::kSilent : State::kToConnect;
    hang_up();
  }
  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] bool open() const { return state_ == State::kToConnect || state_ == State::kAsked; }
  [[nodiscard]] int descriptor() const { return descriptor_; }
  [[nodiscard]] const LiveRun& answer() const { return *answer_; }
  [[nodiscard]] SilentBench silent(const std::vector<std::string>& held) const {
    return {name_, bench_part(name_), claimed_run(name_, held), server_, stranger_, lied_};
  }

 private:
  [[nodiscard]] bool believed(const LiveRun& live) const {
    return (known_ && known_->process == live.server.process && known_->user == live.server.user) ||
           carries_out_run_of(live.server, live.status.store);
  }
  void hang_up() {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = -1;
  }

  std::string name_, word_;
  std::optional<gid_t> group_;
  std::optional<Peer> known_;
  int descriptor_ = -1;
  std::optional<Peer> server_;
  bool stranger_ = false, lied_ = false;
  State state_ = State::kToConnect;
  std::optional<LiveRun> answer_;
};

// Waits until one of them answers, at most until `end`; those that could not connect try again.
void wait_for_any(std::vector<Asking>& all, WordClock::time_point end) {
  std::vector<pollfd> ready;
  std::vector<Asking*> asked;
  bool again = false;
  for (Asking& one : all) {
    again = again || one.state() == Asking::State::kToConnect;
    if (one.state() != Asking::State::kAsked) continue;
    ready.push_back({one.descriptor(), POLLIN, 0});
    asked.push_back(&one);
  }
  auto left = std::chrono::ceil<std::chrono::milliseconds>(end - WordClock::now());
  if (again) left = std::min(left, kConnectAgain);
  (void)::poll(ready.data(), ready.size(), static_cast<int>(std::max(left, std::chrono::milliseconds(0)).count()));
  for (std::size_t i = 0; i < ready.size(); ++i)
    if (ready[i].revents != 0) asked[i]->receive();
  for (Asking& one : all)
    if (one.state() == Asking::State::kToConnect) one.connect();
}

}  // namespace

std::vector<std::string> run_names(const std::string& bench_id) {
  const std::string wanted = bench_id.empty() ? std::string() : file_name(bench_id);
  std::vector<std::string> names;
  for (std::string& name : held_names()) {
    const std::size_t slash = name.find('/');
    const bool is_run = slash == std::string::npos || name.compare(slash, 9, "/process/") == 0;
    const bool is_part = is_run && slash != std::string::npos && name.find('/', slash + 9) != std::string::npos;
    if (is_run && !is_part && (wanted.empty() || bench_part(name) == wanted)) names.push_back(std::move(name));
  }
  return names;
}

RunReplies send_to_runs(const std::vector<std::string>& names, Command command, const ListenOptions& options) {
  const auto begun = WordClock::now();
  auto end = begun + options.longest;
  const std::optional<gid_t> group = commanding_group();
  std::vector<Asking> all;
  all.reserve(names.size());
  for (const std::string& name : names) all.emplace_back(name, to_string(command), group, options.known);
  bool wanted_replied = false, enough_replied = false;
  while (!enough_replied && std::any_of(all.begin(), all.end(), [](const Asking& one) { return one.open(); }) &&
         WordClock::now() < end) {
    wait_for_any(all, end);
    for (const Asking& one : all) {
      if (one.state() != Asking::State::kAnswered) continue;
      if (!wanted_replied && (!options.wanted || options.wanted(one.answer()))) {
        wanted_replied = true;
        end = std::min(end, WordClock::now() + options.stragglers);
      }
      enough_replied = enough_replied || (options.enough && options.enough(one.answer()));
    }
  }
  RunReplies heard;
  std::vector<std::string> held;
  for (const Asking& one : all) {
    if (one.state() == Asking::State::kAnswered) {
      heard.answers.push_back(one.answer());
    } else if (one.state() != Asking::State::kGone && !enough_replied) {
      if (held.empty()) held = held_names();
      heard.silent.push_back(one.silent(held));
    }
  }
  return heard;
}

std::optional<LiveRun> send_command(const std::string& name, Command command, const std::optional<Peer>& known) {
  ListenOptions options;
  options.known = known;
  RunReplies heard = send_to_runs({name}, command, options);
  if (heard.answers.empty()) return std::nullopt;
  return std::move(heard.answers.front());
}

namespace {

Command command_of(std::string_view text) {
  for (const Command command : {Command::kPause, Command::kResume, Command::kStop, Command::kAbort, Command::kPanic}) {
    if (text == to_string(command)) return command;
  }
  return Command::kStatus;
}

std::string with_behalf(std::string text, const std::string& behalf) {
  if (!behalf.empty()) text += "\n" + one_line(behalf, kMaxBehalfColumns);
  return text;
}

std::string_view word_at(std::string_view& rest) {
  const std::size_t end = rest.find(' ');
  const std::string_view word = rest.substr(0, end);
  rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  return word;
}

}  // namespace

ClientRequest parse_client_request(std::string_view packet) {
  ClientRequest read;
  const std::size_t line_end = packet.find('\n');
  std::string_view rest = packet.substr(0, line_end);
  if (line_end != std::string_view::npos) read.behalf = one_line(packet.substr(line_end + 1), kMaxBehalfColumns);
  const std::string_view word = word_at(rest);
  if (word == "follow") {
    read.word = ClientRequestKind::kFollow;
  } else if (word == "answer") {
    read.word = ClientRequestKind::kAnswer;
    const std::string_view number = word_at(rest);
    int question = 0;
    const auto [end, failed] = std::from_chars(number.data(), number.data() + number.size(), question);
    if (failed == std::errc() && end == number.data() + number.size()) read.question = question;
    read.text = one_line(rest, kMaxReplyColumns);
  } else {
    read.command = command_of(word);
  }
  return read;
}

std::string command_packet(Command command, const std::string& behalf) {
  return with_behalf(to_string(command), behalf);
}

std::string answer_packet(int question, const std::string& text, const std::string& behalf) {
  return with_behalf(fmt::format("answer {} {}", question, one_line(text, kMaxReplyColumns)), behalf);
}

RunConnection::RunConnection(std::string name, const std::string& text, const std::string& db)
    : name_(std::move(name)) {
  descriptor_ = connect_to_name(name_);
  if (descriptor_ < 0) return;
  const std::optional<Peer> server = peer_of(descriptor_);
  if (!server || (!is_trusted(*server, ::geteuid()) && !carries_out_run_of(*server, db))) {
    close();
    return;
  }
  server_ = *server;
  // A run that closes the connection immediately may have sent data before.
  (void)::send(descriptor_, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

RunConnection::~RunConnection() { close(); }

void RunConnection::close() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

std::optional<LiveRun> RunConnection::newest() {
  std::optional<LiveRun> newest;
  std::string last;
  std::array<char, 32768> bytes{};
  while (descriptor_ >= 0) {
    const ssize_t size = ::recv(descriptor_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (size > 0) {
      last.assign(bytes.data(), static_cast<std::size_t>(size));
    } else if (size < 0 && errno == EINTR) {
      continue;
    } else if (size < 0 && errno == EAGAIN) {
      break;
    } else {
      close();
    }
  }
  if (!last.empty()) newest = read_answer(name_, server_, last);
  return newest;
}

}  // namespace tactbench::bench
