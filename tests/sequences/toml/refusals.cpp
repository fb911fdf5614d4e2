// Each refusal of a reading in full: id, message, place and remedy.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <functional>

#include "sequences/toml/strict_toml.h"
#include "tests/sequences/refusal_words.h"
#include "tests/support/process.h"

using namespace tactbench::sequences;

namespace {

std::string words_of_reading(const std::string& text, const std::function<void(const TomlTable&)>& read) {
  return words_of([&] { read(TomlDocument::from_text(text, "t").root()); });
}

}  // namespace

TEST_CASE("what is said of a number that cannot be read") {
  const auto number = [](const TomlTable& table) { (void)table.number("k"); };
  CHECK(words_of_reading("", number) == "TB-FILE-KEY | 'k' is missing | t:1:1, k | add k = <number>");
  CHECK(words_of_reading("k = \"1\"\n", number) ==
        "TB-FILE-VALUE | 'k' must be a number, it is text | t:1:5, k | "
        "write the number alone; its unit is in the key");
  CHECK(words_of_reading("k = inf\n", number) ==
        "TB-FILE-VALUE | 'k' must be finite | t:1:5, k | write a finite number");
  const auto bounded = [](const TomlTable& table) { (void)table.number_in("k", 0.0, -1.5, 2.0); };
  CHECK(words_of_reading("k = 3\n", bounded) ==
        "TB-FILE-VALUE | 'k' is 3, outside -1.5 to 2 | t:1:5, k | use -1.5 to 2");
  const auto zero_or = [](const TomlTable& table) { (void)table.zero_or_in("k", 0.0, 3.0, 6.5); };
  CHECK(words_of_reading("k = 2\n", zero_or) ==
        "TB-FILE-VALUE | 'k' is 2, neither 0 nor 3 to 6.5 | t:1:5, k | use 0 for none, or 3 to 6.5");
  for (const auto& whole : std::vector<std::function<void(const TomlTable&)>>{
           [](const TomlTable& table) { (void)table.integer("k", 2, 4); },
           [](const TomlTable& table) { (void)table.integer("k", 3, 2, 4); }}) {
    CHECK(words_of_reading("k = 5\n", whole) ==
          "TB-FILE-VALUE | 'k' is 5, not a whole number from 2 to 4 | t:1:5, k | use a whole number from 2 to 4");
  }
}

TEST_CASE("what is said of a name that no parameter has") {
  const auto said = [](const std::string& word) {
    TomlDocument document = TomlDocument::from_text("k = \"" + word + "\"\n", "t");
    document.define("level", 4.5);
    return words_of([&] { (void)document.root().number("k"); });
  };
  CHECK(said("$levle") == "TB-FILE-KEY | there is no parameter 'levle' | t:1:5, k | did you mean '$level'?");
  CHECK(said("$height") == "TB-FILE-KEY | there is no parameter 'height' | t:1:5, k | declare it: [parameters.height]");
  // Without the sign it is a text.
  CHECK(said("level") ==
        "TB-FILE-VALUE | 'k' must be a number, it is text | t:1:5, k | write the number alone; its unit is in the key");
}

TEST_CASE("what is said of a list of numbers that cannot be read") {
  const auto list = [](const TomlTable& table) { (void)table.numbers("k"); };
  CHECK(words_of_reading("k = 1\n", list) ==
        "TB-FILE-VALUE | 'k' must be a list of numbers | t:1:5, k | write k = [0, 60, 0]");
  CHECK(words_of_reading("k = [1, nan, 3]\n", list) ==
        "TB-FILE-VALUE | element 2 of 'k' is not a finite number | t:1:5, k | use numbers only");
  const auto span = [](const TomlTable& table) { (void)table.span("k", {0.0, 1.0}); };
  CHECK(words_of_reading("k = [2, 1]\n", span) ==
        "TB-FILE-VALUE | 'k' must be [low, high] with low < high | t:1:5, k | write k = [0, 10]");
  const auto several = [](const TomlTable& table) { (void)table.numbers_or_one("k", 1.0); };
  CHECK(words_of_reading("k = []\n", several) ==
        "TB-FILE-VALUE | 'k' is an empty list | t:1:5, k | write a number or several");
  const auto triples = [](const TomlTable& table) { (void)table.number_lists("k", 3); };
  CHECK(words_of_reading("k = [[1, 2, 3], [4, 5]]\n", triples) ==
        "TB-FILE-VALUE | element 2 of 'k' is not a list of 3 numbers | t:1:5, k | write lists in a list");
  CHECK(words_of_reading("k = []\n", triples) ==
        "TB-FILE-VALUE | 'k' must be a list of lists of 3 numbers | t:1:5, k | write lists in a list");
}

TEST_CASE("what is said of a text that cannot be read") {
  const auto flag = [](const TomlTable& table) { (void)table.boolean("k", true); };
  CHECK(words_of_reading("k = 0\n", flag) ==
        "TB-FILE-VALUE | 'k' must be true or false | t:1:5, k | write true or false");
  const auto text = [](const TomlTable& table) { (void)table.text("k"); };
  CHECK(words_of_reading("a = 1\n", text) == "TB-FILE-KEY | 'k' is missing | t:1:1, k | add k = \"...\"");
  CHECK(words_of_reading("k = [1]\n", text) ==
        "TB-FILE-VALUE | 'k' must be text, it is a list | t:1:5, k | put it in double quotes");
  const auto name = [](const TomlTable& table) { (void)table.name("k"); };
  CHECK(words_of_reading("k = \" \"\n", name) == "TB-FILE-VALUE | 'k' is empty | t:1:5, k | give a short name");
  const auto texts = [](const TomlTable& table) { (void)table.texts("k"); };
  CHECK(words_of_reading("k = true\n", texts) ==
        "TB-FILE-VALUE | 'k' must be a list of texts, it is true or false | t:1:5, k | write [\"...\", \"...\"]");
  CHECK(words_of_reading("k = [\"a\", 2, 3]\n", texts) ==
        "TB-FILE-VALUE | element 2 of 'k' is a whole number, not a text | t:1:5, k | put it in double quotes");
  const auto word = [](const TomlTable& table) { (void)table.word("k", "up", {"up", "left"}); };
  CHECK(words_of_reading("k = \"letf\"\n", word) ==
        "TB-FILE-VALUE | 'k' is \"letf\", which is not one of up, left | t:1:5, k | did you mean \"left\"?");
  CHECK(words_of_reading("k = \"sideward\"\n", word) ==
        "TB-FILE-VALUE | 'k' is \"sideward\", which is not one of up, left | t:1:5, k | use one of the words");
}

TEST_CASE("what is said of a table that cannot be read") {
  const auto table = [](const TomlTable& root) { (void)root.table("k"); };
  CHECK(words_of_reading("k = 1\n", table) ==
        "TB-FILE-VALUE | 'k' must be a table | t:1:5, k | write [k] on a line of its own");
  const auto tables = [](const TomlTable& root) { (void)root.tables("k"); };
  for (const char* text : {"k = 1\n", "k = [1]\n"}) {
    CHECK(words_of_reading(text, tables) ==
          "TB-FILE-VALUE | 'k' must be a list of tables | t:1:5, k | write [[k]] before each");
  }
  const auto finish = [](const TomlTable& root) {
    (void)root.has("alpha");
    (void)root.has("beta");
    root.finish();
  };
  CHECK(words_of_reading("bata = 1\n", finish) ==
        "TB-FILE-KEY | unknown key 'bata' | t:1:8, bata | did you mean 'beta'?");
  CHECK(words_of_reading("something = 1\n", finish) ==
        "TB-FILE-KEY | unknown key 'something' | t:1:13, something | known keys here: alpha, beta");
}

TEST_CASE("every kind of value is called by its name where a text is wanted") {
  const auto text = [](const TomlTable& table) { (void)table.text("k"); };
  for (const auto& [value, kind] : std::vector<std::pair<std::string, std::string>>{{"{a = 1}", "a table"},
                                                                                    {"[1]", "a list"},
                                                                                    {"1", "a whole number"},
                                                                                    {"1.5", "a number"},
                                                                                    {"true", "true or false"},
                                                                                    {"2026-01-31", "a date or time"},
                                                                                    {"07:32:00", "a date or time"}}) {
    CHECK(words_of_reading("k = " + value + "\n", text) ==
          "TB-FILE-VALUE | 'k' must be text, it is " + kind + " | t:1:5, k | put it in double quotes");
  }
  CHECK(words_of_reading("k = [\"a\", 07:32:00]\n", [](const TomlTable& table) { (void)table.texts("k"); }) ==
        "TB-FILE-VALUE | element 2 of 'k' is a date or time, not a text | t:1:5, k | put it in double quotes");
}

TEST_CASE("what is said of a file that cannot be used") {
  const tactbench::tests::TemporaryFolder folder;
  const auto said = [](const std::string& path) { return words_of([&] { (void)TomlDocument::from_file(path); }); };
  const std::string gone = folder.path("gone.toml"), hollow = folder.path("hollow.toml");
  CHECK(said(gone) == fmt::format("TB-FILE-MISSING | cannot read the file '{0}' | {0} | check the name; 'tactbench "
                                  "init' writes files to start from",
                                  gone));
  CHECK(said(folder.path()) == fmt::format("TB-FILE-MISSING | '{0}' is not a regular file | {0} | name a file: "
                                           "devices, folders and pipes are not read",
                                           folder.path()));
  std::ofstream(hollow).close();
  CHECK(said(hollow) ==
        fmt::format("TB-FILE-MISSING | '{0}' is empty | {0} | check that it is the right file", hollow));
  CHECK(words_of([] { (void)TomlDocument::from_text("a = 1\n" + std::string(16385, '#'), "t"); }) ==
        "TB-FILE-SYNTAX | a line of 16385 characters | t:2 | break it: a line may have 16384 characters");
  const std::string syntax = words_of([] { (void)TomlDocument::from_text("a = 1\nb = 2 s\n", "t"); });
  CHECK_THAT(syntax, Catch::StartsWith("TB-FILE-SYNTAX | not valid TOML: ") &&
                         Catch::Contains(" | t:2:7 | a quantity is a plain number with its unit in the key"));
}

TEST_CASE("what is said of a file whose bytes cannot be had") {
  const std::string path = "/sys/class/net/lo/speed";  // opens, but the kernel knows no speed of the loopback
  if (!std::filesystem::exists(path)) return;
  CHECK(words_of([&] { (void)TomlDocument::from_file(path); }) ==
        fmt::format("TB-FILE-MISSING | reading the file '{0}' failed | {0} | check the disk and the file", path));
}

TEST_CASE("a file whose last block has a byte, or lacks one, is read to its end") {
  const tactbench::tests::TemporaryFolder folder;
  const std::size_t block = 65536;
  for (const std::size_t size : {std::size_t{1}, block - 1, block, block + 1, 2 * block + 1}) {
    std::string text;
    while (text.size() + 100 < size) text += "#" + std::string(98, ' ') + "\n";
    text += std::string(size - text.size() - 1, ' ') + "\n";
    REQUIRE(text.size() == size);
    std::ofstream(folder.path("f.toml"), std::ios::binary) << text;
    INFO(size);
    CHECK(TomlDocument::from_file(folder.path("f.toml")).text() == text);
  }
}

TEST_CASE("what is said of a value that was typed in another unit") {
  TomlDocument document = TomlDocument::from_text("[s]\nk = 1\nl = 1\n", "t");
  document.set({"s.k", "130.5", "9bar"}, "bench.");
  document.set({"s.l", "7", "7"}, "bench.");  // typed as it is: nothing to add
  document.set({"r", "8", "8.0"}, "bench.");
  const TomlTable table = document.root().table("s");
  CHECK(words_of([&] { (void)table.number_in("k", 0.0, 0.0, 5.0); }) ==
        "TB-FILE-VALUE | 'k' is 130.5 (typed: 9bar), outside 0 to 5 | --set bench.s.k (over t) | use 0 to 5");
  CHECK(words_of([&] { (void)table.zero_or_in("l", 0.0, 3.0, 5.0); }) ==
        "TB-FILE-VALUE | 'l' is 7, neither 0 nor 3 to 5 | --set bench.s.l (over t) | use 0 for none, or 3 to 5");
  CHECK(words_of([&] { (void)document.root().number_in("r", 0.0, 0.0, 5.0); }) ==
        "TB-FILE-VALUE | 'r' is 8 (typed: 8.0), outside 0 to 5 | --set bench.r (over t) | use 0 to 5");
}

TEST_CASE("what is said of a --set that cannot be applied") {
  TomlDocument document = TomlDocument::from_text("a = 1\n", "t");
  CHECK(words_of([&] {
          document.set({"a.b.c", "1"}, "bench.");
        }) == "TB-FILE-VALUE | 'a' is not a table | --set bench.a.b.c=1 | write the key as in the file, table.key");
  CHECK(words_of([&] {
          document.set({"", "x y"});
        }) == "TB-FILE-VALUE | an empty key | --set =x y | write --set table.key=value");
}
