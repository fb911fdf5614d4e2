// Texts that people enter have a bounded length, and longer ones are refused before anything is stored.
#include <catch2/catch.hpp>
#include <exception>

#include "bench/common/error.h"
#include "db/utf8.h"
#include "tests/db/new_store.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;

namespace {

std::string umlauts(std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += "ä";
  return text;
}

}  // namespace

TEST_CASE("names, purposes, notes and reasons have a maximum length in characters") {
  NewStore store;
  const std::string name(db::kLongestName + 1, 'n'), text(db::kLongestText + 1, 't');
  const auto refused = [](auto action) { CHECK(store_error(action) == "TB-STORE-TOO-LONG"); };
  db::SensorRecord sensor = example_sensor();
  sensor.note = text;
  refused([&] { store.add_sensor(sensor); });
  for (const char* odd : {"\xff", "S\xc3", "\xc0\xaf", "\xed\xa0\x80", "\xe0\x80\xaf", "\xf4\x90\x80\x80", "\x80"}) {
    sensor = example_sensor();
    sensor.serial = odd;
    CHECK(store_error([&] { store.add_sensor(sensor); }) == "TB-STORE-NOT-TEXT");
  }
  CHECK(store.sensors().empty());
  store.add_sensor(example_sensor());
  db::RunRecord record = example_run();
  record.operator_name = umlauts(db::kLongestName);
  record.purpose = text;
  refused([&] { store.begin_run(record); });
  CHECK(store.runs().empty());
  record.purpose = umlauts(db::kLongestText);
  CHECK(store.begin_run(record) == 1);
  const std::int64_t run = store_example(store);
  refused([&] { store.add_note(run, text); });
  refused([&] { store.void_run(run, text, "me", "2026"); });
  refused([&] { store.void_run(run, "why", name, "2026"); });
  refused([&] { store.add_report({run, "1-a", "a", name, "2026", "", ""}); });
  store.replace_figures(run, "rig", {{"x_psi", 1.0}});
  refused([&] { store.add_baseline({0, "rig", text, "me", "2026", {run}}); });
  refused([&] { store.add_baseline({0, "rig", "why", name, "2026", {run}}); });
  const db::RunRecord stored = store.run(run);
  CHECK((stored.notes.empty() && !stored.is_void() && store.reports(run).empty() && store.baselines().empty()));
}

TEST_CASE("names without a visible character are refused as a usage error") {
  NewStore store;
  for (const char* blank : {" ", "\t\n", "\u00a0\u2003", "\u200b", "\ufeff\u3000"}) {
    db::SensorRecord sensor = example_sensor();
    sensor.serial = blank;
    CHECK(store_error([&] { store.add_sensor(sensor); }) == "TB-STORE-BLANK");
    sensor = example_sensor();
    sensor.scanner_serial = blank;
    CHECK(store_error([&] { store.add_sensor(sensor); }) == "TB-STORE-BLANK");
    CHECK(db::is_blank(blank));
  }
  CHECK(store.sensors().empty());
  db::SensorRecord any_scanner = example_sensor();
  any_scanner.serial = "\u00a0S 1";
  any_scanner.scanner_serial = "";
  store.add_sensor(any_scanner);
  store.add_sensor(example_sensor());
  db::RunRecord record = example_run();
  record.operator_name = "  ";
  CHECK(store_error([&] { store.begin_run(record); }) == "TB-STORE-BLANK");
  record.operator_name = "";  // of an imported table nobody need be known
  CHECK(store.begin_run(record) == 1);
  CHECK((db::is_blank("") && !db::is_blank("\xff") && !db::is_blank(" \u00fc ")));
}

TEST_CASE("texts from an instrument have a maximum length and are UTF-8, else none of them is stored") {
  NewStore store;
  store.add_sensor(example_sensor());
  db::RunRecord record = example_run();
  record.devices.clear();
  const std::int64_t run = store.begin_run(record);
  const std::string name(db::kLongestName + 1, 'n');
  for (std::string db::DeviceRecord::*field :
       {&db::DeviceRecord::model, &db::DeviceRecord::serial, &db::DeviceRecord::firmware}) {
    db::DeviceRecord device{"tactile scanner", "M", "S", "1", "simulated", "{}"};
    for (const auto& [text, id] :
         {std::pair(name, "TB-STORE-TOO-LONG"), std::pair(std::string("S\xff"), "TB-STORE-NOT-TEXT")}) {
      device.*field = text;
      CHECK(store_error([&] { store.set_devices(run, {device}); }) == id);
      record.devices = {device};
      CHECK(store_error([&] { store.begin_run(record); }) == id);
    }
    device.*field = umlauts(db::kLongestName);
    store.set_devices(run, {device});
    CHECK(store.run(run).devices.front().*field == umlauts(db::kLongestName));
  }
  CHECK(store.runs().size() == 1);
}

TEST_CASE("a run has a hundred tags at most") {
  NewStore store;
  const std::int64_t run = store_example(store);
  std::vector<std::string> tags;
  for (std::size_t i = 0; i < db::kMostTags; ++i) tags.push_back("tag" + std::to_string(i));
  store.set_tags(run, tags, {});
  CHECK(store_error([&] { store.set_tags(run, {"one-more"}, {}); }) == "TB-STORE-TAG");
  CHECK(store.run(run).tags.size() == db::kMostTags);
  store.set_tags(run, {"one-more"}, {"tag0"});
}

TEST_CASE("texts that are too long are a usage error, not damage of the store") {
  std::exception_ptr thrown;
  try {
    db::check_words("the note", std::string(db::kLongestText + 1, 't'), db::kLongestText);
  } catch (...) {
    thrown = std::current_exception();
  }
  REQUIRE(thrown);
  CHECK(bench::as_error(thrown).id() == "TB-STORE-TOO-LONG");
  CHECK(bench::as_error(thrown).code() == bench::ExitCode::kUsage);
}
