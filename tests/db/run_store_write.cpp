// Writing a run: what is refused before it reaches the file, and what two programs at one store leave of it.
#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>

#include "db/sqlite.h"
#include "tests/db/new_store.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

TEST_CASE("run store: a void branch accepts no frame, from its own run or another") {
  NewStore store;
  const Begun begun = begin_example(store);
  REQUIRE(begun.run == 1);
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  store.void_branch(begun.branch, "scanner lost");
  CHECK(store_error([&] { store.append_frame(begun.run, example_frame(begun.branch, 1)); }) == "TB-STORE-CONFLICT");
  CHECK(store.frame_count(begun.run) == 1);
  const std::int64_t other_run = store.begin_run(example_run());
  CHECK(store_error([&] { store.append_frame(other_run, example_frame(begun.branch, 1)); }) == "TB-STORE-CONFLICT");
}

TEST_CASE("run store: names of a run and of a sensor have a maximum length") {
  NewStore store;
  const std::string longest(db::kMaxNameLength, 'n'), longer = longest + 'n';
  for (std::string db::SensorRecord::*member :
       {&db::SensorRecord::serial, &db::SensorRecord::type, &db::SensorRecord::scanner_serial}) {
    db::SensorRecord sensor = example_sensor();
    sensor.serial = "S-" + std::to_string(store.sensors().size());
    sensor.*member = longer;
    CHECK(store_error([&] { store.add_sensor(sensor); }) == "TB-STORE-TOO-LONG");
    sensor.*member = longest;
    CHECK(store_error([&] { store.add_sensor(sensor); }).empty());
  }
  CHECK(store.sensors().size() == 3);
  store.add_sensor(example_sensor());
  for (std::string db::RunRecord::*member :
       {&db::RunRecord::operator_name, &db::RunRecord::scanner_serial, &db::RunRecord::bench_id}) {
    db::RunRecord run = example_run();
    run.*member = longer;
    CHECK(store_error([&] { store.begin_run(run); }) == "TB-STORE-TOO-LONG");
    run.*member = longest;
    CHECK(store_error([&] { store.begin_run(run); }).empty());
  }
  CHECK(store.runs().size() == 3);
}

TEST_CASE("run store: a sensor is registered once, and not again with another type or scanner") {
  NewStore store;
  store.add_sensor(example_sensor());
  store.add_sensor(example_sensor());
  db::SensorRecord second = example_sensor();
  second.serial = "A-2";
  second.scanner_serial = "SC-9";
  second.note = "other";
  store.add_sensor(second);
  const auto sensors = store.sensors();
  REQUIRE(sensors.size() == 2);
  CHECK((sensors[0].serial == "A-2" && sensors[0].scanner_serial == "SC-9" && sensors[0].note == "other"));
  CHECK((sensors[1].type == "array-3x2" && sensors[1].type_toml == "rows = 3\n" && sensors[1].added_utc != ""));
  CHECK(sensors[1].type_sha256 == example_sensor().type_sha256);
  CHECK_FALSE(store.sensor("none"));
  db::SensorRecord other_type = example_sensor();
  other_type.type_sha256 = "other";
  CHECK(store_error([&] { store.add_sensor(other_type); }) == "TB-STORE-CONFLICT");
  db::SensorRecord other_scanner = example_sensor();
  other_scanner.scanner_serial = "SC-8";
  CHECK(store_error([&] { store.add_sensor(other_scanner); }) == "TB-STORE-CONFLICT");
  CHECK((store.sensor("S-1")->scanner_serial == "SC-7" && store.sensor("S-1")->note == "first"));
  db::RunRecord unknown = example_run();
  unknown.sensor_serial = "S-9";
  CHECK(store_error([&] { store.begin_run(unknown); }) == "TB-STORE-CONFLICT");
}

TEST_CASE("run store: devices are replaced as a whole, until the first frame") {
  NewStore store;
  const Begun begun = begin_example(store);
  store.set_devices(begun.run, {{"stage", "Z-1", "7", "6.0", "simulated", "{}"}});
  store.set_devices(begun.run, {{"b", "", "", "", "", ""}, {"a", "", "", "", "", ""}});
  const auto devices = store.run(begun.run).devices;
  REQUIRE(devices.size() == 2);
  CHECK((devices[0].role == "b" && devices[1].role == "a"));
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  CHECK(store_error([&] { store.set_devices(begun.run, {}); }) == "TB-STORE-CONFLICT");
  CHECK(store.run(begun.run).devices.size() == 2);
  store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
  CHECK(store.check_content(begun.run).holds());
}

TEST_CASE("run store: devices of a run that another program ended are not replaced") {
  NewStore own;
  RunStore other = RunStore::open(own.path());
  own.add_sensor(example_sensor());
  const std::int64_t run = own.begin_run(example_run());
  own.set_seen(run, kUtc);  // it is known here as open
  REQUIRE(other.mark_interrupted(kUtc) == 1);
  CHECK(store_error([&] { own.set_devices(run, {}); }) == "TB-STORE-CONFLICT");
  CHECK(other.run(run).devices.size() == 2);
  CHECK(other.check_content(run).holds());
}

TEST_CASE("run store: a run that two programs wrote in turn is closed with all rows of the file") {
  NewStore one;
  RunStore two = RunStore::open(one.path());
  const Begun begun = begin_example(one);
  one.append_frame(begun.run, example_frame(begun.branch, 0));  // it knows of one frame
  two.append_frame(begun.run, example_frame(begun.branch, 1));
  REQUIRE(one.mark_interrupted(kUtc) == 1);
  CHECK(one.check_content(begun.run).holds());
  CHECK(one.check_content(begun.run).frames == 2);
  // The other goes on with it, and then the first again.
  two.reopen_run(begun.run, {9, "state", "", "resumed"});
  two.append_frame(begun.run, example_frame(begun.branch, 2));
  one.append_frame(begun.run, example_frame(begun.branch, 3));
  one.end_run(begun.run, db::Outcome::kStopped, "", db::SafeState::kVerified, kUtc);
  CHECK(one.check_content(begun.run).holds());
  CHECK(one.frame_count(begun.run) == 4);
}

TEST_CASE("run store: a resumed run continues after its last frame, whichever process wrote it") {
  NewStore one;
  RunStore two = RunStore::open(one.path());
  const Begun begun = begin_example(one);
  one.append_frame(begun.run, example_frame(begun.branch, 0));
  two.append_frame(begun.run, example_frame(begun.branch, 1));
  REQUIRE(two.mark_interrupted(kUtc) == 1);
  one.reopen_run(begun.run, {9, "state", "", "resumed"});
  one.append_frame(begun.run, example_frame(begun.branch, 2));
  one.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
  CHECK(one.check_content(begun.run).holds());
  CHECK(one.frame_count(begun.run) == 3);
}

TEST_CASE("write-ahead log: a log of exactly 1000 pages is kept, one a byte shorter is lengthened") {
  // A write-ahead log is a header of 32 bytes, then 24 bytes and a page for each page that it holds.
  for (const std::uintmax_t length : {1000 * (4096 + 24) + 32 - 1, 1000 * (4096 + 24) + 32}) {
    const TemporaryFolder folder;
    const std::string log = folder.path("runs.db-wal");
    RunStore store = RunStore::open(folder.path("runs.db"), db::Durability::kFull);
    store.add_sensor(example_sensor());
    std::filesystem::resize_file(log, length);
    store.begin_run(example_run());
    CHECK((std::filesystem::file_size(log) == length) == (length == 1000 * (4096 + 24) + 32));
  }
}

TEST_CASE("run store: a missing run cannot be read, extended or annotated") {
  NewStore store;
  const std::int64_t run = store_example(store);
  db::FitRecord fit;
  fit.run = 99;
  fit.model = "elam";
  const std::int64_t own_fit = store.add_fit({0, run, "elam", true, 1, "", "", "", ""});
  const std::vector<std::pair<std::string, std::function<void()>>> questions = {
      {"run", [&] { (void)store.run(99); }},
      {"branches", [&] { (void)store.branches(99); }},
      {"frames", [&] { (void)store.frames(99); }},
      {"for_each_frame", [&] { store.for_each_frame(99, [](const db::FrameRecord&) {}); }},
      {"frame_count", [&] { (void)store.frame_count(99); }},
      {"events", [&] { (void)store.events(99); }},
      {"checks", [&] { (void)store.checks(99); }},
      {"series", [&] { (void)store.series(99); }},
      {"check_content", [&] { (void)store.check_content(99); }},
      {"check_seals", [&] { (void)store.check_seals(99); }},
      {"content_hash", [&] { (void)store.content_hash(99); }},
      {"fits", [&] { (void)store.fits(99); }},
      {"fit", [&] { (void)store.fit(99); }},
      {"default_fit", [&] { (void)store.default_fit(99); }},
      {"verdicts", [&] { (void)store.verdicts(99); }},
      {"verdicts_of_models", [&] { (void)store.verdicts_of_models(99); }},
      {"reports", [&] { (void)store.reports(99); }},
      {"add_fit", [&] { store.add_fit(fit); }},
      {"replace_verdicts", [&] { store.replace_verdicts(99, 0, {}); }},
      {"replace_verdicts by a fit", [&] { store.replace_verdicts(99, own_fit, {}); }},
      {"replace_figures", [&] { store.replace_figures(99, "rig", {}); }},
      {"add_report",
       [&] {
         store.add_report({99, "99-a", "a", "me", "2026", "", ""});
       }},
      {"set_tags", [&] { store.set_tags(99, {}, {}); }},
      {"add_note", [&] { store.add_note(99, "x"); }},
      {"void_run", [&] { store.void_run(99, "why", "me", "2026"); }},
      {"set_devices", [&] { store.set_devices(99, {}); }},
      {"set_state", [&] { store.set_state(99, "running", {}); }},
      {"begin_branch", [&] { store.begin_branch(99, example_branch()); }},
      {"void_branch", [&] { store.void_branch(99, "why"); }},
      {"append_frame", [&] { store.append_frame(99, example_frame(1, 0)); }},
      {"append_event", [&] { store.append_event(99, {}); }},
      {"append_check", [&] { store.append_check(99, {}); }},
      {"append_series", [&] { store.append_series(99, {}); }},
      {"set_rest", [&] { store.set_rest(99, 1.0); }},
      {"set_seen", [&] { store.set_seen(99, "2026"); }},
      {"end_run", [&] { store.end_run(99, db::Outcome::kFailed, "", {}, ""); }},
      {"reopen_run", [&] { store.reopen_run(99, {}); }}};
  for (const auto& [name, question] : questions) {
    INFO(name);
    CHECK(store_error(question) == "TB-STORE-NOT-FOUND");
  }
  CHECK((store.fits(run).size() == 1 && store.check_seals(run).empty() && store.check_structure().empty()));
}

TEST_CASE("run store: an ended run accepts no more data") {
  NewStore store;
  const std::int64_t run = store_example(store);
  const std::vector<std::pair<std::string, std::function<void()>>> changes = {
      {"set_devices", [&] { store.set_devices(run, {}); }},
      {"set_state", [&] { store.set_state(run, "running", {}); }},
      {"begin_branch", [&] { store.begin_branch(run, example_branch()); }},
      {"void_branch", [&] { store.void_branch(2, "why"); }},
      {"append_frame", [&] { store.append_frame(run, example_frame(2, 2)); }},
      {"append_event", [&] { store.append_event(run, {}); }},
      {"append_check", [&] { store.append_check(run, {}); }},
      {"append_series", [&] { store.append_series(run, {}); }},
      {"set_rest", [&] { store.set_rest(run, 1.0); }},
      {"set_seen", [&] { store.set_seen(run, "2026"); }},
      {"end_run", [&] { store.end_run(run, db::Outcome::kFailed, "", {}, ""); }}};
  for (const auto& [name, change] : changes) {
    INFO(name);
    CHECK(store_error(change) == "TB-STORE-CONFLICT");
  }
  CHECK(store.check_content(run).holds());
  const db::RunRecord record = store.run(run);
  CHECK((!record.rest_s && record.seen_utc.empty()));
}

TEST_CASE("run store: an unknown text for an outcome or a safe state is refused") {
  NewStore store;
  const std::int64_t run = store_example(store);
  Connection raw(store.path(), Access::kReadWrite);
  raw.execute("PRAGMA ignore_check_constraints = ON");
  const auto read_with = [&](const std::string& change) {
    raw.execute("UPDATE runs SET " + change);
    return store_error([&] { (void)store.run(run); });
  };
  CHECK(read_with("outcome = 'done'") == "TB-STORE-SQL");
  CHECK(read_with("outcome = 'completed', safe_state = 'fine'") == "TB-STORE-SQL");
  CHECK(read_with("safe_state = 'verified'").empty());
}

TEST_CASE("run store: rest time and forces at the ends of a branch are absent unless stored") {
  NewStore store;
  const Begun begun = begin_example(store);
  CHECK_FALSE(store.run(begun.run).rest_s);
  store.set_rest(begun.run, 0.0);
  CHECK(store.run(begun.run).rest_s == 0.0);
  for (int i = 1; i < 4; ++i) {
    db::BranchRecord branch = example_branch();
    branch.attempt = i;
    if (i != 1) branch.from_n.reset();
    if (i != 2) branch.to_n.reset();
    store.begin_branch(begun.run, branch);
  }
  const auto branches = store.branches(begun.run);
  REQUIRE(branches.size() == 4);
  CHECK((branches[1].from_n == 2.1 && !branches[1].to_n));
  CHECK((!branches[2].from_n && branches[2].to_n == 30.3));
  CHECK((!branches[3].from_n && !branches[3].to_n));
}

TEST_CASE("run store: the last time of a run is that of its last frame or event, whichever is later") {
  NewStore store;
  const Begun begun = begin_example(store);
  CHECK(store.last_time_ns(begun.run) == 0);
  store.append_event(begun.run, {7, "note", "", ""});
  CHECK(store.last_time_ns(begun.run) == 7);
  store.append_frame(begun.run, example_frame(begun.branch, 3));
  CHECK(store.last_time_ns(begun.run) == example_frame(1, 3).time_ns);
  store.append_event(begun.run, {example_frame(1, 3).time_ns + 1, "note", "", ""});
  CHECK(store.last_time_ns(begun.run) == example_frame(1, 3).time_ns + 1);
  CHECK(store.last_time_ns(99) == 0);
}
