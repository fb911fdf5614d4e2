// Waits on a wire: their time, what they report, and how an end that still owes an answer prolongs them.
#include "devices/wire/wait.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <functional>
#include <memory>
#include <thread>

#include "devices/wire/ends/end_activity.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

// On the stack its mutex may lie where another's lay before, which ThreadSanitizer then takes for one.
std::unique_ptr<EndActivity> on_the_heap() { return std::make_unique<EndActivity>(); }

using Real = std::chrono::steady_clock;

struct WaitedLine {
  WaitedLine() { REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) == 0); }
  ~WaitedLine() {
    for (const int end : ends) ::close(end);
  }
  WaitedLine(const WaitedLine&) = delete;
  WaitedLine& operator=(const WaitedLine&) = delete;
  void put() const { REQUIRE(::send(ends[1], "x", 1, 0) == 1); }
  std::array<int, 2> ends{-1, -1};
};

Nanoseconds spent(const std::function<void()>& act) {
  const auto begin = Real::now();
  act();
  return Real::now() - begin;
}

}  // namespace

TEST_CASE("wait: lasts at least as long as requested, and returns immediately for 0 or less") {
  const WaitedLine line;
  for (const Nanoseconds timeout : {Nanoseconds(3ms), Nanoseconds(1'050ms)}) {
    const Nanoseconds took = spent([&] { CHECK(wait_for(line.ends[0], POLLIN, timeout) == 0); });
    CHECK(took >= timeout);
    CHECK(took < timeout + 10s);
  }
  for (const Nanoseconds timeout : {Nanoseconds(0), Nanoseconds(-1h)}) {
    CHECK(spent([&] { CHECK(wait_for(line.ends[0], POLLIN, timeout) == 0); }) < 10s);
  }
}

TEST_CASE("wait: reports an event at once") {
  const WaitedLine line;
  CHECK(wait_for(line.ends[0], POLLOUT, 1h) == POLLOUT);
  line.put();
  for (const Nanoseconds timeout : {Nanoseconds(-1), Nanoseconds(0), Nanoseconds(1), Nanoseconds(1h)}) {
    CHECK(wait_for(line.ends[0], POLLIN, timeout) == POLLIN);
  }
  ::shutdown(line.ends[1], SHUT_RDWR);
  CHECK((wait_for(line.ends[0], POLLIN, 1h) & POLLHUP) != 0);
  const int closed = ::dup(line.ends[0]);
  ::close(closed);
  CHECK(wait_for(closed, POLLIN, 1h) == POLLNVAL);
}

TEST_CASE("wait: left_until is the time to a moment, and 1 ms after it while a simulated instrument is busy") {
  CHECK(left_until(Real::now() + 1h) > 59min);
  CHECK(left_until(Real::now() + 1h) <= 1h);
  CHECK(left_until(Real::now()) == 0ns);
  CHECK(left_until(Real::now() - 1h) == 0ns);
  const auto held_end = on_the_heap();  // at work until its first wait
  EndActivity& end = *held_end;
  CHECK(left_until(Real::now() + 1h) > 59min);
  CHECK(left_until(Real::now()) == 1ms);
  CHECK(left_until(Real::now() - 5s) == 1ms);
  CHECK(left_until(Real::now() - 20s) == 0ns);  // it will never finish
  const WaitedLine line;
  for (const Nanoseconds none : {Nanoseconds(0), Nanoseconds(-1)}) {  // who does not wait does not wait for an end
    CHECK(spent([&] { CHECK(wait_for(line.ends[0], POLLIN, none) == 0); }) < 10s);
  }
  end.leave();
  CHECK(left_until(Real::now()) == 0ns);
}

TEST_CASE("wait: continues while a simulated instrument is busy, and receives what it sends last") {
  const WaitedLine line;
  for (const Nanoseconds timeout : {Nanoseconds(1), Nanoseconds(1ms)}) {
    const auto held_end = on_the_heap();
    EndActivity& end = *held_end;
    std::thread worker = end.thread([&] {
      std::this_thread::sleep_for(60ms);
      [[maybe_unused]] const ssize_t sent = ::send(line.ends[1], "x", 1, 0);
    });
    CHECK(wait_for(line.ends[0], POLLIN, timeout) == POLLIN);
    worker.join();
    std::array<char, 4> into{};
    CHECK(::recv(line.ends[0], into.data(), into.size(), 0) == 1);
  }
  const auto held_idle = on_the_heap();
  EndActivity& idle = *held_idle;
  std::thread worker = idle.thread([] {});
  worker.join();
  CHECK(wait_for(line.ends[0], POLLIN, 1ms) == 0);
}

TEST_CASE("busy instrument: is busy until its first wait and while it has input, and never in a child process") {
  CHECK_FALSE(EndActivity::any());
  {
    const auto held_made = on_the_heap();
    CHECK(EndActivity::any());
    const pid_t child = ::fork();
    if (child == 0) ::_exit(EndActivity::any() ? 1 : 0);
    int status = -1;
    REQUIRE(::waitpid(child, &status, 0) == child);
    CHECK(status == 0);
  }
  CHECK_FALSE(EndActivity::any());
  const WaitedLine line;
  {
    const auto held_end = on_the_heap();
    EndActivity& end = *held_end;
    std::array<pollfd, 1> watched{pollfd{line.ends[0], POLLIN, 0}};
    CHECK(end.wait(watched, 5ms) == 0);
    CHECK(EndActivity::any());  // works again, on what its wait brought
    auto second = std::make_unique<EndActivity>();
    end.leave();
    CHECK(EndActivity::any());
    second.reset();
    CHECK_FALSE(EndActivity::any());
  }
  const auto held_end = on_the_heap();
  EndActivity& end = *held_end;
  std::array<pollfd, 1> seen{pollfd{line.ends[0], POLLIN, 0}};
  int ready = -1;
  std::thread waiter([&] {
    ready = end.wait(seen);
    end.leave();
  });
  for (int i = 0; i < 20'000 && EndActivity::any(); ++i) std::this_thread::sleep_for(1ms);
  CHECK_FALSE(EndActivity::any());  // it waits, and there is nothing to read
  line.put();
  waiter.join();
  CHECK(ready == 1);
  CHECK(seen[0].revents == POLLIN);
}

TEST_CASE("busy instrument: a wait lasts for its time, and a failed one keeps errno") {
  const WaitedLine line;
  const auto held_end = on_the_heap();
  EndActivity& end = *held_end;
  std::array<pollfd, 1> watched{pollfd{line.ends[0], POLLIN, 0}};
  for (const Nanoseconds longest : {Nanoseconds(0), Nanoseconds(7ms), Nanoseconds(1'020ms)}) {
    const Nanoseconds took = spent([&] { CHECK(end.wait(watched, longest) == 0); });
    CHECK(took >= longest);
    CHECK(took < longest + 10s);
  }
  CHECK(end.wait(watched, Nanoseconds(-1)) == -1);
  CHECK(errno == EINVAL);
  line.put();
  CHECK(end.wait(watched, 1h) == 1);
}
