// Documents: how files and lines are bounded, what is set and removed, and which word is near.
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "devices/units.h"
#include "sequences/toml/key_table.h"
#include "sequences/toml/strict_toml.h"
#include "tests/sequences/refusal.h"
#include "tests/support/process.h"

using namespace tactbench::sequences;
using tactbench::tests::TemporaryFolder;

namespace fs = std::filesystem;

namespace {

FileError error_of(const std::string& path) {
  return refusal_by([&] { (void)TomlDocument::from_file(path); }).value_or(FileError("", "accepted", "", ""));
}

FileError error_of_text(const std::string& text) {
  return refusal_by([&] { (void)TomlDocument::from_text(text, "t"); }).value_or(FileError("", "accepted", "", ""));
}

std::string near(const std::string& word, const std::vector<std::string>& known) { return nearest_word(word, known); }

}  // namespace

TEST_CASE("nearest name: differs by at most two edits, or by a third of the letters") {
  // A change puts a letter in, takes one out or puts another in its place; capitals are the same letters.
  CHECK(near("abcdef", {"abcdxy"}) == "abcdxy");
  CHECK(near("abcdef", {"abcxyz"}).empty());
  CHECK(near("abc", {"abcde"}) == "abcde");
  CHECK(near("abc", {"abcdef"}).empty());
  CHECK(near("abcde", {"abc"}) == "abc");
  CHECK(near("abcdef", {"abc"}).empty());
  CHECK(near("abcdefghi", {"abcdefxyz"}) == "abcdefxyz");
  CHECK(near("abcdefghi", {"abcdewxyz"}).empty());
  CHECK(near("abcdefgh", {"abcdexyz"}).empty());  // 8 / 3 is 2
  CHECK(near("bacdef", {"abcdef"}) == "abcdef");  // two letters changed places: two changes
  CHECK(near("cabdef", {"abcdef"}) == "abcdef");  // one letter moved: out and in
  CHECK(near("kitten", {"sitting"}).empty());     // three, as every textbook says
  CHECK(near("sittings!", {"kitten"}).empty());   // five
  CHECK(near("SITTING99", {"sitting"}) == "sitting");
  CHECK(near("Dwell_S", {"dwell_s"}) == "dwell_s");
  CHECK(near("", {"ab"}) == "ab");
  CHECK(near("", {"abc"}).empty());
  CHECK(near("ab", {}).empty());
  // Of several the nearest, of equally near ones the first.
  CHECK(near("abcd", {"abxy", "abcx", "xbcd"}) == "abcx");
}

TEST_CASE("TOML file: lines of up to 16384 characters are accepted") {
  const std::string longest = "# " + std::string(16382, 'x');
  CHECK(error_of_text(longest).id().empty());
  CHECK(error_of_text(longest + "\na = 1\n" + longest + "\n").id().empty());
  const FileError error = error_of_text("a = 1\n\n" + longest + "x\nb = 2\n");
  CHECK(error.id() == "TB-FILE-SYNTAX");
  CHECK(error.where() == "t:3");
  CHECK_THAT(error.what(), Catch::Contains("16385"));
  CHECK(error_of_text(longest + "x").where() == "t:1");
}

TEST_CASE("TOML file: up to 16 million bytes are accepted") {
  const TemporaryFolder folder;
  const std::string line = "#" + std::string(9998, ' ') + "\n";
  {
    std::ofstream file(folder.path("large.toml"), std::ios::binary);
    for (int i = 0; i < 1600; ++i) file << line;
  }
  REQUIRE(fs::file_size(folder.path("large.toml")) == 16'000'000);
  CHECK(error_of(folder.path("large.toml")).id().empty());
  std::ofstream(folder.path("large.toml"), std::ios::binary | std::ios::app) << "#";
  const FileError error = error_of(folder.path("large.toml"));
  CHECK(error.id() == "TB-FILE-MISSING");
  CHECK_THAT(error.what(), Catch::Contains("16000000"));
}

TEST_CASE("TOML file: a missing file, a folder and an unreadable file are refused by name") {
  const TemporaryFolder folder;
  fs::create_symlink("round.toml", folder.path("round.toml"));
  for (const std::string& path :
       {folder.path("nothing.toml"), folder.path("round.toml"), std::string("/proc/self/mem")}) {
    const FileError error = error_of(path);
    CHECK(error.id() == "TB-FILE-MISSING");
    CHECK(error.where() == path);
  }
  CHECK(error_of(folder.path()).id() == "TB-FILE-MISSING");
  // A file of the kernel's says that it has no length; as root, this one would be waited for.
  CHECK(error_of("/proc/kmsg").where() == "/proc/kmsg");
}

TEST_CASE("TOML name: needs at least one visible character") {
  for (const char* nothing : {"", " ", "\\t \\n"}) {
    const TomlDocument document = TomlDocument::from_text("name = \"" + std::string(nothing) + "\"\n", "t");
    CHECK(document.root().text("name").size() < 5);
    check_refusal([&] { (void)document.root().name("name"); }, {nothing, "TB-FILE-VALUE", "t:1:8, name"});
  }
  CHECK(TomlDocument::from_text("name = \" a\"\n", "t").root().name("name") == " a");
}

TEST_CASE("TOML set: values go into tables, which are created if missing") {
  TomlDocument document = TomlDocument::from_text("a = 1\n[b]\nc = 2\n", "t");
  document.set({"a", "7"});
  document.set({"b.c", "8"});
  document.set({"b.d", "word"});
  document.set({"e.f.g", "[1, 2]"});
  const TomlTable root = document.root();
  CHECK(root.number("a") == 7.0);
  CHECK(root.table("b").number("c") == 8.0);
  CHECK(root.table("b").text("d") == "word");
  CHECK(root.table("e").table("f").numbers("g") == std::vector<double>{1, 2});
  CHECK(TomlDocument::from_text(document.to_text(), "again").root().table("b").number("c") == 8.0);
  CHECK(document.text() == "a = 1\n[b]\nc = 2\n");
  document.remove("b");
  document.remove("not there");
  CHECK(!document.root().has("b"));
  CHECK(!TomlDocument::from_text(document.to_text(), "again").root().has("b"));
}

TEST_CASE("TOML set: an impossible key is refused and quoted as typed") {
  TomlDocument document = TomlDocument::from_text("a = 1\n", "t");
  for (const auto& [key, place] : std::map<std::string, std::string>{
           {"a.b", "--set bench.a.b=1"}, {"", "--set bench.=1"}, {"c.", "--set bench.c.=1"}})
    check_refusal([&] { document.set({key, "1"}, "bench."); }, {key, "TB-FILE-VALUE", place});
}

TEST_CASE("file error: a NUL in a message is shown as an escape") {
  const FileError error("TB-FILE-KEY", std::string("a\0b\0c", 5), "w", "r");
  CHECK(std::string(error.what()) == "a\\x00b\\x00c");
  const FileError ends("TB-FILE-KEY", std::string("\0\0", 2), "w", "r");
  CHECK(std::string(ends.what()) == "\\x00\\x00");
}

TEST_CASE("TOML file: is read to its end for any length of its last block") {
  const TemporaryFolder folder;
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

TEST_CASE("TOML file: a file that cannot be read is refused") {
  const std::string path = "/sys/class/net/lo/speed";  // opens, but the kernel knows no speed of the loopback
  if (!std::filesystem::exists(path)) return;
  CHECK(error_of(path).id() == "TB-FILE-MISSING");
}

TEST_CASE("TOML set: a value typed in another unit is quoted as typed, with the place where it was set") {
  TomlDocument document = TomlDocument::from_text("[s]\nk = 1\nl = 1\n", "t");
  document.set({"s.k", "130.5", "9bar"}, "bench.");
  document.set({"s.l", "7", "7"}, "bench.");  // typed as it is: nothing to add
  document.set({"r", "8", "8.0"}, "bench.");
  const TomlTable table = document.root().table("s");
  check_refusal([&] { (void)table.number_in("k", 0.0, 0.0, 5.0); },
                {"k", "TB-FILE-VALUE", "--set bench.s.k (over t)", "130.5 (typed: 9bar)"});
  check_refusal([&] { (void)table.zero_or_in("l", 0.0, 3.0, 5.0); },
                {"l", "TB-FILE-VALUE", "--set bench.s.l (over t)", "7,"});
  check_refusal([&] { (void)document.root().number_in("r", 0.0, 0.0, 5.0); },
                {"r", "TB-FILE-VALUE", "--set bench.r (over t)", "8 (typed: 8.0)"});
}

// Numbers as they are read: kinds, bounds, lists, and what is remembered of them.

namespace {

template <class Read>
std::string id_refused(const std::string& text, Read read) {
  const auto error = refusal_by([&] { (void)read(TomlDocument::from_text(text, "t").root()); });
  return error ? error->id() : "";
}

const auto kRead = [](const TomlTable& table) { return table.number("k"); };

}  // namespace

TEST_CASE("TOML number: is an integer or a finite floating-point number") {
  const TomlTable root = TomlDocument::from_text("i = 3\nf = -2.5\nx = 0x10\n", "t").root();
  CHECK((root.number("i") == 3.0 && root.number("f") == -2.5 && root.number("x") == 16.0));
  check_refused_reading(kRead, {{"a = 1\n", "TB-FILE-KEY", "t:1:1, k"},
                                {"k = nan\n", "TB-FILE-VALUE", "t:1:5, k"},
                                {"k = inf\n", "TB-FILE-VALUE", "t:1:5, k"},
                                {"k = \"1\"\n", "TB-FILE-VALUE", "t:1:5, k"},
                                {"k = true\n", "TB-FILE-VALUE", "t:1:5, k"},
                                {"k = [1]\n", "TB-FILE-VALUE", "t:1:5, k"},
                                {"k = {a = 1}\n", "TB-FILE-VALUE", "t:1:5, k"},
                                {"k = 2026-01-31\n", "TB-FILE-VALUE", "t:1:5, k"}});
}

TEST_CASE("TOML number: a defined name is replaced by its number") {
  TomlDocument document = TomlDocument::from_text("k = \"$level\"\nl = [1, \"$level\"]\nm = [[\"$level\", 2]]\n", "t");
  CHECK(!document.uses("level"));
  document.define("level", 4.5);
  CHECK(document.root().number("k") == 4.5);
  CHECK(document.uses("level"));
  CHECK(document.root().numbers("l") == std::vector<double>{1, 4.5});
  CHECK(document.root().number_lists("m", 2) == std::vector<std::vector<double>>{{4.5, 2}});
  for (const auto& [word, near] : std::map<std::string, std::string>{{"$levle", "'$level'"}, {"$other", "other"}}) {
    TomlDocument unknown = TomlDocument::from_text("k = \"" + word + "\"\n", "t");
    unknown.define("level", 4.5);
    const auto error = refusal_by([&] { (void)unknown.root().number("k"); });
    REQUIRE(error);
    CHECK((error->id() == "TB-FILE-KEY" && error->where() == "t:1:5, k"));
    CHECK_THAT(error->remedy(), Catch::Contains(near));
  }
}

TEST_CASE("TOML number: bounds are accepted, and the next number beyond them is refused") {
  const auto in = [](const std::string& value, double fallback = 0.0) {
    return id_refused("k = " + value + "\n",
                      [&](const TomlTable& table) { return table.number_in("k", fallback, -1.0, 2.0); });
  };
  CHECK((in("-1").empty() && in("2").empty() && in("0.5").empty()));
  CHECK((in("-1.0000000000000002") == "TB-FILE-VALUE" && in("2.0000000000000004") == "TB-FILE-VALUE"));
  const auto zero_or = [](const std::string& value) {
    return id_refused("k = " + value + "\n",
                      [](const TomlTable& table) { return table.zero_or_in("k", 5.0, 3.0, 6.0); });
  };
  CHECK((zero_or("0").empty() && zero_or("3").empty() && zero_or("6").empty()));
  CHECK(zero_or("1e-300") == "TB-FILE-VALUE");
  CHECK(zero_or("2.9999999999999996") == "TB-FILE-VALUE");
  CHECK(zero_or("6.000000000000001") == "TB-FILE-VALUE");
  const auto whole = [](const std::string& value) {
    return id_refused("k = " + value + "\n", [](const TomlTable& table) { return table.integer("k", 2, 4); });
  };
  CHECK((whole("2").empty() && whole("4").empty() && whole("3.0").empty()));
  CHECK((whole("1") == "TB-FILE-VALUE" && whole("5") == "TB-FILE-VALUE" && whole("2.5") == "TB-FILE-VALUE"));
  // A fallback is not asked for its bounds where it has a meaning of its own.
  const TomlTable empty = TomlDocument::from_text("", "t").root();
  CHECK(empty.number_in("k", 0.5, -1.0, 2.0) == 0.5);
  CHECK(empty.zero_or_in("k", 0.0, 3.0, 6.0) == 0.0);
  CHECK(empty.integer("k", -1, 2, 4) == -1);
  CHECK(TomlDocument::from_text("k = 3\n", "t").root().integer("k", -1, 2, 4) == 3);
}

TEST_CASE("TOML list: accepts numbers only") {
  const auto list = [](const TomlTable& table) { return table.numbers("k"); };
  CHECK(TomlDocument::from_text("k = []\n", "t").root().numbers("k").empty());
  CHECK(TomlDocument::from_text("k = [3, 1.5]\n", "t").root().numbers("k") == std::vector<double>{3, 1.5});
  check_refused_reading(list, {{"k = [1, 2, \"3\"]\n", "TB-FILE-VALUE", "t:1:5, k", "element 3 "},
                               {"k = [inf]\n", "TB-FILE-VALUE", "t:1:5, k", "element 1 "},
                               {"k = 1\n", "TB-FILE-VALUE", "t:1:5, k"},
                               {"a = 1\n", "TB-FILE-VALUE", "t:1:1, k"}});
  const auto several = [](const TomlTable& table) { return table.numbers_or_one("k", 7.0); };
  CHECK(several(TomlDocument::from_text("k = 2\n", "t").root()) == std::vector<double>{2});
  CHECK(several(TomlDocument::from_text("k = [2, 3]\n", "t").root()) == std::vector<double>{2, 3});
  CHECK(several(TomlDocument::from_text("", "t").root()) == std::vector<double>{7});
  check_refused_reading(several, {{"k = []\n", "TB-FILE-VALUE", "t:1:5, k"}});
}

TEST_CASE("TOML span: the end must be above the beginning") {
  const auto span = [](const TomlTable& table) { return table.span("k", {-3.0, 4.5}); };
  CHECK(span(TomlDocument::from_text("k = [1, 2]\n", "t").root()) == std::pair(1.0, 2.0));
  CHECK(span(TomlDocument::from_text("", "t").root()) == std::pair(-3.0, 4.5));
  for (const char* wrong : {"[2, 2]", "[2, 1]", "[1]", "[1, 2, 3]", "[]"}) {
    check_refused_reading(span, {{"k = " + std::string(wrong) + "\n", "TB-FILE-VALUE", "t:1:5, k"}});
  }
}

TEST_CASE("TOML list of lists: each list must have the required length") {
  const auto pairs = [](const TomlTable& table) { return table.number_lists("k", 2); };
  CHECK(pairs(TomlDocument::from_text("k = [[1, 2], [3, 4.5]]\n", "t").root()) ==
        std::vector<std::vector<double>>{{1, 2}, {3, 4.5}});
  check_refused_reading(pairs, {{"k = [[1, 2], [3]]\n", "TB-FILE-VALUE", "t:1:5, k", "element 2 "},
                                {"k = [[1, 2, 3]]\n", "TB-FILE-VALUE", "t:1:5, k", "element 1 "},
                                {"k = [[1, \"2\", 3]]\n", "TB-FILE-VALUE", "t:1:5, k", "element 1 "},
                                {"k = [[1, nan]]\n", "TB-FILE-VALUE", "t:1:5, k", "element 1 "},
                                {"k = [1, 2]\n", "TB-FILE-VALUE", "t:1:5, k", "element 1 "},
                                {"k = []\n", "TB-FILE-VALUE", "t:1:5, k"},
                                {"k = 1\n", "TB-FILE-VALUE", "t:1:5, k"},
                                {"", "TB-FILE-VALUE", "t:1:1, k"}});
}

TEST_CASE("TOML settings: each number read is recorded once, with its place or as a default") {
  const TomlDocument document =
      TomlDocument::from_text("a = 1.5\nb = 2\nc = [1, 2]\nd = [0, 4]\ne = [[1, 2], [3, 4]]\nf = [7]\n", "t");
  const TomlTable root = document.root();
  (void)root.number("a");
  (void)root.number("a", 9.0);
  (void)root.number("missing", 0.25);
  (void)root.integer("b", 0, 9);
  (void)root.integer("none", 4, 0, 9);
  (void)root.numbers("c");
  (void)root.span("d", {1.0, 2.0});
  (void)root.span("wide", {1.0, 2.5});
  (void)root.number_lists("e", 2);
  (void)root.numbers_or_one("f", 1.0);
  CHECK(noted(document) ==
        "a=1.5 t:1\nmissing=0.25 default\nb=2 t:2\nnone=4 default\nc=[1, 2] t:3\nd=[0, 4] t:4\nwide=[1, 2.5] default\n"
        "e=2 lists of 2 t:5\nf=[7] t:6\n");
}

// Texts, words, dates and tables as they are read, and which keys a table may have.

namespace {

template <class Read>
FileError refused_reading(const std::string& text, Read read) {
  return refusal_by([&] { (void)read(TomlDocument::from_text(text, "t").root()); })
      .value_or(FileError("", "accepted", "", ""));
}

TomlTable root_of(const std::string& text) { return TomlDocument::from_text(text, "t").root(); }

}  // namespace

TEST_CASE("TOML boolean: numbers and texts are refused") {
  const auto read = [](const TomlTable& table) { return table.boolean("k", true); };
  CHECK((read(root_of("k = true\n")) && !read(root_of("k = false\n")) && read(root_of(""))));
  CHECK(!root_of("").boolean("k", false));
  check_refused_reading(read,
                        {{"k = 1\n", "TB-FILE-VALUE", "t:1:5, k"}, {"k = \"true\"\n", "TB-FILE-VALUE", "t:1:5, k"}});
}

TEST_CASE("TOML text: a value without quotes is refused") {
  const auto read = [](const TomlTable& table) { return table.text("k"); };
  CHECK(read(root_of("k = \"a b\"\n")) == "a b");
  check_refused_reading(read, {{"k = 1\n", "TB-FILE-VALUE", "t:1:5, k"},
                               {"k = 1.5\n", "TB-FILE-VALUE", "t:1:5, k"},
                               {"a = 1\n", "TB-FILE-KEY", "t:1:1, k"}});
  CHECK(root_of("").text("k", "other") == "other");
  CHECK(root_of("k = \"own\"\n").text("k", "other") == "own");
  CHECK(root_of("").texts("k").empty());
  CHECK(root_of("k = [\"a\", \"b\"]\n").texts("k") == std::vector<std::string>{"a", "b"});
  const auto list = [](const TomlTable& table) { return table.texts("k"); };
  check_refused_reading(list, {{"k = \"a\"\n", "TB-FILE-VALUE", "t:1:5, k"},
                               {"k = [\"a\", 2]\n", "TB-FILE-VALUE", "t:1:5, k", "element 2 "}});
}

TEST_CASE("TOML date: is read as written, as a TOML date or in quotes") {
  const auto read = [](const TomlTable& table) { return table.date_text("k"); };
  CHECK(read(root_of("k = 2026-01-09\n")) == "2026-01-09");
  CHECK(read(root_of("k = 0987-12-31\n")) == "0987-12-31");
  CHECK(read(root_of("k = \"spring\"\n")) == "spring");
  CHECK(read(root_of("")).empty());
  check_refused_reading(read, {{"k = 2026\n", "TB-FILE-VALUE", "t:1:5, k"}});
}

TEST_CASE("TOML choice: must be one of the known values, and an error suggests the nearest") {
  const auto read = [](const TomlTable& table) { return table.word("k", {"forward", "backward"}); };
  CHECK(read(root_of("k = \"backward\"\n")) == "backward");
  CHECK(root_of("").word("k", "forward", {"forward", "backward"}) == "forward");
  CHECK(root_of("k = \"backward\"\n").word("k", "forward", {"forward", "backward"}) == "backward");
  check_refused_reading(read, {{"k = \"foward\"\n", "TB-FILE-VALUE", "t:1:5, k", "forward, backward"}});
  CHECK_THAT(refused_reading("k = \"foward\"\n", read).remedy(), Catch::Contains("\"forward\""));
  CHECK_THAT(refused_reading("k = \"up\"\n", read).remedy(), !Catch::Contains("ward"));
  check_refused_reading(read, {{"", "TB-FILE-KEY", "t:1:1, k"}});
}

TEST_CASE("TOML table: errors name a key with all enclosing tables") {
  const auto deep = [](const TomlTable& table) { return table.table("a").table("b").number("c"); };
  CHECK(deep(root_of("[a.b]\nc = 4\n")) == 4.0);
  check_refused_reading(deep, {{"[a.b]\nc = \"4\"\n", "TB-FILE-VALUE", "t:2:5, a.b.c"},
                               {"a = 1\n", "TB-FILE-VALUE", "t:1:5, a"},
                               {"", "TB-FILE-KEY", "t, a.b.c"}});
  const auto listed = [](const TomlTable& table) {
    double sum = 0.0;
    for (const TomlTable& one : table.table("a").tables("l")) sum += one.number("c");
    return sum;
  };
  CHECK(listed(root_of("[[a.l]]\nc = 1\n[[a.l]]\nc = 2\n")) == 3.0);
  CHECK(listed(root_of("")) == 0.0);
  check_refused_reading(listed, {{"[[a.l]]\nc = 1\n[[a.l]]\nc = \"2\"\n", "TB-FILE-VALUE", "t:4:5, a.l[1].c"},
                                 {"[a]\nl = [1]\n", "TB-FILE-VALUE", "t:2:5, a.l"},
                                 {"[a]\nl = 1\n", "TB-FILE-VALUE", "t:2:5, a.l"}});
  const auto top = [](const TomlTable& table) { return table.tables("l").front().number("c"); };
  check_refused_reading(top, {{"[[l]]\nc = true\n", "TB-FILE-VALUE", "t:2:5, l[0].c"}});
}

TEST_CASE("TOML table: an unknown key is refused, and the nearest known one is suggested") {
  const auto read = [](const TomlTable& table) {
    (void)table.has("dwell_s");
    (void)table.keys();  // to list keys is not to ask for them
    table.finish();
    return 0;
  };
  CHECK(refused_reading("dwell_s = 1\n", read).id().empty());
  CHECK(refused_reading("", read).id().empty());
  const FileError close = refused_reading("dwel_s = 1\n", read);
  CHECK(close.where() == "t:1:10, dwel_s");
  CHECK_THAT(close.remedy(), Catch::Contains("'dwell_s'"));
  const FileError far = refused_reading("dwell_s = 1\nsomething = 1\n", read);
  CHECK((far.id() == "TB-FILE-KEY" && far.where() == "t:2:13, something"));
  CHECK_THAT(far.remedy(), Catch::Contains("dwell_s"));
  CHECK(root_of("b = 1\na = 2\n").keys() == std::vector<std::string>{"a", "b"});
  CHECK(root_of("").table("none").keys().empty());
  root_of("").table("none").finish();
}

TEST_CASE("TOML settings: texts are recorded in quotes, with their place or as a default") {
  const TomlDocument document = TomlDocument::from_text(
      "a = \"x\"\nb = true\nc = 2026-01-09\nd = [\"p\", \"q\"]\n[e]\nf = \"y\"\n[[g]]\nh = \"z\"\n", "t");
  const TomlTable root = document.root();
  (void)root.text("a");
  (void)root.text("a", "again");
  (void)root.text("none", "");
  (void)root.boolean("b", false);
  (void)root.boolean("off", false);
  (void)root.date_text("c");
  (void)root.date_text("never");
  (void)root.texts("d");
  (void)root.texts("nobody");
  (void)root.table("e").word("f", {"y"});
  (void)root.tables("g").front().text("h");
  CHECK(noted(document) ==
        "a=\"x\" t:1\nnone=\"\" default\nb=true t:2\noff=false default\nc=\"2026-01-09\" t:3\nnever=\"\" default\n"
        "d=[p, q] t:4\nnobody=[] default\ne.f=\"y\" t:6\ng[0].h=\"z\" t:8\n");
}

TEST_CASE("TOML settings: values set on the command line have no line of the file") {
  TomlDocument document = TomlDocument::from_text("a = 1\n", "t");
  document.set({"a", "two"}, "bench.");
  CHECK(document.root().text("a") == "two");
  CHECK(noted(document) == "a=\"two\" --set\n");
  check_refusal([&] { (void)document.root().number("a"); }, {"a", "TB-FILE-VALUE", "--set bench.a (over t)"});
}

// Rows of keys: what each reads into its variable, in which unit, and what it says of itself.

namespace key = tactbench::sequences::key;
using tactbench::devices::Psi;

namespace {

enum class Colour { kRed, kGreen };

struct Values {
  double share = 0.5, timeout_s = 0.4;
  std::chrono::nanoseconds wait = std::chrono::milliseconds(300);
  Psi low{0.0}, high{100.0};
  int count = 3;
  bool on = true, ends = true;
  char parity = 'E';
  Colour colour = Colour::kGreen;
  std::string text = "own", need;
  double maybe = 7.0;
};

KeyTable rows_of(Values& values) {
  return {key::number("share", values.share, kPercent, {0.0, 100.0}, "share"),
          key::number("timeout_ms", values.timeout_s, kMilliseconds, {}, "time"),
          key::number("wait_ms", values.wait, kMilliseconds, {1.0, 1000.0, true}, "time"),
          key::span("span_bar", values.low, values.high, {"bar", 10.0}, "span"),
          key::number("count", values.count, kOne, {1, 9}, "count"),
          key::flag("on", values.on, "flag"),
          key::word("blind", values.ends, {"end", "warn"}, "end", "word"),
          key::word("parity", values.parity, {"N", "E"}, "letter"),
          key::word("colour", values.colour, {"red", "green"}, "word"),
          key::text("text", values.text, "text"),
          key::required(key::text("need", values.need, "text")),
          key::optional(key::number("maybe", values.maybe, {"psi"}, {}, "number"))};
}

std::string id_of(const std::string& text) {
  Values values;
  try {
    read_whole(TomlDocument::from_text(text, "t").root(), rows_of(values));
  } catch (const FileError& error) {
    return error.id();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("key table: values are converted from the file's unit, absent keys keep the variable's value") {
  Values values;
  read_whole(TomlDocument::from_text("need = \"x\"", "t").root(), rows_of(values));
  const Values own;
  CHECK((values.share == own.share && values.timeout_s == own.timeout_s && values.wait == own.wait));
  CHECK((values.low == own.low && values.high == own.high && values.count == own.count && values.maybe == own.maybe));
  CHECK((values.on && values.ends && values.parity == 'E' && values.colour == Colour::kGreen && values.text == "own"));
  read_whole(TomlDocument::from_text(
                 "need = \"x\"\nshare = 25\ntimeout_ms = 150\nwait_ms = 2.5\nspan_bar = [1, 2]\ncount = 9\n"
                 "on = false\nblind = \"warn\"\nparity = \"N\"\ncolour = \"red\"\ntext = \"\"\nmaybe = -1\n",
                 "t")
                 .root(),
             rows_of(values));
  CHECK((values.share == 0.25 && values.timeout_s == 0.15 && values.wait == std::chrono::microseconds(2500)));
  CHECK((values.low == Psi(10.0) && values.high == Psi(20.0) && values.count == 9 && values.maybe == -1.0));
  CHECK((!values.on && !values.ends && values.parity == 'N' && values.colour == Colour::kRed && values.text.empty()));
}

TEST_CASE("key table: values outside their limits and unknown keys are refused") {
  const std::string need = "need = \"x\"\n";
  CHECK(id_of(need) == "accepted");
  for (const char* line : {"share = 101", "wait_ms = 0.5", "span_bar = [2, 1]", "count = 10", "count = 1.5", "on = 1",
                           "blind = \"other\"", "colour = \"blue\"", "text = 1", "maybe = \"1\""}) {
    INFO(line);
    CHECK(id_of(need + line) == "TB-FILE-VALUE");
  }
  CHECK(id_of("share = 1") == "TB-FILE-KEY");  // without need
  CHECK(id_of(need + "shar = 1") == "TB-FILE-KEY");
}

TEST_CASE("key table: describes its keys, and adds the limits of another kind of table") {
  Values values;
  std::vector<KeyFacts> all;
  add_facts(all, "part", rows_of(values));
  REQUIRE(all.size() == 12);
  CHECK((all[0].key == "part.share" && all[0].unit == "%" && all[0].range == "0 to 100" && all[0].standard == "`50`"));
  CHECK((all[10].standard == "required" && all[11].standard.empty()));
  add_facts(all, "part", {key::number("count", values.count, kOne, {0, 20}, "count")});
  CHECK((all.size() == 12 && all[4].range == "1 to 9; or 0 to 20" && all[4].meaning == "count"));
}
