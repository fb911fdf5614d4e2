#include "bench/run/control_socket.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "analysis/json_io.h"
#include "bench/error.h"
#include "bench/run/locks.h"

namespace tactbench::bench {

namespace {

using nlohmann::json;

constexpr int kAnswerMs = 1000;

sockaddr_un address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof(address.sun_path)) {
    throw Error(ExitCode::kUsage, "TB-CONTROL-SOCKET", "the control socket's name is too long for the system", path,
                "give the bench a shorter id, or set XDG_RUNTIME_DIR to a shorter folder");
  }
  std::memcpy(address.sun_path, path.data(), path.size());
  return address;
}

std::optional<std::string> receive(int descriptor, int wait_ms) {
  std::array<char, 4096> bytes{};
  pollfd ready{descriptor, POLLIN, 0};
  if (poll(&ready, 1, wait_ms) != 1) return std::nullopt;
  const ssize_t size = recv(descriptor, bytes.data(), bytes.size(), 0);
  if (size <= 0) return std::nullopt;
  return std::string(bytes.data(), static_cast<std::size_t>(size));
}

Word word_of(const std::string& text) {
  for (const Word word : {Word::kPause, Word::kResume, Word::kStop, Word::kAbort, Word::kPanic}) {
    if (text == to_string(word)) return word;
  }
  return Word::kStatus;
}

RunState state_of(const std::string& text) {
  for (int i = 0; i <= static_cast<int>(RunState::kEnded); ++i) {
    if (text == to_string(static_cast<RunState>(i))) return static_cast<RunState>(i);
  }
  return RunState::kEnded;
}

}  // namespace

ControlSocket::ControlSocket(const BenchConfig& bench, Control& control)
    : control_(control),
      path_(runtime_folder() + "/" + bench.id + (bench.in_process ? fmt::format(".{}", getpid()) : "") + ".sock") {
  const sockaddr_un address = address_of(path_);
  listener_ = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  unlink(path_.c_str());  // the bench's lock is ours: whoever left it is dead
  const auto* generic = reinterpret_cast<const sockaddr*>(&address);
  if (listener_ < 0 || bind(listener_, generic, sizeof(address)) != 0 || listen(listener_, 8) != 0) {
    const std::string why = std::strerror(errno);
    if (listener_ >= 0) close(listener_);
    throw Error(ExitCode::kUsage, "TB-CONTROL-SOCKET", "cannot open the control socket: " + why, path_,
                "check XDG_RUNTIME_DIR or the folder for temporary files");
  }
  stop_ = eventfd(0, EFD_CLOEXEC);
  thread_ = std::thread([this] { serve(); });
}

ControlSocket::~ControlSocket() {
  const std::uint64_t one = 1;
  (void)!write(stop_, &one, sizeof(one));
  thread_.join();
  close(stop_);
  close(listener_);
  unlink(path_.c_str());
}

void ControlSocket::serve() {
  for (;;) {
    std::array<pollfd, 2> ready{{{listener_, POLLIN, 0}, {stop_, POLLIN, 0}}};
    if (poll(ready.data(), ready.size(), -1) < 0) continue;
    if (ready[1].revents != 0) return;
    const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (client < 0) continue;
    answer(client);
    close(client);
  }
}

void ControlSocket::answer(int client) {
  const std::optional<std::string> asked = receive(client, kAnswerMs);
  if (!asked) return;
  ucred peer{};
  socklen_t size = sizeof(peer);
  getsockopt(client, SOL_SOCKET, SO_PEERCRED, &peer, &size);
  const Control::Answer answer = control_.ask(word_of(*asked), fmt::format("pid {}", peer.pid));
  const RunStatus status = control_.status();
  const json told{
      {"taken", answer.taken}, {"text", answer.text},    {"run", status.run},       {"state", to_string(status.state)},
      {"store", status.store}, {"label", status.label},  {"reason", status.reason}, {"step", status.step},
      {"steps", status.steps}, {"left_s", status.left_s}};
  const std::string text = analysis::printable_json(told);
  (void)send(client, text.data(), text.size(), MSG_NOSIGNAL);
}

std::optional<LiveRun> send_word(const std::string& socket_path, Word word) {
  const sockaddr_un address = address_of(socket_path);
  const int descriptor = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return std::nullopt;
  std::optional<std::string> text;
  const std::string asked = to_string(word);
  if (connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0 &&
      send(descriptor, asked.data(), asked.size(), MSG_NOSIGNAL) > 0) {
    text = receive(descriptor, kAnswerMs);
  }
  close(descriptor);
  if (!text) return std::nullopt;
  const json answer = analysis::try_json(*text);
  if (!answer.is_object()) return std::nullopt;
  LiveRun live;
  live.socket = socket_path;
  live.bench = std::filesystem::path(socket_path).stem().string();
  live.status.run = answer.value("run", std::int64_t{0});
  live.status.state = state_of(answer.value("state", ""));
  live.status.store = answer.value("store", "");
  live.status.label = answer.value("label", "");
  live.status.reason = answer.value("reason", "");
  live.status.step = answer.value("step", 0);
  live.status.steps = answer.value("steps", 0);
  live.status.left_s = answer.value("left_s", 0.0);
  live.taken = answer.value("taken", false);
  live.text = answer.value("text", "");
  return live;
}

std::vector<LiveRun> live_runs() {
  std::vector<LiveRun> found;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(runtime_folder(), ignored)) {
    if (entry.path().extension() != ".sock") continue;
    if (std::optional<LiveRun> live = send_word(entry.path().string(), Word::kStatus)) found.push_back(*live);
  }
  std::sort(found.begin(), found.end(), [](const LiveRun& a, const LiveRun& b) { return a.socket < b.socket; });
  return found;
}

}  // namespace tactbench::bench
