// Rows of keys: what each reads into its variable, in which unit, and what it says of itself.
#include "sequences/toml/key_table.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <string>
#include <vector>

#include "devices/units.h"

using namespace tactbench::sequences;
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

TEST_CASE("rows of keys take values in the file's unit, and absent ones keep what the variable held") {
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

TEST_CASE("rows of keys refuse what their facts exclude, and keys without a row") {
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

TEST_CASE("rows of keys say of themselves what they are, and those of another kind of table are added") {
  Values values;
  std::vector<KeyFacts> all;
  add_facts(all, "part", rows_of(values));
  REQUIRE(all.size() == 12);
  CHECK((all[0].key == "part.share" && all[0].unit == "%" && all[0].range == "0 to 100" && all[0].standard == "`50`"));
  CHECK((all[10].standard == "required" && all[11].standard.empty()));
  add_facts(all, "part", {key::number("count", values.count, kOne, {0, 20}, "count")});
  CHECK((all.size() == 12 && all[4].range == "1 to 9; or 0 to 20" && all[4].meaning == "count"));
}
