// The view of frames: counts as they were stored, wrench and place as numbers that SQL alone decodes.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "db/run_store.h"
#include "db/sqlite.h"
#include "tests/db/new_store.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

namespace {

constexpr std::array<const char*, 9> kNumbers = {"fx_n",   "fy_n", "fz_n", "tx_nmm", "ty_nmm",
                                                 "tz_nmm", "x_mm", "y_mm", "z_mm"};

struct FrameRow {
  std::array<double, 9> value{};
  std::array<bool, 9> known{};
};

FrameRow row_of(Connection& raw, std::int64_t position) {
  FrameRow row;
  for (std::size_t i = 0; i < kNumbers.size(); ++i) {
    const std::string where = " FROM v_frames WHERE run = 1 AND position = " + std::to_string(position);
    row.known[i] = raw.integer(std::string("SELECT ") + kNumbers[i] + " IS NOT NULL" + where) == 1;
    db::sqlite::Statement number(raw, std::string("SELECT coalesce(") + kNumbers[i] + ", 0.0)" + where);
    REQUIRE(number.step());
    number.read(row.value[i]);
  }
  return row;
}

}  // namespace

TEST_CASE("v_frames has each wrench and place as stored, bit for bit") {
  NewStore store;
  const Begun begun = begin_example(store);
  std::mt19937_64 random(20);  // NOLINT(bugprone-random-generator-seed): the same each time
  std::uniform_real_distribution<double> mantissa(-1.0, 1.0);
  std::uniform_int_distribution<int> exponent(-70, 40);
  std::vector<FrameRow> stored;
  for (int i = 0; i < 40; ++i) {
    db::FrameRecord frame = example_frame(begun.branch, i);
    FrameRow row;
    for (std::size_t k = 0; k < row.value.size(); ++k) row.value[k] = std::ldexp(mantissa(random), exponent(random));
    if (i == 0) row.value = {0.0, -0.0, 1.0, -1.0, 60.0, 0.1, -6.2, std::ldexp(1.0, 60), std::ldexp(1.0, -120)};
    for (std::size_t k = 0; k < 6; ++k) frame.wrench->wrench.at(k) = row.value[k];
    for (std::size_t k = 0; k < 3; ++k) frame.wrench->place_mm.at(k) = row.value[6 + k];
    stored.push_back(row);
    store.append_frame(begun.run, frame);
  }
  db::FrameRecord without = example_frame(begun.branch, 40);
  without.wrench.reset();
  store.append_frame(begun.run, without);
  db::FrameRecord broken = example_frame(begun.branch, 41);
  broken.wrench->wrench.at(2) = std::numeric_limits<double>::infinity();
  broken.wrench->wrench.at(3) = std::nan("");
  store.append_frame(begun.run, broken);

  Connection raw(store.path(), Access::kReadOnly);
  for (std::size_t i = 0; i < stored.size(); ++i) {
    const FrameRow row = row_of(raw, static_cast<std::int64_t>(i) + 1);
    for (std::size_t k = 0; k < row.value.size(); ++k) {
      CAPTURE(i, kNumbers[k]);
      CHECK(row.known[k]);
      CHECK(row.value[k] == stored[i].value[k]);
    }
  }
  const FrameRow none = row_of(raw, 41), half = row_of(raw, 42);
  for (const bool known : none.known) CHECK_FALSE(known);
  CHECK((half.known[0] && !half.known[2] && !half.known[3] && half.known[8]));
}

TEST_CASE("v_frames has the raw counts and the value of a count") {
  NewStore store;
  store_example(store);
  Connection raw(store.path(), Access::kReadOnly);
  CHECK(raw.integer("SELECT count(*) FROM v_frames v JOIN frames f ON f.frame = v.run * 1000000000 + v.position "
                    "WHERE v.counts = f.counts AND v.wrench_raw = f.wrench_raw") == 3);
  CHECK(raw.integer("SELECT length(counts) FROM v_frames WHERE position = 1") == 24);
  db::RunRecord other = example_run();
  other.devices = {{"tactile scanner", "", "", "", "simulated", R"({"volts_per_count": 0.25})"},
                   {"regulator", "", "", "", "simulated", R"({"volts_per_count": 9})"}};
  store_example(store, other);
  other.devices.front().calibration_json = "no JSON";
  store_example(store, other);
  CHECK(raw.integer("SELECT count(*) FROM v_frames WHERE run = 2 AND volts_per_count = 0.25") == 3);
  CHECK(raw.integer("SELECT count(*) FROM v_frames WHERE run = 3 AND volts_per_count IS NULL") == 3);
}
