// Rows on their way: PostgreSQL's binary format, byte for byte, and the hash of rows.
#include "db/fleet/rows.h"

#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "db/fleet/fleet_error.h"
#include "db/fleet/local_runs.h"

using namespace tactbench;
using db::fleet::add_copy_header;
using db::fleet::add_copy_row;
using db::fleet::add_copy_trailer;
using db::fleet::add_to_digest;
using db::fleet::bind_row;
using db::fleet::Column;
using db::fleet::CopyReader;
using db::fleet::FleetError;
using db::fleet::Kind;
using db::fleet::month_of;
using db::fleet::read_row;
using db::fleet::Row;
using db::fleet::Value;

namespace {

const std::vector<Column> kColumns = {
    {"a", Kind::kInteger}, {"b", Kind::kReal}, {"c", Kind::kText}, {"d", Kind::kBytes}};

Row row_of(std::int64_t integer, double real, const std::string& text, const std::string& bytes) {
  Row row(4);
  row[0].integer = integer;
  row[1].real = real;
  row[2].bytes = text;
  row[3].bytes = bytes;
  return row;
}

std::string copied(const std::vector<Row>& rows) {
  std::string buffer;
  add_copy_header(buffer);
  for (const Row& row : rows) add_copy_row(buffer, kColumns, row);
  add_copy_trailer(buffer);
  return buffer;
}

std::string digest(const Row& row) {
  std::string bytes;
  add_to_digest(bytes, kColumns, row);
  return bytes;
}

std::string error_of(const std::string& bytes) {
  try {
    CopyReader(kColumns, [](const Row&) {}).piece(bytes);
  } catch (const FleetError& error) {
    return error.id();
  }
  return {};
}

}  // namespace

TEST_CASE("fleet: a row in binary COPY is as PostgreSQL's manual says") {
  Row row = row_of(-2, 1.5, "é", {});
  row[3].null = true;
  const std::string expected = std::string("PGCOPY\n\377\r\n\0", 11) + std::string(8, '\0') + std::string("\0\4", 2) +
                               std::string("\0\0\0\10", 4) + "\377\377\377\377\377\377\377\376" +
                               std::string("\0\0\0\10\77\370\0\0\0\0\0\0", 12) + std::string("\0\0\0\2", 4) + "é" +
                               "\377\377\377\377" + "\377\377";
  CHECK(copied({row}) == expected);
}

TEST_CASE("fleet: rows come back as they went, whatever is in them") {
  std::vector<Row> rows = {row_of(std::numeric_limits<std::int64_t>::min(), -0.0, "", std::string("\0\377", 2)),
                           row_of(7, 1.0 / 3.0, "a\nb", {}), row_of(0, HUGE_VAL, "x", "y")};
  rows[1][1].null = rows[2][2].null = true;
  std::vector<Row> back;
  CopyReader reader(kColumns, [&](const Row& row) { back.push_back(row); });
  const std::string all = copied(rows);
  const std::string first = copied({rows[0]});
  reader.piece(all.substr(0, first.size() - 2));  // as a server sends: whole rows, the header with the first
  reader.piece(all.substr(first.size() - 2));
  REQUIRE(back.size() == rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      INFO(i << ", " << j);
      REQUIRE(back[i][j].null == rows[i][j].null);
      if (rows[i][j].null) continue;
      if (j == 0) CHECK(back[i][j].integer == rows[i][j].integer);
      if (j == 1) CHECK(std::bit_cast<std::uint64_t>(back[i][j].real) == std::bit_cast<std::uint64_t>(rows[i][j].real));
      if (j > 1) CHECK(back[i][j].bytes == rows[i][j].bytes);
    }
  }
}

TEST_CASE("fleet: bytes that are no rows of these columns are refused") {
  const std::string good = copied({row_of(1, 2.0, "text", "bytes")});
  CHECK(error_of(good).empty());
  CHECK(error_of("PGCOPY") == "TB-FLEET-SQL");
  CHECK(error_of("X" + good.substr(1)) == "TB-FLEET-SQL");
  std::string fields = good;
  fields[20] = 5;  // of the row's number of fields
  CHECK(error_of(fields) == "TB-FLEET-SQL");
  std::string size = good;
  size[24] = 7;  // of the first value
  CHECK(error_of(size) == "TB-FLEET-SQL");
  for (std::size_t cut = 20; cut + 3 < good.size(); ++cut) {
    INFO(cut);
    CHECK(error_of(good.substr(0, cut)) == "TB-FLEET-SQL");
  }
}

TEST_CASE("fleet: different rows never have the same digest, and equal ones do as in a store") {
  const std::string one = digest(row_of(1, 2.0, "ab", "c"));
  CHECK(digest(row_of(2, 2.0, "ab", "c")) != one);
  CHECK(digest(row_of(1, 2.5, "ab", "c")) != one);
  CHECK(digest(row_of(1, 2.0, "a", "bc")) != one);
  CHECK(digest(row_of(1, 2.0, "ab", "d")) != one);
  CHECK(digest(row_of(1, 0.0, "", "")) == digest(row_of(1, -0.0, "", "")));
  Row none = row_of(1, 0.0, "", "");
  none[1].null = true;
  CHECK(digest(none) == digest(row_of(1, std::nan(""), "", "")));
  CHECK(digest(none) != digest(row_of(1, 0.0, "", "")));
}

TEST_CASE("fleet: the bytes under a digest are a letter and eight bytes for each value, and the texts' own") {
  Row row = row_of(-2, 1.5, "ab", std::string("\0c", 2));
  const std::string integer = "i\377\377\377\377\377\377\377\376", real = std::string("r\77\370\0\0\0\0\0\0", 9),
                    text = std::string("t\0\0\0\0\0\0\0\2", 9) + "ab", bytes = std::string("b\0\0\0\0\0\0\0\2\0c", 11),
                    none = "n" + std::string(8, '\0');
  CHECK(digest(row) == integer + real + text + bytes);
  std::string later = "before";
  add_to_digest(later, kColumns, row, 2);
  CHECK(later == "before" + text + bytes);
  for (Value& value : row) value.null = true;
  CHECK(digest(row) == none + none + none + none);
  CHECK(digest(row_of(0, -0.0, "", "")) == "i" + std::string(8, '\0') + "r" + std::string(8, '\0') + "t" +
                                               std::string(8, '\0') + "b" + std::string(8, '\0'));
}

TEST_CASE("fleet: a row goes into a store and comes back, each kind as its own, and NULL as NULL") {
  db::sqlite::Connection memory(":memory:", db::sqlite::Access::kReadWrite);
  memory.execute("CREATE TABLE t (a INTEGER, b REAL, c TEXT, d BLOB)");
  const Row first = row_of(-7, 2.0, "text", std::string("\0\377", 2)), empty = row_of(0, 0.0, "", "");
  Row none = row_of(1, 1.0, "x", "y");
  for (Value& value : none) value.null = true;
  {
    db::sqlite::Statement insert(memory, "INSERT INTO t VALUES (?, ?, ?, ?)");
    for (const Row* row : std::vector<const Row*>{&first, &none, &empty}) {
      bind_row(insert, kColumns, *row);
      insert.run();
    }
  }
  CHECK(memory.text("SELECT group_concat(typeof(a) || ' ' || typeof(b) || ' ' || typeof(c) || ' ' || typeof(d), ', ') "
                    "FROM t") == "integer real text blob, null null null null, integer real text blob");
  db::sqlite::Statement rows(memory, "SELECT * FROM t");
  Row back;
  REQUIRE(rows.step());
  read_row(rows, kColumns, back);
  REQUIRE(back.size() == 4);
  CHECK((back[0].integer == -7 && back[1].real == 2.0 && back[2].bytes == "text" && back[3].bytes == first[3].bytes));
  for (const Value& value : back) CHECK_FALSE(value.null);
  REQUIRE(rows.step());
  read_row(rows, kColumns, back);
  for (const Value& value : back) CHECK(value.null);
  REQUIRE(rows.step());
  read_row(rows, kColumns, back);
  for (const Value& value : back) CHECK_FALSE(value.null);
  // Behind a first value that the statement does not have.
  db::sqlite::Statement rest(memory, "SELECT 2.5, 'c', x'64'");
  REQUIRE(rest.step());
  Row row(1);
  row[0].integer = 41;
  read_row(rest, kColumns, row, 1);
  REQUIRE(row.size() == 4);
  CHECK((row[0].integer == 41 && row[1].real == 2.5 && row[2].bytes == "c" && row[3].bytes == "d"));
}

TEST_CASE("fleet: numbers have eight bytes, nothing follows the end, and rows come in any number of pieces") {
  const auto row_with = [](std::size_t at, const std::string& value) {  // a row of which one value has other bytes
    std::string bytes;
    add_copy_header(bytes);
    bytes += std::string("\0\4", 2);
    for (std::size_t i = 0; i < 4; ++i) {
      const std::string own = i == at ? value : std::string(8, 'v');
      bytes += std::string("\0\0\0", 3) + static_cast<char>(own.size()) + own;
    }
    return bytes;
  };
  for (const std::size_t size : {0U, 4U, 7U, 8U, 9U, 16U}) {
    for (const std::size_t at : {0U, 1U, 2U, 3U}) {
      CAPTURE(size, at);
      CHECK(error_of(row_with(at, std::string(size, 'x'))).empty() == (size == 8 || at > 1));
    }
  }
  std::vector<std::int64_t> seen;
  CopyReader reader(kColumns, [&](const Row& row) { seen.push_back(row[0].integer); });
  const std::string header = copied({}).substr(0, 19);
  const auto bare = [](std::int64_t number) {
    std::string bytes;
    add_copy_row(bytes, kColumns, row_of(number, 0.0, "", ""));
    return bytes;
  };
  reader.piece(header);
  reader.piece(bare(1) + bare(2));
  reader.piece("");
  reader.piece(bare(3) + "\377\377" + bare(4));
  CHECK(seen == std::vector<std::int64_t>{1, 2, 3});
  CHECK(error_of(header).empty());
  CHECK(error_of(header.substr(0, 18)) == "TB-FLEET-SQL");
  for (const std::string& fields : {std::string("\0\3", 2), std::string("\1\4", 2), std::string("\0\0", 2)})
    CHECK(error_of(header + fields + bare(1).substr(2)) == "TB-FLEET-SQL");
}

TEST_CASE("fleet: the month of a start") {
  CHECK(month_of("2026-01-31T12:00:00Z") == 202601);
  CHECK(month_of("2026-12-01") == 202612);
  CHECK(month_of("1970-01") == 197001);
  CHECK(month_of("2026-09-30T00:00:00Z") == 202609);
  for (const char* text :
       {"", "2026", "2026-13-01", "2026-00-01", "20260131", "1969-01-01", "yesterday", "2026-1", "1969-12-31",
        "2026/01/01", "2o26-01-01", "202:-01-01", "/026-01-01", "2026-0x-01", "2026-x1-01", "2026--1"}) {
    INFO(text);
    CHECK(month_of(text) == 0);
  }
}
