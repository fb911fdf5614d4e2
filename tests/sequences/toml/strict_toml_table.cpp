// Texts, words, dates and tables as they are read, and which keys a table may have.
#include <catch2/catch.hpp>

#include "sequences/toml/strict_toml.h"
#include "tests/sequences/refusal.h"

using namespace tactbench::sequences;

namespace {

template <class Read>
FileError refused_reading(const std::string& text, Read read) {
  return refusal_by([&] { (void)read(TomlDocument::from_text(text, "t").root()); })
      .value_or(FileError("", "accepted", "", ""));
}

TomlTable root_of(const std::string& text) { return TomlDocument::from_text(text, "t").root(); }

}  // namespace

TEST_CASE("true and false are neither numbers nor texts") {
  const auto read = [](const TomlTable& table) { return table.boolean("k", true); };
  CHECK((read(root_of("k = true\n")) && !read(root_of("k = false\n")) && read(root_of(""))));
  CHECK(!root_of("").boolean("k", false));
  check_refused_reading(read,
                        {{"k = 1\n", "TB-FILE-VALUE", "t:1:5, k"}, {"k = \"true\"\n", "TB-FILE-VALUE", "t:1:5, k"}});
}

TEST_CASE("a text without quotes is refused") {
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

TEST_CASE("a date is read as it is written, by TOML or in quotes") {
  const auto read = [](const TomlTable& table) { return table.date_text("k"); };
  CHECK(read(root_of("k = 2026-01-09\n")) == "2026-01-09");
  CHECK(read(root_of("k = 0987-12-31\n")) == "0987-12-31");
  CHECK(read(root_of("k = \"spring\"\n")) == "spring");
  CHECK(read(root_of("")).empty());
  check_refused_reading(read, {{"k = 2026\n", "TB-FILE-VALUE", "t:1:5, k"}});
}

TEST_CASE("a word is one of those that are known, and the near one is named") {
  const auto read = [](const TomlTable& table) { return table.word("k", {"forward", "backward"}); };
  CHECK(read(root_of("k = \"backward\"\n")) == "backward");
  CHECK(root_of("").word("k", "forward", {"forward", "backward"}) == "forward");
  CHECK(root_of("k = \"backward\"\n").word("k", "forward", {"forward", "backward"}) == "backward");
  check_refused_reading(read, {{"k = \"foward\"\n", "TB-FILE-VALUE", "t:1:5, k", "forward, backward"}});
  CHECK_THAT(refused_reading("k = \"foward\"\n", read).remedy(), Catch::Contains("\"forward\""));
  CHECK_THAT(refused_reading("k = \"up\"\n", read).remedy(), !Catch::Contains("ward"));
  check_refused_reading(read, {{"", "TB-FILE-KEY", "t:1:1, k"}});
}

TEST_CASE("keys of tables in tables are named with all that they lie in") {
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
  CHECK(close.where() == "t:1:10, dwel_s");
  CHECK_THAT(close.remedy(), Catch::Contains("'dwell_s'"));
  const FileError far = refused_reading("dwell_s = 1\nsomething = 1\n", read);
  CHECK((far.id() == "TB-FILE-KEY" && far.where() == "t:2:13, something"));
  CHECK_THAT(far.remedy(), Catch::Contains("dwell_s"));
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
  CHECK(noted(document) ==
        "a=\"x\" t:1\nnone=\"\" default\nb=true t:2\noff=false default\nc=\"2026-01-09\" t:3\nnever=\"\" default\n"
        "d=[p, q] t:4\nnobody=[] default\ne.f=\"y\" t:6\ng[0].h=\"z\" t:8\n");
}

TEST_CASE("values of --set have no line of the file") {
  TomlDocument document = TomlDocument::from_text("a = 1\n", "t");
  document.set({"a", "two"}, "bench.");
  CHECK(document.root().text("a") == "two");
  CHECK(noted(document) == "a=\"two\" --set\n");
  check_refusal([&] { (void)document.root().number("a"); }, {"a", "TB-FILE-VALUE", "--set bench.a (over t)"});
}
