#include "db/fleet/rows.h"

#include <bit>
#include <cmath>
#include <concepts>
#include <span>
#include <utility>

#include "db/fleet/fleet_error.h"

namespace tactbench::db::fleet {

namespace {

constexpr std::string_view kSignature("PGCOPY\n\377\r\n\0", 11);
constexpr std::size_t kHeader = 19;  // signature, flags, length of the extension

template <std::unsigned_integral Number>
void add_number(std::string& buffer, Number value) {  // big-endian
  for (int shift = static_cast<int>(8 * sizeof(Number)) - 8; shift >= 0; shift -= 8)
    buffer += static_cast<char>(value >> shift);
}

template <std::unsigned_integral Number>
Number number_at(std::string_view bytes, std::size_t at) {
  Number value = 0;
  for (std::size_t i = 0; i < sizeof(Number); ++i)
    value = static_cast<Number>(static_cast<Number>(value << 8) | static_cast<std::uint8_t>(bytes[at + i]));
  return value;
}

[[noreturn]] void fail_rows() {
  throw FleetError(FleetCause::kStore, "TB-FLEET-SQL", "the fleet's rows are not of the columns that were asked for",
                   "see whether another program changed its tables");
}

}  // namespace

void read_row(const sqlite::Statement& statement, const std::vector<Column>& columns, Row& row, std::size_t first) {
  row.resize(columns.size());
  for (std::size_t i = first; i < columns.size(); ++i) {
    const int at = static_cast<int>(i - first);
    Value& value = row[i];
    value.null = statement.is_null(at);
    if (value.null) continue;
    if (columns[i].kind == Kind::kInteger)
      statement.read_from(at, value.integer);
    else if (columns[i].kind == Kind::kReal)
      statement.read_from(at, value.real);
    else
      statement.read_from(at, value.bytes);
  }
}

void bind_row(sqlite::Statement& statement, const std::vector<Column>& columns, const Row& row) {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const int at = static_cast<int>(i) + 1;
    const Value& value = row[i];
    if (value.null) continue;  // an unbound parameter is NULL
    if (columns[i].kind == Kind::kInteger)
      statement.bind_at(at, value.integer);
    else if (columns[i].kind == Kind::kReal)
      statement.bind_at(at, value.real);
    else if (columns[i].kind == Kind::kText)
      statement.bind_at(at, value.bytes);
    else
      statement.bind_at(at, std::span(value.bytes));
  }
}

void add_copy_header(std::string& buffer) {
  buffer += kSignature;
  buffer.append(kHeader - kSignature.size(), '\0');
}

void add_copy_row(std::string& buffer, const std::vector<Column>& columns, const Row& row) {
  add_number(buffer, static_cast<std::uint16_t>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Value& value = row[i];
    const Kind kind = columns[i].kind;
    if (value.null) {
      add_number(buffer, std::uint32_t{0xffffffff});
    } else if (kind == Kind::kInteger || kind == Kind::kReal) {
      add_number(buffer, std::uint32_t{8});
      add_number(buffer, kind == Kind::kInteger ? static_cast<std::uint64_t>(value.integer)
                                                : std::bit_cast<std::uint64_t>(value.real));
    } else {
      add_number(buffer, static_cast<std::uint32_t>(value.bytes.size()));
      buffer += value.bytes;
    }
  }
}

void add_copy_trailer(std::string& buffer) { add_number(buffer, std::uint16_t{0xffff}); }

CopyReader::CopyReader(std::vector<Column> columns, std::function<void(const Row&)> take)
    : columns_(std::move(columns)), take_(std::move(take)), row_(columns_.size()) {}

void CopyReader::piece(std::string_view bytes) {
  std::size_t at = 0;
  const auto need = [&](std::size_t size) {
    if (bytes.size() - at < size) fail_rows();
  };
  if (!begun_) {
    need(kHeader);
    if (!bytes.starts_with(kSignature)) fail_rows();
    at = kHeader;
    begun_ = true;
  }
  while (at < bytes.size()) {
    need(2);
    const auto fields = number_at<std::uint16_t>(bytes, at);
    at += 2;
    if (fields == 0xffff) return;
    if (fields != columns_.size()) fail_rows();
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      need(4);
      const auto size = number_at<std::uint32_t>(bytes, at);
      at += 4;
      Value& value = row_[i];
      value.null = size == 0xffffffff;
      if (value.null) continue;
      need(size);
      if (columns_[i].kind == Kind::kInteger || columns_[i].kind == Kind::kReal) {
        if (size != 8) fail_rows();
        const auto number = number_at<std::uint64_t>(bytes, at);
        value.integer = static_cast<std::int64_t>(number);
        value.real = std::bit_cast<double>(number);
      } else {
        value.bytes.assign(bytes.substr(at, size));
      }
      at += size;
    }
    take_(row_);
  }
}

void add_to_digest(std::string& bytes, const std::vector<Column>& columns, const Row& row, std::size_t first) {
  const auto add = [&](char kind, std::uint64_t number) {
    bytes += kind;
    add_number(bytes, number);
  };
  for (std::size_t i = first; i < columns.size(); ++i) {
    const Value& value = row[i];
    const Kind kind = columns[i].kind;
    if (value.null || (kind == Kind::kReal && std::isnan(value.real))) {
      add('n', 0);
    } else if (kind == Kind::kInteger) {
      add('i', static_cast<std::uint64_t>(value.integer));
    } else if (kind == Kind::kReal) {
      add('r', std::bit_cast<std::uint64_t>(value.real == 0.0 ? 0.0 : value.real));
    } else {
      add(static_cast<char>(kind), value.bytes.size());
      bytes += value.bytes;
    }
  }
}

}  // namespace tactbench::db::fleet
