// Faults of the store and the process: disk full, read-only, locked, a request to end. Same points.
#include <atomic>
#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <memory>
#include <thread>
#include <utility>

#include "db/sqlite.h"
#include "tests/faults/failing_disk.h"
#include "tests/faults/faulty_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

Breakage disk(const std::string& name, int error) {
  Breakage made;
  made.name = name;
  made.strike = [=](bench::Rig&, const std::string&) { disk_fails_with(error); };
  made.mend = [] { disk_fails_with(0); };
  made.store_gone = true;
  return made;
}

// Another process' connection, as far as SQLite can tell.
Breakage other_connection(const std::string& name, const std::string& begin) {
  const auto other = std::make_shared<std::unique_ptr<db::sqlite::Connection>>();
  Breakage made;
  made.name = name;
  made.strike = [=](bench::Rig&, const std::string& store) {
    *other = std::make_unique<db::sqlite::Connection>(store, db::sqlite::Access::kReadWrite);
    (*other)->execute(begin);
  };
  made.mend = [=] { other->reset(); };
  return made;
}

// Longer than a run waits for it.
Breakage locked_for_long() {
  const auto writer = std::make_shared<std::thread>();
  const auto writes = std::make_shared<std::atomic<bool>>(false);
  Breakage made;
  made.name = "store locked by a writer";
  made.strike = [=](bench::Rig&, const std::string& store) {
    auto other = std::make_shared<db::sqlite::Connection>(store, db::sqlite::Access::kReadWrite);
    other->execute("BEGIN IMMEDIATE");
    *writes = true;
    *writer = std::thread([writes, lock = std::move(other)]() mutable {
      std::this_thread::sleep_for(std::chrono::seconds(7));
      *writes = false;
      lock.reset();
    });
  };
  made.holds = [=] { return writes->load(); };
  made.mend = [=] { writer->join(); };
  return made;
}

Breakage request_to_end(const std::string& name, int signal, int times) {
  Breakage made;
  made.name = name;
  made.strike = [=](bench::Rig&, const std::string&) {
    for (int i = 0; i < times; ++i) (void)raise(signal);
  };
  return made;
}

}  // namespace

TEST_CASE("chamber run: disk full, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, disk("disk full", ENOSPC));
}
TEST_CASE("press run: disk full, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, disk("disk full", ENOSPC));
}
TEST_CASE("chamber run: disk read-only, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, disk("disk read-only", EROFS));
}
TEST_CASE("press run: disk read-only, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, disk("disk read-only", EROFS));
}
TEST_CASE("chamber run: store read by another connection, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, other_connection("store read by another", "BEGIN; SELECT count(*) FROM frames"));
}
TEST_CASE("press run: store read by another connection, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, other_connection("store read by another", "BEGIN; SELECT count(*) FROM frames"));
}
// Each wait for the lock costs 7 s, so at three points alone. No night has it: the lock lasts in real time while a
// night's clock is turned, so how long the sensor rests, and with it each later frame, would be the machine's.
TEST_CASE("chamber run: store locked by a writer, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, locked_for_long(), {Point::kRising, Point::kTurning});
}
TEST_CASE("press run: store locked by a writer, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, locked_for_long(), {Point::kReleasing});
}
TEST_CASE("chamber run: store locked permanently, frames are kept and the reported safe state is correct") {
  Breakage locked = other_connection("store locked for good", "BEGIN IMMEDIATE");
  locked.store_gone = true;
  check_row(Bench::kChamber, locked, {Point::kVent});
}
TEST_CASE("chamber run: SIGTERM received, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, request_to_end("SIGTERM", SIGTERM, 1));
}
TEST_CASE("press run: SIGTERM received, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, request_to_end("SIGTERM", SIGTERM, 1));
}
TEST_CASE("chamber run: Ctrl-C pressed twice, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, request_to_end("Ctrl-C twice", SIGINT, 2));
}
TEST_CASE("press run: Ctrl-C pressed twice, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, request_to_end("Ctrl-C twice", SIGINT, 2));
}
