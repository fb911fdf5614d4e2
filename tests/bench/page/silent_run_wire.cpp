// Commands on the page to a run that sends its state but answers no command: how many wait, and the answer to each when
// it hangs up or stays silent. The run is a socket of the test's own.
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bench/run/control/locks.h"
#include "tests/bench/page/served_page.h"
#include "tests/support/endless_run.h"

using namespace tactbench;
using namespace tactbench::tests;
using nlohmann::json;

namespace {

// Listens where a bench's run would.
class SocketRun {
 public:
  explicit SocketRun(const std::string& bench) : name_(bench) {}
  ~SocketRun() {
    for (const auto& [words, descriptor] : clients_) ::close(descriptor);
  }
  SocketRun(const SocketRun&) = delete;
  SocketRun& operator=(const SocketRun&) = delete;
  // The next client's first words; it stays connected. Empty: none comes in time.
  std::string accept() {
    pollfd ready{name_.descriptor(), POLLIN, 0};
    if (::poll(&ready, 1, 20'000) != 1) return {};
    const int descriptor = ::accept(name_.descriptor(), nullptr, nullptr);
    pollfd said{descriptor, POLLIN, 0};
    std::array<char, 4096> bytes{};
    const ssize_t size = ::poll(&said, 1, 20'000) == 1 ? ::recv(descriptor, bytes.data(), bytes.size(), 0) : 0;
    clients_.emplace_back(std::string(bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0))), descriptor);
    return clients_.back().first;
  }
  void tell(std::size_t client, const json& words) const {
    const std::string text = words.dump();
    REQUIRE(::send(clients_.at(client).second, text.data(), text.size(), MSG_NOSIGNAL) > 0);
  }
  void hang_up(std::size_t client) {
    ::close(clients_.at(client).second);
    clients_.at(client).second = -1;
  }

 private:
  bench::MachineName name_;
  std::vector<std::pair<std::string, int>> clients_;
};

json status_of_run(const std::string& store, std::int64_t run) {
  return {{"bench", "page-words"}, {"run", run}, {"store", store}, {"state", "running"}};
}

std::unique_ptr<RawClient> send_word(const WordsPage& page, const std::string& word) {
  return page.send_command({{"word", word}, {"run", 4}});
}

bool is_live(const WordsPage& page) {
  RawClient viewer(page.server->port());
  (void)viewer.send(page.head("GET /events", page.server->access().read_token));
  return viewer.read(20'000, "\"unread\"").find("\"live\":true") != std::string::npos;
}

}  // namespace

TEST_CASE("silent run: sixteen commands wait, a further one is refused except panic, and each gets its result") {
  SocketRun run("page-words");
  WordsPage page;
  CHECK(run.accept() == "follow");
  run.tell(0, status_of_run(page.options.db, 4));
  REQUIRE(comes_true([&] { return is_live(page); }));
  std::vector<std::unique_ptr<RawClient>> waiting;
  for (int i = 0; i < 16; ++i) {
    waiting.push_back(send_word(page, i == 0 ? "pause" : "abort"));
    const std::string words = run.accept();
    CHECK_THAT(words, Catch::StartsWith(i == 0 ? "pause\n" : "abort\n") && Catch::Contains("bob"));
  }
  CHECK(WordsPage::answer_to(*send_word(page, "stop"))["taken"] == false);
  waiting.push_back(send_word(page, "panic"));
  CHECK_THAT(run.accept(), Catch::StartsWith("panic\n"));
  run.hang_up(1);
  CHECK(WordsPage::answer_to(*waiting[0])["taken"] == false);
  run.tell(2, {{"bench", "page-words"}, {"run", 4}, {"taken", true}, {"text", "it\nends"}});
  const json answered = WordsPage::answer_to(*waiting[1]);
  CHECK(answered["taken"] == true);
  CHECK_THAT(answered["text"].get<std::string>(), Catch::StartsWith("it") && Catch::EndsWith("ends"));
  for (std::size_t i = 2; i < 17; ++i) CHECK(WordsPage::answer_to(*waiting[i])["taken"] == false);
  auto again = send_word(page, "stop");  // there is room again
  CHECK_THAT(run.accept(), Catch::StartsWith("stop\n"));
}

TEST_CASE("silent run: a run that denies access or uses another store is not followed, invalid answers are ignored") {
  SocketRun run("page-words");
  WordsPage page;
  CHECK(run.accept() == "follow");
  run.tell(0, {{"bench", "page-words"}, {"denied", true}, {"text", "no"}});
  CHECK_FALSE(is_live(page));
  WordsPage other([&](bench::PageOptions& options) { options.db = page.options.db; });
  CHECK(run.accept() == "follow");
  const auto tell = [&](const std::string& text) { run.tell(1, text); };
  tell("no answer of a run");
  run.tell(1, status_of_run(page.options.db, 4));
  CHECK(comes_true([&] { return is_live(other); }));
  run.hang_up(1);
  CHECK(comes_true([&] { return !is_live(other); }));
}
