// Texts, words, dates and tables as they are read, and which keys a table may have.
#include <catch2/catch.hpp>

#include "sequences/toml/strict_toml.h"

using namespace tactbench::sequences;

namespace {

template <class Read>
FileError refused_reading(const std::string& text, Read read) {
  try {
    (void)read(TomlDocument::from_text(text, "t").root());
  } catch (const FileError& error) {
    return error;
  }
  return {"", "accepted", "", ""};
}

void check_place(const FileError& error, const std::string& id, const std::string& where, const std::string& fact) {
  CHECK(error.id() == id);
  CHECK(error.where() == where);
  CHECK_THAT(error.what(), Catch::Contains(fact));
}

TomlTable root_of(const std::string& text) { return TomlDocument::from_text(text, "t").root(); }

std::string remembered(const TomlDocument& document) {
  std::string all;
  for (const Setting& setting : document.settings())
    all += setting.key + "=" + setting.value + " " + setting.origin + "\n";
  return all;
}

}  // namespace

TEST_CASE("true and false are neither numbers nor texts") {
  const auto read = [](const TomlTable& table) { return table.boolean("k", true); };
  CHECK((read(root_of("k = true\n")) && !read(root_of("k = false\n")) && read(root_of(""))));
  CHECK(!root_of("").boolean("k", false));
  check_place(refused_reading("k = 1\n", read), "TB-FILE-VALUE", "t:1:5, k", "'k'");
  check_place(refused_reading("k = \"true\"\n", read), "TB-FILE-VALUE", "t:1:5, k", "'k'");
}

TEST_CASE("a text without quotes is refused") {
  const auto read = [](const TomlTable& table) { return table.text("k"); };
  CHECK(read(root_of("k = \"a b\"\n")) == "a b");
  check_place(refused_reading("k = 1\n", read), "TB-FILE-VALUE", "t:1:5, k", "a whole number");
  check_place(refused_reading("k = 1.5\n", read), "TB-FILE-VALUE", "t:1:5, k", "it is a number");
  check_place(refused_reading("a = 1\n", read), "TB-FILE-KEY", "t:1:1, k", "missing");
  CHECK(root_of("").text("k", "other") == "other");
  CHECK(root_of("k = \"own\"\n").text("k", "other") == "own");
  CHECK(root_of("").texts("k").empty());
  CHECK(root_of("k = [\"a\", \"b\"]\n").texts("k") == std::vector<std::string>{"a", "b"});
  const auto list = [](const TomlTable& table) { return table.texts("k"); };
  check_place(refused_reading("k = \"a\"\n", list), "TB-FILE-VALUE", "t:1:5, k", "text");
  check_place(refused_reading("k = [\"a\", 2]\n", list), "TB-FILE-VALUE", "t:1:5, k", "element 2 ");
}

TEST_CASE("a date is read as it is written, by TOML or in quotes") {
  const auto read = [](const TomlTable& table) { return table.date_text("k"); };
  CHECK(read(root_of("k = 2026-01-09\n")) == "2026-01-09");
  CHECK(read(root_of("k = 0987-12-31\n")) == "0987-12-31");
  CHECK(read(root_of("k = \"spring\"\n")) == "spring");
  CHECK(read(root_of("")).empty());
  check_place(refused_reading("k = 2026\n", read), "TB-FILE-VALUE", "t:1:5, k", "text");
}

TEST_CASE("a word is one of those that are known, and the near one is named") {
  const auto read = [](const TomlTable& table) { return table.word("k", {"forward", "backward"}); };
  CHECK(read(root_of("k = \"backward\"\n")) == "backward");
  CHECK(root_of("").word("k", "forward", {"forward", "backward"}) == "forward");
  CHECK(root_of("k = \"backward\"\n").word("k", "forward", {"forward", "backward"}) == "backward");
  const FileError close = refused_reading("k = \"foward\"\n", read);
  check_place(close, "TB-FILE-VALUE", "t:1:5, k", "forward, backward");
  CHECK_THAT(close.remedy(), Catch::Contains("\"forward\""));
  CHECK_THAT(refused_reading("k = \"up\"\n", read).remedy(), !Catch::Contains("ward"));
  check_place(refused_reading("", read), "TB-FILE-KEY", "t:1:1, k", "missing");
}

TEST_CASE("keys of tables in tables are named with all that they lie in") {
  const auto deep = [](const TomlTable& table) { return table.table("a").table("b").number("c"); };
  CHECK(deep(root_of("[a.b]\nc = 4\n")) == 4.0);
  check_place(refused_reading("[a.b]\nc = \"4\"\n", deep), "TB-FILE-VALUE", "t:2:5, a.b.c", "'c'");
  check_place(refused_reading("a = 1\n", deep), "TB-FILE-VALUE", "t:1:5, a", "table");
  check_place(refused_reading("", deep), "TB-FILE-KEY", "t, a.b.c", "missing");
  const auto listed = [](const TomlTable& table) {
    double sum = 0.0;
    for (const TomlTable& one : table.table("a").tables("l")) sum += one.number("c");
    return sum;
  };
  CHECK(listed(root_of("[[a.l]]\nc = 1\n[[a.l]]\nc = 2\n")) == 3.0);
  CHECK(listed(root_of("")) == 0.0);
  check_place(refused_reading("[[a.l]]\nc = 1\n[[a.l]]\nc = \"2\"\n", listed), "TB-FILE-VALUE", "t:4:5, a.l[1].c",
              "'c'");
  check_place(refused_reading("[a]\nl = [1]\n", listed), "TB-FILE-VALUE", "t:2:5, a.l", "list of tables");
  check_place(refused_reading("[a]\nl = 1\n", listed), "TB-FILE-VALUE", "t:2:5, a.l", "list of tables");
  const auto top = [](const TomlTable& table) { return table.tables("l").front().number("c"); };
  check_place(refused_reading("[[l]]\nc = true\n", top), "TB-FILE-VALUE", "t:2:5, l[0].c", "'c'");
}

TEST_CASE("an unknown key is refused, and the nearest known one is named") {
  const auto read = [](const TomlTable& table) {
    (void)table.has("dwell_s");
    (void)table.keys();  // to list keys is not to ask for them
    table.finish();
    return 0;
  };
  CHECK(refused_reading("dwell_s = 1\n", read).id().empty());
  CHECK(refused_reading("", read).id().empty());
  const FileError close = refused_reading("dwel_s = 1\n", read);
  check_place(close, "TB-FILE-KEY", "t:1:10, dwel_s", "'dwel_s'");
  CHECK_THAT(close.remedy(), Catch::Contains("did you mean 'dwell_s'"));
  const FileError far = refused_reading("dwell_s = 1\nsomething = 1\n", read);
  check_place(far, "TB-FILE-KEY", "t:2:13, something", "'something'");
  CHECK_THAT(far.remedy(), Catch::Contains("dwell_s") && !Catch::Contains("mean"));
  CHECK(root_of("b = 1\na = 2\n").keys() == std::vector<std::string>{"a", "b"});
  CHECK(root_of("").table("none").keys().empty());
  root_of("").table("none").finish();
}

TEST_CASE("texts are remembered in quotes, with their place or as a default") {
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
  CHECK(remembered(document) ==
        "a=\"x\" t:1\nnone=\"\" default\nb=true t:2\noff=false default\nc=\"2026-01-09\" t:3\nnever=\"\" default\n"
        "d=[p, q] t:4\nnobody=[] default\ne.f=\"y\" t:6\ng[0].h=\"z\" t:8\n");
}

TEST_CASE("values of --set have no line of the file") {
  TomlDocument document = TomlDocument::from_text("a = 1\n", "t");
  document.set({"a", "two"}, "bench.");
  CHECK(document.root().text("a") == "two");
  CHECK(remembered(document) == "a=\"two\" --set\n");
  try {
    (void)document.root().number("a");
    FAIL("accepted");
  } catch (const FileError& error) {
    CHECK(error.where() == "--set bench.a (over t)");
  }
}
