// A PostgreSQL server for one connection that answers by a test's script: on a Unix socket in a temporary folder, in a
// process of its own. The bytes are those of PostgreSQL's manual, "Frontend/Backend Protocol", "Message Formats".
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "db/fleet/postgres.h"
#include "tests/support/process.h"

namespace tactbench::tests::postgres {

inline std::string number(std::size_t value, int bytes) {  // big-endian
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(static_cast<unsigned char>(value >> (8 * i)));
  return text;
}
inline std::string message(char kind, const std::string& payload) {
  return kind + number(payload.size() + 4, 4) + payload;
}
inline std::string ready() { return message('Z', "I"); }
inline std::string done(const std::string& tag) { return message('C', tag + '\0'); }
inline std::string started() { return message('R', number(0, 4)) + ready(); }
inline std::string error(const std::string& code, const std::string& said) {
  return message('E', std::string("SERROR") + '\0' + "VERROR" + '\0' + "C" + code + '\0' + "M" + said + '\0' + '\0');
}
using Field = std::optional<std::string>;  // none: NULL
// To a statement with parameters: its rows.
inline std::string rows(std::size_t columns, const std::vector<std::vector<Field>>& all) {
  std::string heads = number(columns, 2);
  for (std::size_t i = 0; i < columns; ++i)
    heads += "name" + std::string(1, '\0') + number(0, 4) + number(0, 2) + number(25, 4) + number(0xffff, 2) +
             number(0xffffffff, 4) + number(0, 2);
  std::string text = message('1', "") + message('2', "") + message('T', heads);
  for (const std::vector<Field>& row : all) {
    std::string fields = number(row.size(), 2);
    for (const Field& field : row) fields += field ? number(field->size(), 4) + *field : number(0xffffffff, 4);
    text += message('D', fields);
  }
  return text + done("SELECT") + ready();
}

struct Answer {
  enum class Then { kListens, kHangsUp, kIsDeaf };
  Answer(std::string text, Then after = Then::kListens) : bytes(std::move(text)), then(after) {}
  Answer(const char* text) : bytes(text) {}
  std::string bytes;  // empty: it is silent
  Then then = Then::kListens;
};
inline const Answer kHangsUp{"", Answer::Then::kHangsUp};

class Server {
 public:
  // The first answer is to the start of the connection, each other one to a statement or to the end of a copy. After
  // the last it only listens.
  explicit Server(std::vector<Answer> answers) : answers_(std::move(answers)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string path = folder_.path(".s.PGSQL.5432");
    if (path.size() >= sizeof address.sun_path) throw std::runtime_error("the folder's name is too long for a socket");
    std::copy(path.begin(), path.end(), address.sun_path);
    const int door = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (::bind(door, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 || ::listen(door, 1) != 0)
      throw std::runtime_error("no socket in a temporary folder");
    child_ = fork();
    if (child_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      const int link = ::accept(door, nullptr, nullptr);
      ::close(door);  // further connections are refused
      serve(link);
      _exit(0);
    }
    ::close(door);
    if (child_ < 0) throw std::runtime_error("fork failed");
  }
  ~Server() { end(); }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] std::string conninfo() const { return "host=" + folder_.path() + " dbname=tactile user=bench_a"; }
  [[nodiscard]] std::string where() const { return "tactile on " + folder_.path() + ":5432"; }

  // The messages received, once the connection is closed: the start, then each message as its letter and its content.
  [[nodiscard]] std::vector<std::string> heard() {
    int status = 0;
    if (child_ > 0) waitpid(child_, &status, 0);
    child_ = -1;
    const std::string all = read_file(folder_.path("heard"));
    std::vector<std::string> messages;
    for (std::size_t at = 0, head = 0; at + head + 4 <= all.size(); head = 1) {
      const std::size_t size = length_at(all, at + head);
      messages.push_back(all.substr(at, head) + all.substr(at + head + 4, size - 4));
      at += head + size;
    }
    return messages;
  }

 private:
  static std::size_t length_at(const std::string& bytes, std::size_t at) {
    std::size_t value = 0;
    for (std::size_t i = at; i < at + 4; ++i) value = (value << 8U) | static_cast<unsigned char>(bytes[i]);
    return value;
  }
  void serve(int link) {
    const int file = ::open(folder_.path("heard").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
    std::string left;
    std::size_t head = 0, answered = 0;
    std::vector<char> buffer(1U << 16U);
    for (;;) {
      const ssize_t got = ::recv(link, buffer.data(), buffer.size(), 0);
      if (got <= 0 || ::write(file, buffer.data(), static_cast<std::size_t>(got)) != got) return;
      left.append(buffer.data(), static_cast<std::size_t>(got));
      while (left.size() >= head + 4 && left.size() >= head + length_at(left, head)) {
        const bool asks = head == 0 || std::strchr("QScf", left.front()) != nullptr;
        left.erase(0, head + length_at(left, head));
        head = 1;
        if (!asks || answered >= answers_.size()) continue;
        const Answer& answer = answers_[answered++];
        for (std::size_t sent = 0; sent < answer.bytes.size();) {
          const ssize_t put = ::send(link, answer.bytes.data() + sent, answer.bytes.size() - sent, MSG_NOSIGNAL);
          if (put <= 0) return;
          sent += static_cast<std::size_t>(put);
        }
        if (answer.then == Answer::Then::kHangsUp) return;
        while (answer.then == Answer::Then::kIsDeaf) ::pause();
      }
    }
  }
  void end() {
    if (child_ <= 0) return;
    ::kill(child_, SIGKILL);
    int status = 0;
    waitpid(child_, &status, 0);
    child_ = -1;
  }

  TemporaryFolder folder_;
  std::vector<Answer> answers_;
  pid_t child_ = -1;
};

// The error of the fleet that an action ends with; an empty one when it ends without.
struct Told {
  std::string id, message, remedy;
  db::fleet::FleetCause cause = db::fleet::FleetCause::kUsage;
};
template <class Action>
Told told(Action action) {
  try {
    action();
  } catch (const db::fleet::FleetError& error) {
    return {error.id(), error.what(), error.remedy(), error.cause()};
  }
  return {};
}

inline constexpr std::chrono::seconds kSoon(1);  // that a test waits for a server that is silent

}  // namespace tactbench::tests::postgres
