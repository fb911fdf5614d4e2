// Numbers as they are read: kinds, bounds, lists, and what is remembered of them.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "sequences/toml/strict_toml.h"
#include "tests/sequences/refusal.h"

using namespace tactbench::sequences;

namespace {

template <class Read>
std::string id_refused(const std::string& text, Read read) {
  const auto error = refusal_by([&] { (void)read(TomlDocument::from_text(text, "t").root()); });
  return error ? error->id() : "";
}

const auto kRead = [](const TomlTable& table) { return table.number("k"); };

}  // namespace

TEST_CASE("a number is an integer or a finite floating-point number") {
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

TEST_CASE("a defined name stands for its number") {
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

TEST_CASE("bounds are allowed and the next number beyond them is not") {
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

TEST_CASE("a list of numbers has numbers alone") {
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

TEST_CASE("a span's end is above its beginning") {
  const auto span = [](const TomlTable& table) { return table.span("k", {-3.0, 4.5}); };
  CHECK(span(TomlDocument::from_text("k = [1, 2]\n", "t").root()) == std::pair(1.0, 2.0));
  CHECK(span(TomlDocument::from_text("", "t").root()) == std::pair(-3.0, 4.5));
  for (const char* wrong : {"[2, 2]", "[2, 1]", "[1]", "[1, 2, 3]", "[]"}) {
    check_refused_reading(span, {{"k = " + std::string(wrong) + "\n", "TB-FILE-VALUE", "t:1:5, k"}});
  }
}

TEST_CASE("lists in a list have the required length") {
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

TEST_CASE("what was read is remembered once, with its place or as a default") {
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
