// `benchmark page` on short runs with the page's real process, and its viewers against a listener of the test's.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "bench/benchmarks/page.h"
#include "bench/benchmarks/page_viewers.h"
#include "db/run_store.h"
#include "tests/bench/benchmarks/counted_time.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using tests::CountedTime;
using tests::TemporaryFolder;

namespace {

PageSizes short_page() {
  PageSizes sizes;
  sizes.viewers = 2;
  sizes.pace = 450.0;  // 1.1 s: the page looks for runs every quarter of a second
  sizes.repeats = 2;
  sizes.pace_of_pair = 1500.0;
  sizes.before_run = std::chrono::milliseconds(100);
  sizes.least_pictures = 1;
  return sizes;
}

constexpr int kRunReadings = 2 * 211;  // of the clock in a repeat of a run: two a step

double reading_s(int n) { return 0.5 * n * (n + 1); }

// Of a run of so many repeats whose readings begin behind `before`.
double wall_of_run(int before, int repeats) {
  return reading_s(before + repeats * kRunReadings - 1) - reading_s(before + 1);
}
double thread_of_run(int before, int repeats) {
  return reading_s(before + repeats * kRunReadings) - reading_s(before + 2);
}

// A listener on loopback, and who came.
class ViewersDoor {
 public:
  ViewersDoor() : door_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof place;
    REQUIRE(::bind(door_, reinterpret_cast<const sockaddr*>(&place), size) == 0);
    REQUIRE(::listen(door_, 8) == 0);
    REQUIRE(::getsockname(door_, reinterpret_cast<sockaddr*>(&place), &size) == 0);
    port_ = ntohs(place.sin_port);
  }
  ~ViewersDoor() {
    close_door();
    forget_viewers();
  }
  ViewersDoor(const ViewersDoor&) = delete;
  ViewersDoor& operator=(const ViewersDoor&) = delete;
  [[nodiscard]] std::uint16_t port() const { return port_; }
  void close_door() {
    if (door_ >= 0) ::close(door_);
    door_ = -1;
  }
  void forget_viewers() {
    for (const int link : links_) ::close(link);
    links_.clear();
  }
  // What the next one asks, up to the empty line.
  std::string next_asks() {
    links_.push_back(::accept4(door_, nullptr, nullptr, SOCK_CLOEXEC));
    std::string asked;
    std::array<char, 4096> bytes{};
    while (!asked.ends_with("\r\n\r\n")) {
      const ssize_t size = ::recv(links_.back(), bytes.data(), bytes.size(), 0);
      if (size <= 0) break;
      asked.append(bytes.data(), static_cast<std::size_t>(size));
    }
    return asked;
  }
  void tell(std::size_t viewer, const std::string& text) const {
    CHECK(::send(links_.at(viewer), text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size()));
  }
  // How many bytes it takes at once before it has to wait: all of them, when somebody reads.
  [[nodiscard]] std::size_t takes(std::size_t viewer, std::size_t bytes) const {
    const std::string piece(1U << 16U, '.');
    std::size_t taken = 0;
    const auto last = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (taken < bytes && std::chrono::steady_clock::now() < last) {
      const ssize_t size = ::send(links_.at(viewer), piece.data(), piece.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (size > 0) taken += static_cast<std::size_t>(size);
    }
    return taken;
  }

 private:
  int door_;
  std::uint16_t port_ = 0;
  std::vector<int> links_;
};

std::string picture_at(int position) {
  return "event: picture\ndata: {\"run\":1,\"position\":" + std::to_string(position) + "}\n\n";
}

}  // namespace

TEST_CASE("benchmark page: each viewer asks for the events with the token, and the first one's pictures count") {
  ViewersDoor door;
  const std::ptrdiff_t descriptors = tests::descriptors_left_open();
  { const PageViewers passing(door.port(), "", 2, 0); }
  CHECK(tests::descriptors_left_open() == descriptors);
  for (int i = 0; i < 2; ++i) CHECK(door.next_asks().find("Bearer \r\n") != std::string::npos);
  door.forget_viewers();
  PageViewers viewers(door.port(), "a-token", 3, 1);
  for (int i = 0; i < 3; ++i)
    CHECK(door.next_asks() == "GET /events HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(door.port()) +
                                  "\r\nAuthorization: Bearer a-token\r\n\r\n");
  const auto begun = std::chrono::steady_clock::now();
  door.tell(1, picture_at(5));
  door.tell(2, picture_at(6));
  CHECK(door.takes(1, 16U << 20U) >= 16U << 20U);  // the second one reads, and what it reads is dropped
  door.tell(0, picture_at(1) + picture_at(2));
  // It has got that when it has read on: so much does not lie between two sockets.
  CHECK(door.takes(0, 8U << 20U) >= 8U << 20U);
  const auto& pictures = viewers.pictures();
  REQUIRE(pictures.size() == 2);
  for (const int position : {1, 2}) {
    CHECK(pictures.at(position) >= begun);
    CHECK(pictures.at(position) <= std::chrono::steady_clock::now());
  }
  CHECK(viewers.text().starts_with(picture_at(1) + picture_at(2) + "...."));
}

TEST_CASE("benchmark page: a page that takes no connection is an error") {
  ViewersDoor door;
  door.close_door();
  CHECK_THROWS_WITH(PageViewers(door.port(), "", 1, 0), "the page takes no connection");
}

TEST_CASE("benchmark page: rates of the served run, and runs alone and beside viewers, by a clock of the test's") {
  const TemporaryFolder folder;
  std::size_t readings = 0;
  const std::ptrdiff_t descriptors = tests::descriptors_left_open();
  const std::vector<Figure> figures = [&] {
    const CountedTime time;
    std::vector<Figure> found = benchmark_page(1, folder.path(), short_page(), tests::program_path());
    readings = time.readings().size();
    return found;
  }();
  CHECK(tests::descriptors_left_open() == descriptors);
  std::map<std::string, double> named;
  for (const Figure& figure : figures) CHECK(named.emplace(figure.name.substr(5), figure.value).second);
  // The earlier run, then its begin, the served run and its end, then the bare writes.
  const int before_pair = kRunReadings + 1 + kRunReadings + 1 + 2;
  REQUIRE(readings == static_cast<std::size_t>(before_pair + (2 + 1 + 2) * kRunReadings));
  const double took_s = reading_s(2 * kRunReadings + 2) - reading_s(kRunReadings + 1);
  CHECK(named.at("frames") == Approx(211 / took_s).epsilon(1e-9));
  CHECK(named.at("core_bare_writes") == Approx(100.0 * before_pair / took_s).epsilon(1e-9));
  const double pictures = named.at("pictures") * took_s;
  CHECK(pictures == Approx(std::round(pictures)).margin(1e-6));
  CHECK(pictures >= 1.0);
  CHECK(pictures <= 211.0);
  CHECK(named.at("core") >= 0.0);
  CHECK(named.at("core") * took_s < 100.0 * 20.0);
  CHECK(named.at("resident") > 2.0);
  CHECK(named.at("resident") < 2000.0);
  CHECK(named.at("stored_to_viewer_median") > -1000.0);
  CHECK(named.at("stored_to_viewer_median") < 20e3);
  // The pair: alone, an earlier run of the store that is seen, seen.
  const int seen = before_pair + (2 + 1) * kRunReadings;
  const double alone_s = wall_of_run(before_pair, 2);
  CHECK(named.at("step") == Approx(1e6 * alone_s / (2 * 211)).epsilon(1e-9));
  CHECK(named.at("step_with_viewers_wall") == Approx(wall_of_run(seen, 2) / alone_s).epsilon(1e-9));
  CHECK(named.at("step_with_viewers") == Approx(thread_of_run(seen, 2) / thread_of_run(before_pair, 2)).epsilon(1e-9));
  CHECK(named.size() == 14);
  const db::RunStore alone = db::RunStore::open_read_only(folder.path("alone-0.db"));
  CHECK(alone.runs().size() == 1);
  CHECK(alone.frame_count(1) == 2 * 211);
  CHECK(alone.run(1).seed == 1);
  for (const char* name : {"served.db", "seen-0.db"}) {
    const db::RunStore store = db::RunStore::open_read_only(folder.path(name));
    CHECK(store.runs().size() == 2);
    CHECK(store.frame_count(1) == 211);
    CHECK(store.frame_count(2) == (std::string(name) == "served.db" ? 211 : 2 * 211));
  }
}

TEST_CASE("benchmark page: viewers that see too little are an error, and one frozen viewer alone sees nothing") {
  const TemporaryFolder folder;
  PageSizes sizes = short_page();
  sizes.viewers = 1;  // reads while a run is served, and is the frozen one beside a run
  sizes.repeats = 1;
  CHECK_THROWS_WITH(benchmark_page(1, folder.path(), sizes, tests::program_path()), "the viewers did not see the run");
  const TemporaryFolder other;
  sizes.least_pictures = 10000;
  sizes.pace = 0.0;
  CHECK_THROWS_WITH(benchmark_page(1, other.path(), sizes, tests::program_path()),
                    "the viewers saw too little of the run");
}
