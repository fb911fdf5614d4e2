#include "bench/run/control/control_socket.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/json_io.h"
#include "bench/common/error.h"
#include "bench/common/for_people.h"
#include "bench/common/private_files.h"
#include "bench/run/control/peer.h"

namespace tactbench::bench {

namespace {

constexpr std::size_t kMostClients = 64;
constexpr int kAcceptedAtOnce = 16;
constexpr int kShortOfDescriptorsMs = 20;

MachineName own_name(const BenchConfig& bench, const MachineName* given) {
  if (given != nullptr) return {};
  const std::string name = file_name(bench.id);
  MachineName taken(bench.in_process ? fmt::format("{}/process/{}", name, getpid()) : name);
  if (taken.held()) return taken;
  throw Error(ExitCode::kUsage, "TB-BENCH-LOCKED", fmt::format("bench '{}' is in use by {}", bench.id, taken.owner()),
              shown_name(taken.text()), "wait for it to end, or end it: tactbench stop");
}

Command command_of(const std::string& text) {
  for (const Command command : {Command::kPause, Command::kResume, Command::kStop, Command::kAbort, Command::kPanic}) {
    if (text == to_string(command)) return command;
  }
  return Command::kStatus;
}

bool hung_up(int descriptor) {
  pollfd looked{descriptor, POLLOUT, 0};
  return ::poll(&looked, 1, 0) == 1 && (looked.revents & (POLLHUP | POLLERR)) != 0;
}

}  // namespace

ControlSocket::ControlSocket(const BenchConfig& bench, Control& control, std::int64_t run,
                             const MachineName* bench_name)
    : control_(control),
      bench_(bench.id),
      own_(own_name(bench, bench_name)),
      listener_(bench_name != nullptr ? *bench_name : own_),
      group_(commanding_group()),
      run_name_(fmt::format("{}/run/{}", listener_.text(), run)),
      stop_(::eventfd(0, EFD_CLOEXEC)) {
  thread_ = std::thread([this] { serve(); });
}

ControlSocket::~ControlSocket() {
  const std::uint64_t one = 1;
  (void)!::write(stop_, &one, sizeof(one));
  thread_.join();
  ::close(stop_);
  for (const Client& client : clients_) ::close(client.descriptor);
}

void ControlSocket::serve() {
  for (;;) {
    std::vector<pollfd> ready{{stop_, POLLIN, 0}, {listener_.descriptor(), POLLIN, 0}};
    for (const Client& client : clients_) ready.push_back({client.descriptor, POLLIN, 0});
    if (::poll(ready.data(), ready.size(), -1) < 0) continue;
    if (ready[0].revents != 0) return;
    std::vector<Client> waiting;
    for (std::size_t i = 0; i < clients_.size(); ++i) {
      if (ready[i + 2].revents == 0 || !answer(clients_[i])) {
        waiting.push_back(clients_[i]);
      } else {
        ::close(clients_[i].descriptor);
      }
    }
    clients_ = std::move(waiting);
    if (ready[1].revents != 0) accept_some();
  }
}

// A few per round: a client that keeps connecting does not block the others.
void ControlSocket::accept_some() {
  for (int i = 0; i < kAcceptedAtOnce; ++i) {
    const int descriptor = ::accept4(listener_.descriptor(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (descriptor < 0) {
      if (errno == EMFILE || errno == ENFILE || errno == ENOMEM) (void)::poll(nullptr, 0, kShortOfDescriptorsMs);
      return;
    }
    make_room();
    const std::optional<Peer> peer = peer_of(descriptor, group_);
    clients_.push_back({descriptor, peer && is_trusted(*peer, ::geteuid()), peer});
  }
}

// A silent client is dropped for a new one; clients without the right to command are dropped first.
void ControlSocket::make_room() {
  if (clients_.size() < kMostClients) return;
  auto oldest = std::find_if(clients_.begin(), clients_.end(), [](const Client& client) { return !client.trusted; });
  if (oldest == clients_.end()) oldest = clients_.begin();
  ::close(oldest->descriptor);
  clients_.erase(oldest);
}

bool ControlSocket::answer(const Client& client) {
  std::array<char, 64> bytes{};
  const ssize_t size = ::recv(client.descriptor, bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return false;
  if (size <= 0) return true;
  const std::string who =
      client.peer ? peer_text(*client.peer) : "unknown";  // a look into a file: not for each that comes
  nlohmann::json told{{"bench", bench_}, {"denied", !client.trusted}};
  if (client.trusted) {
    const Command command = command_of(std::string(bytes.data(), static_cast<std::size_t>(size)));
    // This process may have been stopped since the command came; a client that gave up does not expect the run to
    // continue later.
    if (command == Command::kResume && hung_up(client.descriptor)) return true;
    const Control::Answer answer = control_.ask(command, who);
    told.update({{"taken", answer.taken}, {"text", one_line(answer.text, kLongestAnswer)}});
    tell_status(told, control_.status());
  } else {
    told["text"] = fmt::format("{} may not command it: root, user {} and members of the group '{}' may", who,
                               ::geteuid(), kGroupName);
  }
  const std::string text = analysis::printable_json(told);
  (void)::send(client.descriptor, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  return true;
}

}  // namespace tactbench::bench
