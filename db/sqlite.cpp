#include "db/sqlite.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <limits>
#include <new>
#include <sstream>

#include "db/store_error.h"
#include "db/store_file.h"

namespace tactbench::db::sqlite {

namespace {

// Path as a URI, with each character in percent form.
std::string immutable_uri(const std::string& path) {
  std::string uri = "file:";
  for (const char c : path) uri += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  return uri + "?immutable=1";
}

// The operating system's error number of a failed read or write, kept with the open file of log or database, because
// that of sqlite3_system_errno is lost when the statement ends.
int error_of_files(sqlite3* handle) {
  sqlite3_file* log = nullptr;  // in WAL mode this is the log
  int number = 0;
  if (sqlite3_file_control(handle, "main", SQLITE_FCNTL_JOURNAL_POINTER, &log) == SQLITE_OK && log != nullptr &&
      log->pMethods != nullptr) {
    log->pMethods->xFileControl(log, SQLITE_FCNTL_LAST_ERRNO, &number);
  }
  if (number == 0) sqlite3_file_control(handle, "main", SQLITE_FCNTL_LAST_ERRNO, &number);
  return number;
}

struct Meaning {
  const char* id;
  const char* what;
  const char* remedy;
};

Meaning meaning_of(int code, int system_error) {
  constexpr Meaning kFull{"TB-STORE-FULL", "there is no room left",
                          "free space on the disk of the store; all data that was acknowledged is kept"};
  // The operating system's "full" is not always SQLITE_FULL: quota, a limit on file size, no room for the -shm file.
  if (system_error == ENOSPC || system_error == EDQUOT || system_error == EFBIG) return kFull;
  if (code == SQLITE_READONLY_ROLLBACK)
    return {"TB-STORE-OPEN",
            "the program was killed while it made or migrated this store, so that work is incomplete in the file",
            "open it once for writing, which undoes the incomplete work: repeat the command, or tactbench db migrate "
            "--db FILE"};
  switch (code & 0xff) {
    case SQLITE_FULL:
      return kFull;
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {"TB-STORE-LOCKED", "another process", "let it end, or close its database browser, and try again"};
    case SQLITE_NOTADB:
      return {"TB-STORE-OPEN", "this is not a store of tactbench", "name another file with --db"};
    case SQLITE_CORRUPT:
      return {"TB-STORE-OPEN", "the file is damaged",
              "keep a copy, restore your last snapshot, and check the disk; sqlite3's .recover may save the rest"};
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_AUTH:
      return {"TB-STORE-OPEN", "the file or its folder may not be written by this user",
              "check owner and permissions of the file and of its folder (WAL makes files next to it)"};
    case SQLITE_CANTOPEN:
      return {"TB-STORE-OPEN", "the file cannot be opened", "check path, owner and permissions of file and folder"};
    case SQLITE_TOOBIG:
      return {
          "TB-STORE-TOO-LARGE", "a text or blob is larger than a store accepts",
          "store less in one piece; if the text came from the store, the file is damaged: restore your last snapshot"};
    case SQLITE_CONSTRAINT:
      return {"TB-STORE-CONFLICT", "the row contradicts what is stored", "check the values named"};
    default:
      return {"TB-STORE-SQL", "the database library reports an error",
              "check the disk; if it is sound, please report this"};
  }
}

}  // namespace

Connection::Connection(const std::string& path, Access access, int busy_timeout_ms) : path_(path) {
  int flags = SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE;
  flags |= access == Access::kReadWrite ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE : SQLITE_OPEN_READONLY;
  if (access == Access::kImmutable) flags |= SQLITE_OPEN_URI;
  const std::string name = access == Access::kImmutable ? immutable_uri(path) : path;
  const int code = sqlite3_open_v2(name.c_str(), &handle_, flags, nullptr);
  try {
    if (code != SQLITE_OK) fail(code, "open");
    sqlite3_busy_timeout(handle_, busy_timeout_ms);
    sqlite3_db_config(handle_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(handle_, SQLITE_DBCONFIG_DQS_DML, 0, nullptr);
    execute("PRAGMA foreign_keys = ON; PRAGMA trusted_schema = OFF");
  } catch (...) {
    sqlite3_close_v2(handle_);
    throw;
  }
}

Connection::~Connection() { sqlite3_close_v2(handle_); }

void Connection::fail(int code, const std::string& doing) const {
  const bool own_message = handle_ != nullptr && (sqlite3_errcode(handle_) & 0xff) == (code & 0xff);
  std::string detail = own_message ? sqlite3_errmsg(handle_) : sqlite3_errstr(code);
  // These numbers may be from an earlier call: they belong to this one only if a file failed.
  const int base = code & 0xff;
  if (base == SQLITE_NOMEM) throw std::bad_alloc();
  int system_error = 0;
  if (handle_ != nullptr && (base == SQLITE_IOERR || base == SQLITE_CANTOPEN)) {
    system_error = sqlite3_system_errno(handle_);
    if (system_error == 0) system_error = error_of_files(handle_);
  }
  if (system_error != 0) detail += fmt::format("; {}", std::strerror(system_error));
  if (handle_ != nullptr) require_in_place();  // then this failure comes from it
  const Meaning meaning = meaning_of(code, system_error);
  if (base == SQLITE_BUSY || base == SQLITE_LOCKED) {
    const std::string holder = writer_of(path_);
    throw StoreError(meaning.id,
                     fmt::format("store {}: {} is writing to it and did not finish in time (SQLite code {})", path_,
                                 holder.empty() ? meaning.what : holder, code),
                     meaning.remedy);
  }
  throw StoreError(meaning.id,
                   fmt::format("store {}: {} ({}, SQLite code {}; {})", path_, meaning.what, detail, code, doing),
                   meaning.remedy);
}

void Connection::wait_for_locks(int at_most_ms) { sqlite3_busy_timeout(handle_, at_most_ms); }

// Shorter than it was, and than the pages that its head counts; after a VACUUM the head counts fewer. Read by SQLite's
// own descriptor: to close another one of the file would drop its locks.
bool Connection::is_cut() const {
  sqlite3_file* file = nullptr;
  sqlite3_int64 size = 0;
  if (sqlite3_file_control(handle_, "main", SQLITE_FCNTL_FILE_POINTER, &file) != SQLITE_OK ||
      file->pMethods == nullptr || file->pMethods->xFileSize(file, &size) != SQLITE_OK)
    return false;
  if (size < longest_) {
    std::array<unsigned char, 32> head{};  // 16: size of a page, 28: pages
    if (file->pMethods->xRead(file, head.data(), head.size(), 0) != SQLITE_OK) return true;
    const std::int64_t page = head[16] << 8 | head[17];
    std::int64_t pages = 0;
    for (int i = 28; i < 32; ++i) pages = pages << 8 | head[static_cast<std::size_t>(i)];
    if (size < page * pages) return true;
  }
  longest_ = size;
  return false;
}

void Connection::require_in_place() const {
  int moved = 0;
  if ((sqlite3_file_control(handle_, "main", SQLITE_FCNTL_HAS_MOVED, &moved) != SQLITE_OK || moved == 0) && !is_cut())
    return;
  gone_reported_ = true;
  throw StoreError("TB-STORE-GONE",
                   fmt::format("store {}: the file was removed, moved, replaced or cut off while it was open", path_),
                   "do not touch a store while a program writes to it; put it back, and repeat the command");
}

void Connection::disable_triggers_and_views() {
  for (const int option : {SQLITE_DBCONFIG_ENABLE_TRIGGER, SQLITE_DBCONFIG_ENABLE_VIEW}) {
    int enabled = 1;
    const int code = sqlite3_db_config(handle_, option, 0, &enabled);
    if (code != SQLITE_OK || enabled != 0) fail(SQLITE_MISUSE, "switch off triggers and views");
  }
  sqlite3_limit(handle_, SQLITE_LIMIT_LENGTH, kMaxValueBytes);
}

void Connection::execute(const std::string& sql) {
  const int code = sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) fail(code, sql.substr(0, 80));
}

std::int64_t Connection::integer(const std::string& sql) {
  Statement statement(*this, sql);
  if (!statement.step()) fail(SQLITE_DONE, sql);
  return statement.value<std::int64_t>();
}

std::string Connection::text(const std::string& sql) {
  Statement statement(*this, sql);
  if (!statement.step()) fail(SQLITE_DONE, sql);
  return statement.value<std::string>();
}

void Connection::copy_to(Connection& target) const {
  sqlite3_backup* backup = sqlite3_backup_init(target.handle(), "main", handle_, "main");
  if (backup == nullptr) target.fail(sqlite3_extended_errcode(target.handle()), "begin a copy");
  const int code = sqlite3_backup_step(backup, -1);  // all pages under one read transaction
  sqlite3_backup_finish(backup);
  if (code != SQLITE_DONE) target.fail(code, fmt::format("copy of {}", path_));
}

std::int64_t Connection::last_row() const { return sqlite3_last_insert_rowid(handle_); }
std::int64_t Connection::changes() const { return sqlite3_changes64(handle_); }
bool Connection::in_transaction() const { return sqlite3_get_autocommit(handle_) == 0; }
bool Connection::is_read_only() const { return sqlite3_db_readonly(handle_, "main") == 1; }

std::string parameters(const std::string& columns, std::string_view nullable) {
  std::string list;
  std::istringstream names(columns);
  for (std::string name; std::getline(names >> std::ws, name, ',');)
    list += fmt::format("{}{}", list.empty() ? "" : ", ", name == nullable ? "nullif(nullif(?, 0), '')" : "?");
  return list;
}

std::string insert_into(const std::string& table, const std::string& columns, std::string_view nullable) {
  return fmt::format("INSERT INTO {} ({}) VALUES ({})", table, columns, parameters(columns, nullable));
}

Statement::Statement(Connection& connection, std::string_view sql) : connection_(connection) {
  const int code = sqlite3_prepare_v2(connection.handle(), sql.data(), static_cast<int>(sql.size()), &handle_, nullptr);
  if (code != SQLITE_OK) connection.fail(code, std::string(sql.substr(0, 80)));
}

Statement::~Statement() { sqlite3_finalize(handle_); }

bool Statement::step() {
  const int code = sqlite3_step(handle_);
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  try {
    connection_.fail(code, std::string(sqlite3_sql(handle_)).substr(0, 80));
  } catch (...) {
    sqlite3_reset(handle_);
    sqlite3_clear_bindings(handle_);
    throw;
  }
}

void Statement::run() {
  while (step()) {
  }
  reset();
}

void Statement::reset() {
  sqlite3_reset(handle_);
  sqlite3_clear_bindings(handle_);
}

void Statement::put_integer(int index, std::int64_t value) { sqlite3_bind_int64(handle_, index, value); }
void Statement::put_real(int index, double value) { sqlite3_bind_double(handle_, index, value); }

void Statement::put_text(int index, std::string_view value) {
  const char* data = value.data() != nullptr ? value.data() : "";
  const int code = sqlite3_bind_text64(handle_, index, data, value.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
  if (code != SQLITE_OK) connection_.fail(code, "bind text");
}

void Statement::put_blob(int index, std::span<const std::byte> value) {
  // A null pointer would be stored as NULL; an empty blob is not NULL.
  const int code = value.empty() ? sqlite3_bind_zeroblob(handle_, index, 0)
                                 : sqlite3_bind_blob64(handle_, index, value.data(), value.size(), SQLITE_STATIC);
  if (code != SQLITE_OK) connection_.fail(code, "bind blob");
}

bool Statement::is_null(int column) const { return sqlite3_column_type(handle_, column) == SQLITE_NULL; }

std::int64_t Statement::get_integer(int column) const { return sqlite3_column_int64(handle_, column); }

double Statement::get_real(int column) const {
  if (sqlite3_column_type(handle_, column) == SQLITE_NULL) return std::numeric_limits<double>::quiet_NaN();
  return sqlite3_column_double(handle_, column);
}

std::string Statement::get_text(int column) const {
  const void* data = sqlite3_column_blob(handle_, column);
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(handle_, column));
  return data != nullptr ? std::string(static_cast<const char*>(data), size) : std::string();
}

std::size_t Statement::blob_size(int column) const {
  return static_cast<std::size_t>(sqlite3_column_bytes(handle_, column));
}

void Statement::get_blob(int column, std::span<std::byte> value) const {
  const void* data = sqlite3_column_blob(handle_, column);
  const std::size_t size = std::min(value.size(), blob_size(column));
  if (data != nullptr && size > 0) std::memcpy(value.data(), data, size);
}

Transaction::Transaction(Connection& connection) : connection_(connection) {
  // SQLite itself would report this only at the first row that changes.
  if (connection_.is_read_only()) connection_.fail(SQLITE_READONLY, "BEGIN IMMEDIATE");
  if (!connection_.gone_reported_) connection_.require_in_place();
  connection_.execute("BEGIN IMMEDIATE");
}

Transaction::~Transaction() {
  // A failure may have rolled back already; on a failed disk the log remains, and the next open discards it.
  if (connection_.in_transaction()) sqlite3_exec(connection_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void Transaction::commit() { connection_.execute("COMMIT"); }

}  // namespace tactbench::db::sqlite
