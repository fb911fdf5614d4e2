// Samples that are none, and rows that no sensor gives: what fit and compensate make of them.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/bench/cli/play_table.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

using Rows = std::vector<std::string>;

const std::vector<double> kWay = {0, 10, 0, 10, 2, 8, 3, 10, 5, 9, 0, 10, 0};

Rows rows_of_way(int columns = 1) {
  Rows rows;
  for (const PlaySample& sample : play_samples(kWay)) {
    rows.push_back(std::to_string(sample.input));
    for (int k = 1; k <= columns; ++k) rows.back() += "," + std::to_string(k * sample.output);
  }
  return rows;
}

std::string text_of(const std::string& names, const Rows& rows) {
  std::string text = names + "\n";
  for (const std::string& row : rows) text += row + "\n";
  return text;
}

Rows lines_of(const std::string& text) {
  Rows lines;
  std::size_t first = 0;
  for (std::size_t end = 0; (end = text.find('\n', first)) != std::string::npos; first = end + 1)
    lines.push_back(text.substr(first, end - first));
  return lines;
}

class FolderOfSamples {
 public:
  FolderOfSamples(const std::string& names, int columns, Rows options = {})
      : names_(names), rows_(rows_of_way(columns)) {
    write_file(folder_.path("t.csv"), text_of(names, rows_));
    options.insert(options.begin(), {"fit", "t.csv", "--model", "elam", "-o", "m.json"});
    REQUIRE(call(folder_, options).code == 0);
  }
  [[nodiscard]] const Rows& rows() const { return rows_; }
  [[nodiscard]] Finished verb(Rows words, const Rows& rows) const {
    write_file(folder_.path("x.csv"), text_of(names_, rows));
    return call(folder_, std::move(words));
  }

 private:
  TemporaryFolder folder_;
  std::string names_;
  Rows rows_;
};

}  // namespace

TEST_CASE("compensate: a row without an output is passed on and flagged, and the others are as without it") {
  const FolderOfSamples of("input,output", 1);
  constexpr std::size_t kPlace = 30;
  Rows without = of.rows();
  without.erase(without.begin() + kPlace);
  const Rows clean = lines_of(of.verb({"compensate", "m.json", "x.csv"}, without).out);
  for (const char* bad : {"5,nan", "5,", "5,OL", "5,-inf", "5,1e999", "5"}) {
    Rows rows = of.rows();
    rows[kPlace] = bad;
    const Finished done = of.verb({"compensate", "m.json", "x.csv"}, rows);
    INFO(bad << "\n" << done.err);
    CHECK(done.code == 0);
    CHECK_THAT(done.err, Catch::Contains("x.csv:32"));  // a line of names, and counted from 1
    Rows lines = lines_of(done.out);
    REQUIRE(lines.size() == clean.size() + 1);
    CHECK_THAT(lines[kPlace + 1], Catch::EndsWith(",nan,nan,bad"));
    lines.erase(lines.begin() + kPlace + 1);
    CHECK(lines == clean);
  }
}

TEST_CASE("compensate: an output that the taxel cannot give is no input, and the next is as before") {
  const FolderOfSamples of("input,output", 1);
  constexpr std::size_t kPlace = 30;
  Rows rows = of.rows(), without = rows;
  without.erase(without.begin() + kPlace);
  rows[kPlace] = "5,1000";
  const Rows clean = lines_of(of.verb({"compensate", "m.json", "x.csv"}, without).out);
  Rows lines = lines_of(of.verb({"compensate", "m.json", "x.csv"}, rows).out);
  REQUIRE(lines.size() == clean.size() + 1);
  CHECK_THAT(lines[kPlace + 1], Catch::EndsWith(",nan,nan,range"));
  lines.erase(lines.begin() + kPlace + 1);
  CHECK(lines == clean);
}

TEST_CASE("compensate: of a table with a column a taxel only the taxel without an output has none") {
  const FolderOfSamples of("input,s0,s1", 2, {"--map", "output=s*"});
  Rows rows = of.rows();
  const std::string row = rows[30];
  rows[30] = row.substr(0, row.rfind(',')) + ",OL";
  const Rows words = {"compensate", "m.json", "x.csv", "--map", "output=s*"};
  const Rows clean = lines_of(of.verb(words, of.rows()).out), lines = lines_of(of.verb(words, rows).out);
  REQUIRE(lines.size() == clean.size());
  CHECK_THAT(lines[31], Catch::EndsWith(",nan,nan,bad"));
  const auto first_taxel = [](const std::string& line) {  // behind the three columns of the table
    std::size_t at = 0;
    for (int k = 0; k < 3; ++k) at = line.find(',', at) + 1;
    return line.substr(at, line.find(',', at) - at);
  };
  for (std::size_t i = 0; i < lines.size(); ++i) CHECK(first_taxel(lines[i]) == first_taxel(clean[i]));
  for (std::string& own : rows) own = own.substr(0, own.rfind(',')) + ",OL";
  CHECK(of.verb(words, rows).code == 0);  // the other has outputs
}

TEST_CASE("compensate: a table in which no row has an output is refused, and predict refuses a row without an input") {
  const FolderOfSamples of("input,output", 1);
  const Finished none = of.verb({"compensate", "m.json", "x.csv"}, {"1,a", "2,b", "3,c"});
  CHECK(none.code == 2);
  CHECK_THAT(none.err, Catch::Contains("TB-TABLE-SKIPPED"));
  const Finished predicted = of.verb({"predict", "m.json", "x.csv"}, {"1,1", "OL,2", "3,3"});
  CHECK(predicted.code == 2);
  CHECK_THAT(predicted.err, Catch::Contains("TB-TABLE-ROW") && !Catch::Contains("--skip-bad-rows"));
}

TEST_CASE("fit: a wild output is named with its line and makes the taxel unfit, or its row is left out on request") {
  const FolderOfSamples of("input,output", 1);
  Rows rows = of.rows();
  const auto cell = [](const std::string& row) { return row.substr(0, row.find(',')) + ",83886.07"; };
  rows[40] = cell(rows[40]);
  const Rows fit = {"compare", "x.csv", "--models", "elam,monotone"};
  const auto with = [&](const char* option) {
    Rows words = fit;
    words.emplace_back(option);
    return of.verb(words, rows);
  };
  const Finished told = of.verb(fit, rows);
  CHECK(told.code == 6);
  CHECK_THAT(told.err, Catch::Contains("line 42"));
  CHECK_THAT(told.out, Catch::Contains("unfit"));
  const auto told_json = nlohmann::json::parse(with("--json").out);
  for (const auto& model : told_json.at("models")) CHECK(model.at("left_out").at(0).at("status") == "unfit");
  Rows low = of.rows();  // where it would turn the sign of what follows the input
  low[1] = cell(low[1]);
  const Finished still = of.verb(fit, low);
  CHECK((still.code == 6 && still.out.find("unfit") != std::string::npos));
  const Finished without = with("--skip-bad-rows");
  CHECK(without.code == 0);
  CHECK_THAT(without.err, Catch::Contains("line 42"));
  Rows clean = of.rows();
  clean.erase(clean.begin() + 40);
  const Finished same = of.verb(fit, clean);
  CHECK(without.out == same.out);
}
