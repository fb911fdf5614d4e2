// Documents: how files and lines are bounded, what is set and removed, and which word is near.
#include "sequences/toml/strict_toml.h"
#include "tests/sequences/refusal.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <map>

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

TEST_CASE("words are near when they differ by at most two changes, or by a third of the letters") {
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

TEST_CASE("16384 characters of a line are allowed") {
  const std::string longest = "# " + std::string(16382, 'x');
  CHECK(error_of_text(longest).id().empty());
  CHECK(error_of_text(longest + "\na = 1\n" + longest + "\n").id().empty());
  const FileError error = error_of_text("a = 1\n\n" + longest + "x\nb = 2\n");
  CHECK(error.id() == "TB-FILE-SYNTAX");
  CHECK(error.where() == "t:3");
  CHECK_THAT(error.what(), Catch::Contains("16385"));
  CHECK(error_of_text(longest + "x").where() == "t:1");
}

TEST_CASE("a file may have 16 million bytes") {
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

TEST_CASE("a missing file, a folder and an unreadable file are refused by name") {
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

TEST_CASE("a name has at least one visible character") {
  for (const char* nothing : {"", " ", "\\t \\n"}) {
    const TomlDocument document = TomlDocument::from_text("name = \"" + std::string(nothing) + "\"\n", "t");
    CHECK(document.root().text("name").size() < 5);
    check_refusal([&] { (void)document.root().name("name"); }, {nothing, "TB-FILE-VALUE", "t:1:8, name"});
  }
  CHECK(TomlDocument::from_text("name = \" a\"\n", "t").root().name("name") == " a");
}

TEST_CASE("values of --set go into tables, which are created where missing") {
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

TEST_CASE("an impossible --set is refused and quoted as typed") {
  TomlDocument document = TomlDocument::from_text("a = 1\n", "t");
  for (const auto& [key, place] : std::map<std::string, std::string>{
           {"a.b", "--set bench.a.b=1"}, {"", "--set bench.=1"}, {"c.", "--set bench.c.=1"}})
    check_refusal([&] { document.set({key, "1"}, "bench."); }, {key, "TB-FILE-VALUE", place});
}

TEST_CASE("a NUL in a message is shown") {
  const FileError error("TB-FILE-KEY", std::string("a\0b\0c", 5), "w", "r");
  CHECK(std::string(error.what()) == "a\\x00b\\x00c");
  const FileError ends("TB-FILE-KEY", std::string("\0\0", 2), "w", "r");
  CHECK(std::string(ends.what()) == "\\x00\\x00");
}

TEST_CASE("a file whose last block has a byte, or lacks one, is read to its end") {
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

TEST_CASE("a file whose bytes cannot be had is refused") {
  const std::string path = "/sys/class/net/lo/speed";  // opens, but the kernel knows no speed of the loopback
  if (!std::filesystem::exists(path)) return;
  CHECK(error_of(path).id() == "TB-FILE-MISSING");
}

TEST_CASE("a value that was typed in another unit is quoted as typed, at the place of its --set") {
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
