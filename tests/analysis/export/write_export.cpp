// The folder for a microcontroller.
#include "analysis/export/write_export.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "analysis/export/quantise.h"
#include "tests/analysis/compensate/kinds.h"

using namespace synthetic;

namespace {

SensorModel named(const char* name) {
  const std::vector<Kind> all = kinds();
  return sensor_of(*std::ranges::find(all, name, &Kind::name));
}

struct Row {
  std::string event;
  std::vector<std::uint16_t> values;  // counts, pressures and states
};

std::vector<Row> rows_of(const std::string& text) {
  std::vector<Row> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream cells(line);
    Row& row = rows.emplace_back();
    std::getline(cells, row.event, ',');
    for (std::string cell; std::getline(cells, cell, ',');)
      row.values.push_back(static_cast<std::uint16_t>(std::stoul(cell)));
  }
  return rows;
}

}  // namespace

TEST_CASE("fixed export: test vectors cover every state and both ends, and a stream reproduces them") {
  for (const char* const name : {"elam", "linearised in time"}) {
    const auto fixed = std::make_shared<const FixedModel>(quantised(named(name), {5.0 / 65535.0, 76.0, 2, 0.0, 0.0}));
    const std::vector<Row> rows = rows_of(vectors_of(*fixed, 240));
    REQUIRE(rows.size() == 240);
    FixedFrames stream(fixed);
    std::vector<std::uint16_t> pressures(kThree), status(kThree), counts;
    unsigned seen = 0, lowest = 65535, highest = 0;
    for (const Row& row : rows) {
      REQUIRE(row.values.size() == 3 * kThree);
      counts.assign(row.values.begin(), row.values.begin() + kThree);
      if (row.event == "tare") {
        CHECK(stream.tare(counts) == 0);
        continue;
      }
      if (row.event == "lost")
        stream.lost_frame(pressures, status);
      else
        stream.frame(counts, pressures, status);
      INFO(name);
      REQUIRE(std::equal(pressures.begin(), pressures.end(), row.values.begin() + kThree));
      REQUIRE(std::equal(status.begin(), status.end(), row.values.begin() + 2 * kThree));
      for (const std::uint16_t bits : status) seen |= bits;
      lowest = std::min<unsigned>(lowest, pressures[2]);
      highest = std::max<unsigned>(highest, pressures[2]);
    }
    CHECK(seen == (TB_VALID | TB_OUT_OF_RANGE | TB_DEAD | TB_UNKNOWN | TB_LOST));
    CHECK(lowest == 0);
    CHECK(highest == fixed->highest);
  }
}

TEST_CASE("fixed export: the folder holds the model's words, the headers and an example named after it") {
  const SensorModel model = named("elam");
  const FixedModel fixed = quantised(model, {5.0 / 65535.0, 0.0, 2, 0.0, 0.0});
  const std::vector<ExportedFile> files = export_files(model, fixed, "robot", "1.2.3");
  const auto text = [&](const std::string& name) {
    const auto found = std::ranges::find(files, name, &ExportedFile::name);
    return found == files.end() ? std::string() : found->text;
  };
  for (const char* const name : {"tb_model.h", "tb_fixed.h", "tb_elam.h", "robot.ino", "vectors.csv", "README.md"})
    CHECK_FALSE(text(name).empty());
  CHECK(text("tb_dynamic.h").empty());
  std::istringstream table(text("tb_model.h").substr(text("tb_model.h").find("tb_table[] = {") + 14));
  std::vector<std::uint16_t> words;
  for (std::string word; std::getline(table, word, ',') && words.size() < fixed.table.size();)
    words.push_back(static_cast<std::uint16_t>(std::stoul(word)));
  CHECK(words == fixed.table);
}
