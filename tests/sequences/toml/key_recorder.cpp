// Which keys a recorder notes of what is read, each with type, range and default.
#include "sequences/toml/key_recorder.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <stdexcept>

#include "sequences/toml/strict_toml.h"

using namespace tactbench::sequences;

namespace {

using Lines = std::vector<std::string>;

// "key | type | ranges | defaults", with a "!" before a key that is required.
Lines noted_by(const KeyRecorder& recorder) {
  Lines lines;
  for (const KeyUse& use : recorder.keys()) {
    lines.push_back(fmt::format("{}{} | {} | {} | {}", use.required ? "!" : "", use.key, use.type,
                                fmt::join(use.ranges, "; "), fmt::join(use.defaults, "; ")));
  }
  return lines;
}

TomlTable table_of_text(const std::string& text, const std::string& file = "t") {
  return TomlDocument::from_text(text, file).root();
}

// Without a fallback.
void read_required(const TomlTable& root) {
  (void)root.number("number");
  (void)root.integer("whole", 2, 4);
  (void)root.integer("only", 3, 3);
  (void)root.text("text");
  (void)root.name("name");
  (void)root.word("word", {"up", "down"});
  (void)root.numbers("numbers");
  (void)root.number_lists("pairs", 2);
}

void read_optional(const TomlTable& root) {
  (void)root.number("number", 0.1);
  (void)root.number_in("in", 0.25, -1.0, 2e7);
  (void)root.zero_or_in("zero_or", 0.0, 3.0, 6.5);
  (void)root.integer("whole", -1, 2, 4);
  (void)root.boolean("yes", true);
  (void)root.boolean("no", false);
  (void)root.text("text", "own");
  (void)root.date_text("date");
  (void)root.texts("texts");
  (void)root.word("word", "up", {"up", "down"});
  (void)root.numbers_or_one("several", 1.5);
  (void)root.span("span", {-0.5, 4.0});
}

}  // namespace

TEST_CASE("keys that must be there are noted as required, with type and range, in the order of reading") {
  const KeyRecorder recorder;
  read_required(
      table_of_text("number = 1.5\nwhole = 3\nonly = 3\ntext = \"\"\nname = \"n\"\nword = \"up\"\n"
                    "numbers = [1]\npairs = [[1, 2]]\n"));
  CHECK(noted_by(recorder) == Lines{"!number | number |  | ", "!whole | whole number | 2 to 4 | ",
                                    "!only | whole number | 3 | ", "!text | text |  | ", "!name | text | not blank | ",
                                    "!word | one of | up, down | ", "!numbers | list of numbers |  | ",
                                    "!pairs | lists of 2 numbers |  | "});
}

TEST_CASE("keys with a fallback are noted with it as TOML, whether the file has them or not") {
  const Lines wanted = {"number | number |  | 0.1",
                        "in | number | -1 to 2e+07 | 0.25",
                        "zero_or | number | 0, or 3 to 6.5 | 0",
                        "whole | whole number | 2 to 4 | -1",
                        "yes | true or false |  | true",
                        "no | true or false |  | false",
                        "text | text |  | \"own\"",
                        "date | date |  | \"\"",
                        "texts | list of texts |  | []",
                        "word | one of | up, down | \"up\"",
                        "several | number, or list of numbers |  | 1.5",
                        "span | [low, high] | low < high | [-0.5, 4]"};
  for (const char* text :
       {"",
        "number = 7\nin = -1\nzero_or = 4\nwhole = 3\nyes = false\nno = true\ntext = \"x\"\ndate = 2026-01-09\n"
        "texts = [\"a\"]\nword = \"down\"\nseveral = [2, 3]\nspan = [1, 2]\n"}) {
    INFO(text);
    const KeyRecorder recorder;
    read_optional(table_of_text(text));
    CHECK(noted_by(recorder) == wanted);
  }
}

TEST_CASE("a key is noted once, with all its ranges and defaults and the first of its types") {
  const KeyRecorder recorder;
  const TomlTable root = table_of_text("k = 3\nl = 3\n");
  (void)root.number_in("k", 1.0, 0.0, 5.0);
  (void)root.number_in("k", 2.0, 0.0, 9.0);
  (void)root.number_in("k", 1.0, 0.0, 5.0);
  (void)root.integer("k", 0, 9);
  (void)root.number("l");
  (void)root.number("l", 4.0);
  CHECK(noted_by(recorder) == Lines{"k | number | 0 to 5; 0 to 9 | 1; 2", "l | number |  | 4"});
}

TEST_CASE("a key that was asked for first need not be there, and the next reading's fallback is none of its defaults") {
  const KeyRecorder recorder;
  const TomlTable root = table_of_text("a = 1\nb = 2\nc = 3\nd = 4\n");
  if (root.has("a")) (void)root.number("a");
  if (root.has("b")) (void)root.number("b", 9.0);
  const bool asked = root.has("c");
  (void)root.number("d");
  if (asked) (void)root.number("c", 9.0);  // not the next reading: who asked before does not matter to it
  (void)root.number("d", 8.0);
  (void)root.has("e");
  CHECK(noted_by(recorder) ==
        Lines{"a | number |  | ", "b | number |  | ", "c | number |  | 9", "d | number |  | 8", "e |  |  | "});
}

TEST_CASE("keys are noted with the tables that they lie in, elements of a list without their numbers") {
  const KeyRecorder recorder;
  const TomlTable root = table_of_text("[a.b]\nc = 1\n[[l]]\nd = 1\n[[l]]\nd = 2\ne = 3\n[[l.m]]\nf = 4\n");
  (void)root.table("a").table("b").number("c");
  for (const TomlTable& one : root.tables("l")) {
    (void)one.number("d");
    (void)one.number("e", 0.0);
    for (const TomlTable& inner : one.tables("m")) (void)inner.number("f");
  }
  CHECK(noted_by(recorder) == Lines{"!a.b.c | number |  | ", "l |  |  | ", "!l[].d | number |  | ",
                                    "l[].e | number |  | 0", "l[].m |  |  | ", "!l[].m[].f | number |  | "});
}

TEST_CASE("names that a file chooses are noted as NAME") {
  const KeyRecorder recorder;
  const TomlTable root = table_of_text(
      "p_other = 1\n[p.dwell]\nlow = 1\n[p.\"\"]\nlow = 2\n[[l]]\n[l.q]\none = 1\n\"t.wo\" = 2\n[l.r]\nthree = 3\n");
  const TomlTable names = root.table("p");
  for (const std::string& name : names.keys()) {
    (void)names.table(name).number("low");
    (void)names.table(name).table("deep").number("er", 1.0);
  }
  for (const TomlTable& one : root.tables("l")) {
    const TomlTable chosen = one.table("q");
    for (const std::string& name : chosen.keys()) (void)chosen.number(name);
    (void)one.table("r").number("three");
  }
  (void)root.number("p_other");
  CHECK(noted_by(recorder) == Lines{"!p.NAME.low | number |  | ", "p.NAME.deep.er | number |  | 1", "l |  |  | ",
                                    "!l[].q.NAME | number |  | ", "!l[].r.three | number |  | ",
                                    "!p_other | number |  | "});
}

TEST_CASE("a recorder of one file notes nothing of another") {
  const TomlTable own = table_of_text("[p.x]\nk = 1\n", "own"), other = table_of_text("[q]\ny = 1\n", "other");
  const KeyRecorder recorder("own");
  (void)other.table("q").number("y");
  (void)other.table("p").keys();  // chooses names in its own file alone
  (void)own.table("p").table("x").number("k");
  CHECK(noted_by(recorder) == Lines{"!p.x.k | number |  | "});
  (void)own.table("p").keys();
  (void)own.table("p").table("x").number("k");
  CHECK(noted_by(recorder) == Lines{"!p.x.k | number |  | ", "!p.NAME.k | number |  | "});
}

TEST_CASE("one recorder lives at a time, and the next one begins anew") {
  const TomlTable root = table_of_text("k = 1\n");
  {
    const KeyRecorder recorder;
    CHECK_THROWS_AS(KeyRecorder("second"), std::logic_error);
    (void)root.number("k");
    CHECK(recorder.keys().size() == 1);  // the refused one did not end it
  }
  (void)root.number("k");
  const KeyRecorder next;
  CHECK(next.keys().empty());
}

TEST_CASE("a reading that is refused is noted, too, and the next one as well") {
  const KeyRecorder recorder;
  const TomlTable root = table_of_text("k = \"text\"\n");
  CHECK_THROWS_AS(root.number_in("k", 1.0, 0.0, 2.0), FileError);
  (void)root.text("k");
  (void)root.number("l", 3.0);
  CHECK(noted_by(recorder) == Lines{"k | number | 0 to 2 | 1", "l | number |  | 3"});
}
