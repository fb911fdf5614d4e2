// A thin wrapper over SQLite: one connection, prepared statements, transactions. Every failure becomes a StoreError
// that names the file and a remedy. Only sqlite.cpp includes sqlite3.h.
#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

struct sqlite3;
struct sqlite3_stmt;

namespace tactbench::db::sqlite {

// Blobs are stored as they are in memory, and the file's format is little-endian.
static_assert(std::endian::native == std::endian::little, "blobs need swapping on this host");

enum class Access {
  kReadWrite,
  kReadOnly,
  kImmutable,  // for a folder without write access: takes no locks, makes no -wal and -shm
};

inline constexpr int kBusyTimeoutMs = 5000;

// Greatest length of a text or blob in a store, checked before memory is allocated, so also in a damaged file.
inline constexpr int kMaxValueBytes = 256 << 20;

class Connection {
 public:
  Connection(const std::string& path, Access access, int busy_timeout_ms = kBusyTimeoutMs);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // For a store: no trigger fires and no view is read, since the program needs none; values are of bounded length.
  void disable_triggers_and_views();
  void execute(const std::string& sql);                        // one or more statements; result rows are discarded
  [[nodiscard]] std::int64_t integer(const std::string& sql);  // first column of the one row
  [[nodiscard]] std::string text(const std::string& sql);
  void wait_for_locks(int at_most_ms);
  // Copies the present state of the database into that of `target`, page by page; others may write meanwhile.
  void copy_to(Connection& target) const;
  [[nodiscard]] std::int64_t last_row() const;
  [[nodiscard]] std::int64_t changes() const;  // rows that the last statement inserted, updated or deleted
  [[nodiscard]] bool in_transaction() const;
  [[nodiscard]] bool is_read_only() const;  // also true when a file opened for writing could only be read
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] sqlite3* handle() const { return handle_; }
  // TB-STORE-GONE when the file at the path is not the open one, or has lost its end: removed, moved, replaced or cut
  // off, while SQLite continues to write.
  void require_in_place() const;
  [[noreturn]] void fail(int code, const std::string& doing) const;

 private:
  friend class Transaction;
  [[nodiscard]] bool is_cut() const;
  std::string path_;
  sqlite3* handle_ = nullptr;
  mutable bool gone_reported_ = false;
  mutable std::int64_t longest_ = 0;  // bytes
};

// "?, ?, ?": a parameter for each of the columns; that of `nullable` is stored as NULL where it is 0 or "".
std::string parameters(const std::string& columns, std::string_view nullable = {});
// "INSERT INTO table (columns) VALUES (parameters)".
std::string insert_into(const std::string& table, const std::string& columns, std::string_view nullable = {});

// Values go in with bind(...) and come out with read(...), in the order of the SQL text; a tuple of references stands
// for its values. Vectors and arrays of numbers are blobs. A double that is not a number is NULL in the file and comes
// back as NaN.
class Statement {
 public:
  Statement(Connection& connection, std::string_view sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  // Blobs are not copied: they must live until run() or the last step().
  template <class... Values>
  Statement& bind(const Values&... values) {
    int index = 0;
    (put(index, values), ...);
    return *this;
  }
  [[nodiscard]] bool step();  // true: a row is available
  void run();                 // executes to the end; then ready to be bound again
  void reset();               // ready to be bound again
  template <class... Values>
  void read(Values&&... values) const {
    read_from(0, values...);
  }
  template <class Value>
  [[nodiscard]] Value value(int column = 0) const {
    Value value{};
    read_from(column, value);
    return value;
  }
  // The first value of the first row; none if the query returns no row.
  template <class Value>
  [[nodiscard]] std::optional<Value> first() {
    return step() ? std::optional(value<Value>()) : std::nullopt;
  }
  [[nodiscard]] bool is_null(int column) const;
  template <class... Values>
  void read_from(int column, Values&&... values) const {
    (get(column, values), ...);
  }

 private:
  // The next parameter or column.
  template <class T>
  void put(int& index, const T& value) {
    if constexpr (std::integral<T>) {
      put_integer(++index, static_cast<std::int64_t>(value));
    } else if constexpr (std::floating_point<T>) {
      put_real(++index, value);
    } else if constexpr (std::convertible_to<T, std::string_view>) {
      put_text(++index, value);
    } else {
      put_blob(++index, std::as_bytes(std::span(value)));
    }
  }
  template <class T>
  void put(int& index, const std::optional<T>& value) {
    value ? put(index, *value) : void(++index);  // an unbound parameter is NULL
  }
  template <class... Values>
  void put(int& index, const std::tuple<Values&...>& row) {
    std::apply([&](const auto&... values) { (put(index, values), ...); }, row);
  }
  template <class T>
  void get(int& column, T& value) const {
    if constexpr (std::same_as<T, bool>) {
      value = get_integer(column++) != 0;
    } else if constexpr (std::integral<T>) {
      value = static_cast<T>(get_integer(column++));
    } else if constexpr (std::floating_point<T>) {
      value = get_real(column++);
    } else {
      value = get_text(column++);
    }
  }
  template <class T>
  void get(int& column, std::optional<T>& value) const {
    value.reset();
    is_null(column) ? void(++column) : get(column, value.emplace());
  }
  template <class T>
  void get(int& column, std::vector<T>& value) const {
    value.resize(blob_size(column) / sizeof(T));
    get_blob(column++, std::as_writable_bytes(std::span(value)));
  }
  template <class T, std::size_t N>
  void get(int& column, std::array<T, N>& value) const {
    get_blob(column++, std::as_writable_bytes(std::span(value)));
  }
  template <class... Values>
  void get(int& column, std::tuple<Values&...>& row) const {
    std::apply([&](auto&... values) { (get(column, values), ...); }, row);
  }
  void put_integer(int index, std::int64_t value);
  void put_real(int index, double value);
  void put_text(int index, std::string_view value);
  void put_blob(int index, std::span<const std::byte> value);
  [[nodiscard]] std::int64_t get_integer(int column) const;
  [[nodiscard]] double get_real(int column) const;
  [[nodiscard]] std::string get_text(int column) const;
  [[nodiscard]] std::size_t blob_size(int column) const;
  void get_blob(int column, std::span<std::byte> value) const;

  Connection& connection_;
  sqlite3_stmt* handle_ = nullptr;
};

// "SELECT columns FROM rest", as records of this kind (db/record.h).
template <class Record, class... Values>
std::vector<Record> read_all(Connection& connection, const std::string& rest, const Values&... values) {
  Statement rows(connection, std::string("SELECT ") + Record::kColumns + " FROM " + rest);
  rows.bind(values...);
  std::vector<Record> records;
  while (rows.step()) rows.read(records.emplace_back().row());
  return records;
}

// Takes the write lock at once; rolls back unless committed. Refused when the file is not in its place, unless that
// was reported before: a run may still write its last rows before the store is saved (RunStore::rescue).
class Transaction {
 public:
  explicit Transaction(Connection& connection);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  Connection& connection_;
};

}  // namespace tactbench::db::sqlite
