#include "bench/run/control/control_socket.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "analysis/json_io.h"
#include "bench/common/error.h"
#include "bench/common/private_files.h"
#include "bench/common/terminal.h"
#include "bench/run/control/control_client.h"
#include "bench/run/control/locks.h"

namespace tactbench::bench {

namespace {

constexpr std::size_t kMostClients = 64;
constexpr int kAcceptedAtOnce = 16;
constexpr int kShortOfDescriptorsMs = 20;
constexpr std::ptrdiff_t kMostFollowers = 16;
constexpr int kFollowMs = 50;                          // between two statuses to a follower
constexpr std::chrono::milliseconds kSignOfLife{500};  // a status without changes
constexpr std::chrono::seconds kFollowerSilent{30};    // one that reads nothing for so long is dropped
constexpr int kUnreadBytes = 16 * 1024;                // that wait for a follower; the kernel takes twice as much

MachineName own_name(const BenchConfig& bench, const MachineName* given) {
  if (given != nullptr) return {};
  const std::string name = file_name(bench.id);
  MachineName taken(bench.in_process ? fmt::format("{}/process/{}", name, getpid()) : name);
  if (taken.held()) return taken;
  throw Error("TB-BENCH-LOCKED", fmt::format("bench '{}' is in use by {}", bench.id, taken.owner()),
              shown_name(taken.text()));
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
  if (stop_ < 0) throw Error("TB-SYSTEM-LIMIT", fmt::format("the run's socket: {}", std::strerror(errno)), bench_);
  thread_ = std::thread([this] { serve(); });
}

ControlSocket::~ControlSocket() {
  const std::uint64_t one = 1;
  (void)!::write(stop_, &one, sizeof(one));
  thread_.join();
  ::close(stop_);
  if (spare_ >= 0) ::close(spare_);
  for (const Client& client : clients_) ::close(client.descriptor);
}

void ControlSocket::serve() {
  for (;;) {
    std::vector<pollfd> ready{{stop_, POLLIN, 0}, {listener_.descriptor(), POLLIN, 0}};
    for (const Client& client : clients_) ready.push_back({client.descriptor, POLLIN, 0});
    const bool followed = std::ranges::any_of(clients_, &Client::follows);
    if (spare_ < 0) spare_ = ::fcntl(stop_, F_DUPFD_CLOEXEC, 0);
    if (::poll(ready.data(), ready.size(), followed ? kFollowMs : -1) < 0) continue;
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
    send_to_followers();
  }
}

void ControlSocket::send_to_followers() {
  const auto now = std::chrono::steady_clock::now();
  const std::uint64_t news = control_.news();
  std::string text;
  std::erase_if(clients_, [&](Client& client) {
    if (!client.follows || now - client.sent < std::chrono::milliseconds(kFollowMs)) return false;
    if (client.news == news && now - client.sent < kSignOfLife) return false;
    if (text.empty()) text = reply(client, {});
    if (::send(client.descriptor, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT) >= 0) {
      client.sent = now;
      client.news = news;
      return false;
    }
    const bool full = errno == EAGAIN || errno == ENOBUFS;
    if (full && now - client.sent < kFollowerSilent) return false;
    ::close(client.descriptor);
    return true;
  });
}

void ControlSocket::begin_following(Client& client) {
  (void)::setsockopt(client.descriptor, SOL_SOCKET, SO_SNDBUF, &kUnreadBytes, sizeof kUnreadBytes);
  client.follows = true;
}

// A few per round: a client that keeps connecting does not block the others.
void ControlSocket::accept_some() {
  for (int i = 0; i < kAcceptedAtOnce; ++i) {
    const auto accept = [this] {
      return ::accept4(listener_.descriptor(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    };
    int descriptor = accept();
    if (descriptor < 0 && errno == EMFILE && spare_ >= 0) {
      ::close(std::exchange(spare_, -1));
      descriptor = accept();
    }
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

std::string ControlSocket::reply(const Client& client, const Control::Answer& answer) const {
  nlohmann::json message{{"bench", bench_}, {"denied", !client.trusted}};
  if (client.trusted) {
    message.update({{"taken", answer.taken}, {"text", one_line(answer.text, kMaxAnswerColumns)}});
    add_status_json(message, control_.status());
  } else {
    message["text"] = answer.text;
  }
  return analysis::printable_json(message);
}

bool ControlSocket::answer(Client& client) {
  std::array<char, kMaxRequestBytes> bytes{};
  const ssize_t size = ::recv(client.descriptor, bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return false;
  if (size <= 0 || client.follows) return true;  // a follower sends nothing more
  // Reads a file, so not for each client.
  std::string who = client.peer ? peer_text(*client.peer) : "unknown";
  Control::Answer answer;
  if (client.trusted) {
    const ClientRequest words = parse_client_request({bytes.data(), static_cast<std::size_t>(size)});
    if (!words.behalf.empty()) who = fmt::format("{}, through {}", words.behalf, who);
    if (words.word == ClientRequestKind::kFollow) {
      if (std::ranges::count_if(clients_, &Client::follows) < kMostFollowers) {
        begin_following(client);
        return false;
      }
      answer.text = fmt::format("{} follow this run already", kMostFollowers);
    } else if (words.word == ClientRequestKind::kAnswer) {
      if (hung_up(client.descriptor)) return true;
      answer = control_.answer(words.question, words.text, who);
    } else {
      // This process may have been stopped since the command came; a client that gave up does not expect the run to
      // continue later.
      if (words.command == Command::kResume && hung_up(client.descriptor)) return true;
      answer = control_.ask(words.command, who);
    }
  } else {
    answer.text = fmt::format("{} may not command it: root, user {} and members of the group '{}' may", who,
                              ::geteuid(), kGroupName);
  }
  const std::string text = reply(client, answer);
  (void)::send(client.descriptor, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  return true;
}

}  // namespace tactbench::bench
