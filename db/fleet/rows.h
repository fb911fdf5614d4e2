// Rows on their way between a store and the fleet: the values of one row, PostgreSQL's binary COPY format of them
// (its manual, COPY, "Binary Format"), and their hash.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "db/sqlite.h"

namespace tactbench::db::fleet {

// SQLite's INTEGER, REAL, TEXT, BLOB are bigint, double precision, text, bytea.
enum class Kind : char { kInteger = 'i', kReal = 'r', kText = 't', kBytes = 'b' };

struct Column {
  std::string name;
  Kind kind;
};

struct Value {
  bool null = false;
  std::int64_t integer = 0;
  double real = 0.0;
  std::string bytes;  // of text and bytea
};
using Row = std::vector<Value>;

// Reads the statement's present row into the values from `first` on; `row` gets the size of `columns`.
void read_row(const sqlite::Statement& statement, const std::vector<Column>& columns, Row& row, std::size_t first = 0);
// Binds row[i] as parameter i + 1. `row` must live until the statement has run.
void bind_row(sqlite::Statement& statement, const std::vector<Column>& columns, const Row& row);

void add_copy_header(std::string& buffer);
void add_copy_row(std::string& buffer, const std::vector<Column>& columns, const Row& row);
void add_copy_trailer(std::string& buffer);

// Takes pieces of whole rows and hands out each row. Throws FleetError TB-FLEET-SQL when they are not of `columns`.
class CopyReader {
 public:
  CopyReader(std::vector<Column> columns, std::function<void(const Row&)> take);
  void piece(std::string_view bytes);

 private:
  std::vector<Column> columns_;
  std::function<void(const Row&)> take_;
  Row row_;
  bool begun_ = false;
};

// Adds values so that different ones never have the same bytes: a letter for the kind, then the value, or the length
// and the bytes. A real that is not a number is like NULL, and -0.0 like 0.0, as in a store.
void add_to_digest(std::string& bytes, const std::vector<Column>& columns, const Row& row, std::size_t first = 0);

}  // namespace tactbench::db::fleet
