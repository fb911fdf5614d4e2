// predict and compensate of a table on standard input, and the names of tables in what is said of them.
#include <catch2/catch.hpp>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/bench/cli/models/known_model.h"
#include "tests/bench/cli/models/models_here.h"

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

// 0.125 V/N from 0 to 64 N.
struct LineInFolder {
  LineInFolder() { write_model(folder, "m.json", straight_model(0.004)); }
  [[nodiscard]] Finished typed(const std::string& text, const std::vector<std::string>& words) const {
    const TypedInput input(text);
    return model_verb(folder, words);
  }
  [[nodiscard]] Finished of_file(const std::string& text, const std::string& verb) const {
    write_file(folder.path("x.csv"), text);
    return model_verb(folder, {verb, "m.json", "x.csv"});
  }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("predict and compensate read standard input where no file is named, and where - is") {
  const LineInFolder of;
  const Finished predicted = of.typed("input\n8\n16\n", {"predict", "m.json"});
  CHECK(predicted.code == 0);
  CHECK(predicted.err.empty());
  CHECK(predicted.out == "input,predicted\n8,1\n16,2\n");
  CHECK(of.typed("input\n8\n16\n", {"predict", "m.json", "-"}).out == predicted.out);
  CHECK(of.typed("output\n2\n", {"compensate", "m.json"}).out == "output,compensated,uncertainty,flags\n2,16,0.032,\n");
  CHECK(of.typed("input\n8\n", {"predict", "m.json", "-o", "y.csv"}).out.empty());
  CHECK(read_file(of.folder.path("y.csv")) == "input,predicted\n8,1\n");
}

TEST_CASE("predict and compensate name the table that is wrong: the file, or standard input") {
  const LineInFolder of;
  for (const char* verb : {"predict", "compensate"}) {
    for (const char* text : {"", "what\n1\n", "input,output\n1,x\n"}) {
      INFO(verb << " of " << text);
      const Finished typed = of.typed(text, {verb, "m.json"}), file = of.of_file(text, verb);
      CHECK(typed.code == file.code);
      if (std::string(verb) == "predict" && std::string(text) == "input,output\n1,x\n") {
        CHECK(typed.code == 0);  // the outputs are not looked at
        continue;
      }
      CHECK(typed.code == 2);
    }
  }
}

TEST_CASE("live: frames that cannot be written end it before a device is opened") {
  const LineInFolder of;
  const std::string csv = of.folder.path("none/frames.csv");
  const Finished refused = verb_here(
      bench::add_live, {"live", "--bench", "simulated.toml", "--model", of.folder.path("m.json"), "--csv", csv});
  CHECK(refused.code == 2);
  CHECK(refused.out.empty());
  CHECK_THAT(refused.err, Catch::Contains("[TB-FILE-WRITE]"));
}
