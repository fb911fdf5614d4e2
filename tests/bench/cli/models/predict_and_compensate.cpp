// predict and compensate line by line: times, falling outputs, taxels, flags and columns, by straight lines and by a
// film of three cells.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <iostream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "tests/analysis/support/dynamic_runs.h"
#include "tests/bench/cli/models/known_model.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// What std::cin reads within its scope.
class TypedInput {
 public:
  explicit TypedInput(const std::string& text) : text_(text), kept_(std::cin.rdbuf(text_.rdbuf())) {}
  ~TypedInput() {
    std::cin.rdbuf(kept_);
    std::cin.clear();
  }
  TypedInput(const TypedInput&) = delete;
  TypedInput& operator=(const TypedInput&) = delete;

 private:
  std::istringstream text_;
  std::streambuf* kept_;
};

// A column below its heading.
std::vector<std::string> cells(const Finished& ended, const std::string& name) {
  CHECK(ended.code == 0);
  const std::vector<std::vector<std::string>> rows = cells_of(ended.out);
  const auto at = static_cast<std::size_t>(std::ranges::find(rows.at(0), name) - rows[0].begin());
  std::vector<std::string> found;
  for (std::size_t i = 1; i < rows.size(); ++i) found.push_back(rows[i].at(at));
  return found;
}

struct FolderOfModel {
  explicit FolderOfModel(const SensorModel& model) { write_model(folder, "m.json", model); }
  Finished of_table(const std::string& verb, const std::string& text, std::vector<std::string> more = {}) const {
    write_file(folder.path("x.csv"), text);
    more.insert(more.begin(), {verb, "m.json", "x.csv"});
    return model_verb(folder, more);
  }
  Finished typed(const std::string& text, const std::vector<std::string>& words) const {
    const TypedInput input(text);
    return model_verb(folder, words);
  }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("predict: a table without a taxel column is for the only fitted taxel, else --taxel is needed") {
  const FolderOfModel one(straight_model());
  const std::string table = "input\n8\n16\n", predicted = "input,predicted\n8,1\n16,2\n";
  CHECK(one.of_table("predict", table).out == predicted);
  CHECK(one.of_table("predict", table, {"--taxel", "0"}).out == predicted);
  CHECK(one.of_table("predict", table, {"--taxel", "1"}).code == 2);
  const FolderOfModel several([] {
    SensorModel document = known_model(0.1, 0.0);
    document.taxels[0].fit.model = straight_line();
    document.taxels[3].fit.model = straight_line();
    document.taxels[3].zero = 0.5;
    return document;
  }());
  CHECK(several.of_table("predict", table, {"--taxel", "0"}).out == predicted);
  CHECK(several.of_table("predict", table, {"--taxel", "mean"}).out == "input,predicted\n8,1.5\n16,2.5\n");
  const Finished none = several.of_table("predict", table);
  CHECK(none.code == 2);
  CHECK(none.out.empty());
  CHECK_THAT(none.err, Catch::Contains("[TB-MODEL-TAXEL]") && Catch::Contains("\n  at: --taxel\n"));
  check_refusal(several.of_table("predict", table, {"--taxel", "1"}), 6, "TB-ANALYSIS-NO-TAXEL", "--taxel");
  for (const std::string wrong : {"1.5", "99999999999999999999"}) {
    check_refusal(several.of_table("predict", table, {"--taxel", wrong}), 2, "TB-MODEL-TAXEL", "--taxel");
  }
}

TEST_CASE("predict: inputs up to a fiftieth of the span outside the validity range give no warning") {
  SensorModel narrow = straight_model();
  narrow.validity.input = analysis::Range{14.0, 64.0};
  const FolderOfModel of(narrow);
  CHECK(of.of_table("predict", "input\n14\n64\n13.05\n64.95\n").err.empty());
  CHECK(of.of_table("compensate", "output,input\n1,99\n").err.empty());  // inputs are not checked there
}

TEST_CASE("predict and compensate: accept a units row and decimal commas, and keep a file of another kind") {
  const FolderOfModel of(straight_model());
  const Finished predicted = of.of_table("predict", "input;remark\n[N];[-]\n8,5;a\n16,0;b\n");
  CHECK(predicted.code == 0);
  CHECK(predicted.out == "input;remark;predicted\n[N];[-];V\n8,5;a;1,0625\n16,0;b;2\n");
  const Finished compensated = of.of_table("compensate", "output,remark\n[V],[-]\n1.5,a\n");
  CHECK(compensated.out == "output,remark,compensated,uncertainty,flags\n[V],[-],N,N,\n1.5,a,12,nan,\n");
  const Finished written = of.of_table("predict", "input\n8\n", {"-o", "y.csv"});
  CHECK(written.code == 0);
  CHECK(written.out.empty());
  CHECK(read_file(of.folder.path("y.csv")) == "input,predicted\n8,1\n");
  write_file(of.folder.path("mine.csv"), "mine\n");
  const Finished kept = of.of_table("predict", "input\n8\n", {"-o", "mine.csv"});
  CHECK(kept.code == 2);
  CHECK_THAT(kept.err, Catch::Contains("--replace"));
  CHECK(read_file(of.folder.path("mine.csv")) == "mine\n");
  const Finished half = of.of_table("predict", "input\n8\nx\n");  // rows read before the error are printed
  CHECK(half.code == 2);
  CHECK(half.out == "input,predicted\n8,1\n");
  check_refusal(model_verb(of.folder, {"predict", "m.json", "none.csv"}), 2, "TB-TABLE-OPEN");
}

TEST_CASE(
    "compensate: uncertainty is noise over slope, outputs outside the loop are flagged, falling outputs are read") {
  const FolderOfModel of(straight_model(0.0625));
  const Finished rising = of.of_table("compensate", "output\n0\n2\n4\n");
  CHECK(rising.code == 0);
  CHECK(rising.out == "output,compensated,uncertainty,flags\n0,0,0.5,\n2,16,0.5,\n4,32,0.5,\n");
  const FolderOfModel silent(straight_model());
  CHECK(silent.of_table("compensate", "output\n0\n2\n99\n").out ==
        "output,compensated,uncertainty,flags\n0,0,nan,\n2,16,nan,\n99,nan,nan,range\n");
  SensorModel document = straight_model();
  document.falling = true;
  const FolderOfModel falling(document);
  CHECK(falling.of_table("compensate", "output\n0\n-2\n-4\n").out ==
        "output,compensated,uncertainty,flags\n0,0,nan,\n-2,16,nan,\n-4,32,nan,\n");
  CHECK_THAT(falling.of_table("compensate", "output\n0\n2\n").out, Catch::EndsWith("\n2,0,nan,range\n"));
}

TEST_CASE("predict and compensate: each sequence and each taxel has its own history of inputs") {
  SensorModel document = known_model(0.1, 0.0);
  document.taxels.pop_back();
  const FolderOfModel of(document);
  const Finished both = of.of_table("predict", "sequence,taxel,input\na,0,60\na,2,0\nb,0,0\na,0,30\nb,0,30\na,2,30\n");
  CHECK(both.code == 0);
  std::vector<std::string> values;
  for (std::size_t at = 0, end = 0; (end = both.out.find('\n', at)) != std::string::npos; at = end + 1)
    values.push_back(both.out.substr(both.out.rfind(',', end) + 1, end - both.out.rfind(',', end) - 1));
  REQUIRE(values.size() == 7);
  CHECK(values[4] != values[5]);  // from 60 down to 30, and from 0 up
  CHECK(values[5] == values[6]);
  CHECK(values[2] == values[3]);
}

TEST_CASE("compensate: with one column per taxel each taxel is compensated as if alone, an export is read as frames") {
  const FolderOfModel of(known_model(0.1, 0.5));  // taxel 1 is dead
  const std::string rows = "0,1,0,0.6\n0,2,0,1.5\n0,1.4,0,2.5\n0,1,0,1.1\n";
  const Finished wide = of.of_table("compensate", "x,a,b,c\n" + rows, {"--map", "output=2-4"});
  for (const auto& [taxel, column] : {std::pair{"0", "a"}, std::pair{"2", "c"}}) {
    const Finished alone =
        of.of_table("compensate", "x,a,b,c\n" + rows, {"--map", std::string("output=") + column, "--taxel", taxel});
    for (const std::string name : {"compensated", "uncertainty", "flags"})
      CHECK(cells(wide, name + "_" + taxel) == cells(alone, name));
  }
  CHECK(cells(wide, "compensated_1") == std::vector<std::string>(4, "nan"));
  CHECK(cells(wide, "flags_1") == std::vector<std::string>(4, "dead"));
  const Finished frames = of.of_table(
      "compensate",
      "# tactbench: frames of run 1\nframe,recipe,void,reference_psi,scan,volts_r0_c0,volts_r0_c1,volts_r0_c2\n"
      "1,p,0,0,0,0.8,0,0.6\n1,p,0,0,1,1.2,0,0.6\n2,p,1,0,0,9,0,9\n3,p,0,0,0,2,0,1.3\n3,p,0,0,1,2,0,1.7\n"
      "4,p,0,0,0,1.4,0,2.5\n4,p,0,0,1,1.4,0,2.5\n5,p,0,0,0,1,0,1.1\n5,p,0,0,1,1,0,1.1\n");
  for (const std::string name : {"compensated_0", "compensated_2", "flags_2"})
    CHECK(cells(frames, name) == cells(wide, name));
  CHECK(cells(frames, "frame") == std::vector<std::string>{"1", "3", "4", "5"});
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--map", "output=2-3"}, {"--map", "output=2-4", "--taxel", "0"}})
    check_refusal(of.of_table("compensate", "x,a,b,c\n" + rows, more), 2, "TB-TABLE-MAP");
}

TEST_CASE("compensate: a model with lag and creep needs increasing times, and uses their differences") {
  SensorModel film = creeping::creeping_film();
  film.model = "dynamic";
  film.input_unit = "psi";
  film.taxels[0].ascending =
      analysis::PatternCurve(std::vector<double>{10, 50}, std::vector<double>{0.5, 4.2}, 0.5, 4.2);
  film.taxels[0].descending = film.taxels[0].ascending;
  const FolderOfModel of(film);
  check_refusal(of.of_table("compensate", "output\n0.5\n"), 2, "TB-TABLE-COLUMN");
  check_refusal(of.of_table("compensate", "time_s,output\n1,0.5\n0.5,0.6\n"), 2, "TB-TABLE-TIME");
  check_refusal(of.of_table("compensate", "time_s,output\nx,0.5\n"), 2, "TB-TABLE-ROW");
  CHECK(of.of_table("compensate", "time_s,output\n1,0.5\n1,0.6\n").code == 0);
  CHECK(of.of_table("compensate", "sequence,time_s,output\na,9,0.5\nb,1,0.6\na,9.5,0.7\nb,1.5,0.7\n").code == 0);
  const analysis::SensorModel read = analysis::load_model(of.folder.path("m.json"), nullptr);
  using Streamed = std::vector<analysis::Compensated>;
  const auto check = [&](const std::string& rows, const Streamed& streamed, const std::vector<std::string>& more = {}) {
    const Finished table = of.of_table("compensate", "time_s,output\n" + rows, more);
    for (std::size_t i = 0; i < streamed.size(); ++i) {
      CHECK(std::stod(cells(table, "compensated").at(i)) ==
            Approx(streamed[i].pressure_psi).margin(0.05 * streamed[i].uncertainty_psi));
      CHECK(std::stod(cells(table, "uncertainty").at(i)) == Approx(streamed[i].uncertainty_psi).epsilon(1e-3));
      CHECK((cells(table, "flags").at(i).find("unknown") != std::string::npos) == streamed[i].unknown);
      CHECK((cells(table, "flags").at(i).find("flat") != std::string::npos) == streamed[i].flat);
    }
  };
  {  // Begins at rest.
    const auto stream = analysis::compensator_of(read, read.taxels[0]);
    Streamed streamed = {stream->step(0.5, 0.0)};
    streamed.push_back(stream->step(1.5, 2.0));
    streamed.push_back(stream->step(2.5, 0.5));
    check("7,0.5\n9,1.5\n9.5,2.5\n", streamed);
  }
  Streamed late;
  for (const double worked : {0.0, 600.0}) {  // begins in mid-branch
    const auto stream = analysis::compensator_of(read, read.taxels[0]);
    stream->start(analysis::Start::kUnknown);
    stream->work(worked);
    Streamed streamed = {stream->step(2.5, 0.0)};
    streamed.push_back(stream->step(2.25, 2.0));
    check("7,2.5\n9,2.25\n", streamed, {"--conditioned", fmt::format("{}", worked)});
    late.push_back(streamed.front());
  }
  CHECK(late[0].unknown);
  CHECK(std::abs(late[0].pressure_psi - late[1].pressure_psi) > 0.1 * late[0].uncertainty_psi);
  CHECK(of.of_table("predict", "input\n10\n50\n").code == 0);
}

TEST_CASE("predict and compensate: read standard input if no file is given, or if it is -") {
  const FolderOfModel of(straight_model(0.004));
  const Finished predicted = of.typed("input\n8\n16\n", {"predict", "m.json"});
  CHECK(predicted.code == 0);
  CHECK(predicted.err.empty());
  CHECK(predicted.out == "input,predicted\n8,1\n16,2\n");
  CHECK(of.typed("input\n8\n16\n", {"predict", "m.json", "-"}).out == predicted.out);
  CHECK(of.typed("output\n2\n", {"compensate", "m.json"}).out == "output,compensated,uncertainty,flags\n2,16,0.032,\n");
  for (const char* verb : {"predict", "compensate"})
    for (const char* text : {"", "what\n1\n"}) {
      INFO(verb << " of " << text);
      CHECK((of.typed(text, {verb, "m.json"}).code == 2 && of.of_table(verb, text).code == 2));
    }
  CHECK(of.typed("input,output\n1,x\n", {"compensate", "m.json"}).code == 2);
  CHECK(of.typed("input,output\n1,x\n", {"predict", "m.json"}).code == 0);  // the outputs are not checked
}

TEST_CASE("live: an unwritable frame file ends it before a device is opened") {
  const FolderOfModel of(straight_model());
  const Finished refused =
      verb_here(bench::add_live, {"live", "--bench", "simulated.toml", "--model", of.folder.path("m.json"), "--csv",
                                  of.folder.path("none/f.csv")});
  check_refusal(refused, 2, "TB-FILE-WRITE");
  CHECK(refused.out.empty());
}
