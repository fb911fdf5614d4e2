// Texts that people enter (UTF-8 by RFC 3629, all of it; of bounded length), tags, notes and voids.
#include <algorithm>
#include <catch2/catch.hpp>
#include <exception>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "db/remarks.h"
#include "db/sqlite.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::db;
using namespace tactbench::tests;
using tactbench::db::CodePoint;
using tactbench::db::decode_utf8;
using tactbench::db::is_blank;
using Words = std::vector<std::string>;

TEST_CASE("tags: are a sorted set of words, with one value per key") {
  NewStore store;
  const std::int64_t run = store_example(store), other = store_example(store);
  store.set_tags(run, {"night", "a:b", "night"}, {});
  CHECK(store.run(run).tags == Words{"a:b", "night"});
  CHECK(store.run(other).tags.empty());
  store.set_tags(run, {"new"}, {"night", "never-there"});
  CHECK(store.runs().front().tags == Words{"a:b", "new"});
  store.set_tags(run, {"lot=A7", "order=5"}, {});
  store.set_tags(run, {"lot=A8"}, {"order=5"});  // a key has one value
  CHECK(store.run(run).tags == Words{"a:b", "lot=A8", "new"});
  store.set_tags(run, {}, {"lot=A8"});
  CHECK(store.run(run).tags == Words{"a:b", "new"});
  for (const char* wrong :
       {"", "two words", "x\n", "ä", "a,b", "=x", "x=", "x=y=z", "@", "[", "`", "{", "/*", ";", " ", "\t", ","}) {
    CAPTURE(wrong);
    CHECK(store_error([&] { store.set_tags(run, {wrong}, {}); }) == "TB-STORE-TAG");
    CHECK(store_error([&] { store.set_tags(run, {}, {wrong}); }) == "TB-STORE-TAG");
  }
  CHECK(store_error([&] { store.set_tags(run, {std::string(65, 'x')}, {}); }) == "TB-STORE-TAG");
  CHECK(store_error([&] { store.set_tags(99, {"a"}, {}); }) == "TB-STORE-NOT-FOUND");
  CHECK(store.run(run).tags == Words{"a:b", "new"});
  store.set_tags(run, {std::string(64, 'x'), "AZaz09._:/+-"}, {"a:b", "new"});
  CHECK(store.run(run).tags == Words{"AZaz09._:/+-", std::string(64, 'x')});
  // A key is the whole word before the sign, and has one value.
  store.set_tags(other, {"lot=A", "lots=B", "lo=C", "lot", "a=b"}, {});
  store.set_tags(other, {"lot=D"}, {});
  store.set_tags(other, {"lot"}, {"a=c"});
  CHECK(store.run(other).tags == Words{"a=b", "lo=C", "lot", "lot=D", "lots=B"});
  CHECK(store.check_content(run).holds());
}

TEST_CASE("notes: are lines that can only be added") {
  NewStore store;
  const std::int64_t run = store_example(store);
  store.add_note(run, "first");
  store.add_note(run, "second, \"quoted\"");
  CHECK(store.run(run).notes == "first\nsecond, \"quoted\"");
  for (const char* nothing : {"", " ", "\n\t"})
    CHECK(store_error([&] { store.add_note(run, nothing); }) == "TB-STORE-BLANK");
  CHECK(store_error([&] { store.add_note(99, "x"); }) == "TB-STORE-NOT-FOUND");
  CHECK(store.check_content(run).holds());
}

TEST_CASE("void run: is kept with reason and name, and is not a reference for later runs") {
  NewStore store;
  const std::int64_t run = store_example(store);
  REQUIRE(store.last_check("S-1", "seating", "pass", run + 1));
  CHECK(store_error([&] { store.void_run(run, " ", "me", "2026-01-01T00:00:00Z"); }) == "TB-STORE-BLANK");
  CHECK(store_error([&] { store.void_run(run, "why", "", "2026-01-01T00:00:00Z"); }) == "TB-STORE-BLANK");
  CHECK(store_error([&] { store.void_run(run, "why", "me", ""); }) == "TB-STORE-CONFLICT");
  CHECK_FALSE(store.run(run).is_void());
  store.void_run(run, "gauge was closed", "N. Nobody", "2026-01-01T00:00:00Z");
  const db::RunRecord record = store.run(run);
  CHECK((record.is_void() && record.void_reason == "gauge was closed" && record.void_by == "N. Nobody"));
  CHECK(store.frame_count(run) == 3);
  CHECK(store.check_content(run).holds());
  CHECK_FALSE(store.last_check("S-1", "seating", "pass", run + 1));
  CHECK(store.check_seals(run).empty());
  CHECK(store_error([&] { store.void_run(run, "again", "me", "2026-01-02T00:00:00Z"); }) == "TB-STORE-CONFLICT");
  const std::int64_t open = store.begin_run(example_run());
  CHECK(store_error([&] { store.void_run(open, "why", "me", "2026-01-01T00:00:00Z"); }) == "TB-STORE-CONFLICT");
  db::sqlite::Connection raw(store.path(), db::sqlite::Access::kReadWrite);
  CHECK(raw.integer("SELECT void FROM v_runs WHERE run = 1") == 1);
  CHECK(raw.integer("SELECT void FROM v_runs WHERE run = 2") == 0);
  CHECK(store_error([&] { raw.execute("UPDATE runs SET void_by = ''"); }) == "TB-STORE-CONFLICT");
}

namespace {

std::string umlauts(std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += "ä";
  return text;
}

}  // namespace

TEST_CASE("run store: names, purposes, notes and reasons have a maximum length in characters") {
  NewStore store;
  const std::string name(db::kMaxNameLength + 1, 'n'), text(db::kMaxTextLength + 1, 't');
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
  record.operator_name = umlauts(db::kMaxNameLength);
  record.purpose = text;
  refused([&] { store.begin_run(record); });
  CHECK(store.runs().empty());
  record.purpose = umlauts(db::kMaxTextLength);
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

TEST_CASE("run store: names without a visible character are refused as blank") {
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

TEST_CASE("run store: device texts have a maximum length and must be UTF-8, otherwise nothing is stored") {
  NewStore store;
  store.add_sensor(example_sensor());
  db::RunRecord record = example_run();
  record.devices.clear();
  const std::int64_t run = store.begin_run(record);
  const std::string name(db::kMaxNameLength + 1, 'n');
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
    device.*field = umlauts(db::kMaxNameLength);
    store.set_devices(run, {device});
    CHECK(store.run(run).devices.front().*field == umlauts(db::kMaxNameLength));
  }
  CHECK(store.runs().size() == 1);
}

TEST_CASE("run store: a run has at most a hundred tags") {
  NewStore store;
  const std::int64_t run = store_example(store);
  std::vector<std::string> tags;
  for (std::size_t i = 0; i < db::kMaxTags; ++i) tags.push_back("tag" + std::to_string(i));
  store.set_tags(run, tags, {});
  CHECK(store_error([&] { store.set_tags(run, {"one-more"}, {}); }) == "TB-STORE-TAG");
  CHECK(store.run(run).tags.size() == db::kMaxTags);
  store.set_tags(run, {"one-more"}, {"tag0"});
}

TEST_CASE("run store: a text that is too long is a usage error, not damage of the store") {
  std::exception_ptr thrown;
  try {
    db::check_text("the note", std::string(db::kMaxTextLength + 1, 't'), db::kMaxTextLength);
  } catch (...) {
    thrown = std::current_exception();
  }
  REQUIRE(thrown);
  CHECK(bench::as_error(thrown).id() == "TB-STORE-TOO-LONG");
  CHECK(bench::as_error(thrown).code() == bench::ExitCode::kUsage);
}

namespace {

char of(std::uint32_t byte) { return static_cast<char>(static_cast<unsigned char>(byte)); }

// As section 3 of the RFC draws the bits.
std::string encoded(std::uint32_t value) {
  const auto tail = [&](int shift) { return of(0x80 | ((value >> shift) & 0x3f)); };
  if (value < 0x80) return {of(value)};
  if (value < 0x800) return {of(0xc0 | (value >> 6)), tail(0)};
  if (value < 0x10000) return {of(0xe0 | (value >> 12)), tail(6), tail(0)};
  return {of(0xf0 | (value >> 18)), tail(12), tail(6), tail(0)};
}

}  // namespace

TEST_CASE("UTF-8: every character is decoded, whatever follows, and surrogates are refused") {
  std::size_t wrong = 0;
  for (std::uint32_t value = 0; value <= 0x10ffff; ++value) {
    const std::string bytes = encoded(value);
    const CodePoint found = decode_utf8(bytes + "\x80z");
    const bool surrogate = value >= 0xd800 && value <= 0xdfff;
    const bool right = surrogate ? !found.valid && found.bytes == 1
                                 : found.valid && found.value == value && found.bytes == bytes.size();
    if (!right && wrong++ < 5) FAIL_CHECK("U+" << std::hex << value);
  }
  CHECK(wrong == 0);
}

TEST_CASE("UTF-8: two bytes are a character only if RFC 3629 allows it") {
  for (std::uint32_t first = 0x80; first < 0x100; ++first) {
    for (std::uint32_t second = 0; second < 0x100; ++second) {
      const bool valid = first >= 0xc2 && first <= 0xdf && second >= 0x80 && second <= 0xbf;
      if (decode_utf8(std::string{of(first), of(second)}).valid != valid) FAIL_CHECK(first << " " << second);
    }
  }
}

TEST_CASE("UTF-8: overlong forms, surrogates, values above U+10FFFF and cut sequences are one invalid byte") {
  for (const std::string& bytes : std::vector<std::string>{
           "\xe0\x9f\xbf",     "\xe0\x80\x80",     "\xed\xa0\x80",     "\xed\xbf\xbf", "\xf0\x8f\xbf\xbf",
           "\xf0\x80\x80\x80", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xc1\xbf",     "\xc2",
           "\xe1\x80",         "\xf1\x80\x80",     "\xe1z\x80",        "\xe1\x80z",    "\xf1z\x80\x80",
           "\xf1\x80z\x80",    "\xf1\x80\x80z",    "\xe1\xc0\x80",     "\xff",         "\x80"}) {
    const CodePoint found = decode_utf8(bytes);
    CAPTURE(bytes);
    CHECK_FALSE(found.valid);
    CHECK((found.bytes == 1 && found.value == 0));
  }
}

TEST_CASE("UTF-8: Unicode white space and invisible marks are blank, and no other character") {
  using Span = std::pair<std::uint32_t, std::uint32_t>;
  // PropList.txt: White_Space.
  const std::vector<Span> white = {{0x0009, 0x000D}, {0x0020, 0x0020}, {0x0085, 0x0085}, {0x00A0, 0x00A0},
                                   {0x1680, 0x1680}, {0x2000, 0x200A}, {0x2028, 0x2029}, {0x202F, 0x202F},
                                   {0x205F, 0x205F}, {0x3000, 0x3000}};
  // Soft hyphen, Arabic letter mark, fillers of Hangul, Mongolian vowel separator; joiners and marks of direction,
  // twice; word joiner to the last of its block; selectors of variants; byte order mark.
  const std::vector<Span> unseen = {{0x00AD, 0x00AD}, {0x061C, 0x061C}, {0x115F, 0x1160}, {0x3164, 0x3164},
                                    {0x180E, 0x180E}, {0x200B, 0x200F}, {0x202A, 0x202E}, {0x2060, 0x206F},
                                    {0xFE00, 0xFE0F}, {0xFEFF, 0xFEFF}};
  const auto in = [](const std::vector<Span>& spans, std::uint32_t value) {
    return std::ranges::any_of(spans, [&](const Span& span) { return value >= span.first && value <= span.second; });
  };
  for (std::uint32_t value = 0; value <= 0x10ffff; ++value)
    if (is_blank(encoded(value)) != (in(white, value) || in(unseen, value))) FAIL_CHECK("U+" << std::hex << value);
  CHECK(is_blank(""));
  CHECK(is_blank(" \xe2\x80\x8b\t"));
  CHECK_FALSE(is_blank(" a"));
  CHECK_FALSE(is_blank("a "));
  CHECK_FALSE(is_blank(" \x80"));
}
