#include "db/fleet/postgres.h"

#ifdef TACTBENCH_HAVE_LIBPQ

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>

#include "db/fleet/postgres_state.h"

namespace tactbench::db::fleet {

// Waits until the socket can be read, or also written.
void Link::State::wait(bool also_write, Time::time_point deadline) const {
  pollfd socket{libpq().PQsocket(handle), static_cast<short>(POLLIN | (also_write ? POLLOUT : 0)), 0};
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Time::now());
    const int ready = ::poll(&socket, 1, std::max(static_cast<int>(left.count()), 0));
    if (ready > 0) return;
    if (ready < 0 && errno == EINTR) continue;
    throw FleetError(FleetCause::kLink, "TB-FLEET-SILENT",
                     fmt::format("fleet {}: the server has been silent for {} s", where, silence.count()),
                     "see whether it is overloaded or the network broken; then again: what was pushed is kept");
  }
}

void Link::State::take_input() const {
  if (libpq().PQconsumeInput(handle) == 0) fail_link();
}

void Link::State::flush() const {
  while (const int left = libpq().PQflush(handle)) {
    if (left < 0) fail_link();
    wait(true, Time::now() + silence);
    take_input();
  }
}

void Link::State::until_taken(const std::function<int()>& give) const {
  for (;;) {
    const int taken = give();
    if (taken < 0) fail_link();
    if (taken > 0) return;
    flush();
  }
}

void Link::State::send(const std::string& sql) const {
  if (libpq().PQsendQuery(handle, sql.c_str()) != 1) fail_link();
}

Result Link::State::next() const {
  flush();
  while (libpq().PQisBusy(handle) != 0) {
    wait(false, Time::now() + silence);
    take_input();
  }
  return Result(libpq().PQgetResult(handle));
}

void Link::State::fail_link() const {
  throw FleetError(FleetCause::kLink, "TB-FLEET-LOST",
                   fmt::format("fleet {}: the server was lost: {}", where, trimmed(libpq().PQerrorMessage(handle))),
                   "push again when it is back: a run is there whole or not at all");
}

void Link::State::fail_text(const std::string& why) const {
  throw FleetError(FleetCause::kStore, "TB-FLEET-TEXT",
                   fmt::format("fleet {}: a text of the run cannot be kept there: {}", where, why),
                   "the fleet's database has to be of encoding UTF8; a text with a zero byte stays in the store alone");
}

// The last result of a statement; an error of any is thrown after all were read.
Result Link::State::finish(ExecStatusType expected) const {
  Result last, failed;
  while (Result result = next()) {
    const ExecStatusType status = libpq().PQresultStatus(result.get());
    if (status == PGRES_FATAL_ERROR && !failed) failed = std::move(result);
    if (status == PGRES_COPY_IN || status == PGRES_COPY_OUT) return result;
    if (status != PGRES_FATAL_ERROR) last = std::move(result);
  }
  if (failed) fail(failed.get());
  if (!last || (expected != PGRES_COMMAND_OK && libpq().PQresultStatus(last.get()) != expected)) fail(last.get());
  return last;
}

std::vector<TextRow> Link::query(const std::string& sql, const std::vector<std::string>& parameters) {
  std::vector<const char*> values;
  for (const std::string& parameter : parameters) {
    if (parameter.find('\0') != std::string::npos) state_->fail_text("it has a zero byte");
    values.push_back(parameter.c_str());
  }
  if (libpq().PQsendQueryParams(state_->handle, sql.c_str(), static_cast<int>(values.size()), nullptr, values.data(),
                                nullptr, nullptr, 0) != 1)
    state_->fail_link();
  const Result result = state_->finish(PGRES_COMMAND_OK);
  std::vector<TextRow> rows(static_cast<std::size_t>(libpq().PQntuples(result.get())));
  for (int i = 0; i < libpq().PQntuples(result.get()); ++i) {
    for (int j = 0; j < libpq().PQnfields(result.get()); ++j)
      rows[static_cast<std::size_t>(i)].emplace_back(libpq().PQgetvalue(result.get(), i, j),
                                                     static_cast<std::size_t>(libpq().PQgetlength(result.get(), i, j)));
  }
  return rows;
}

void Link::execute(const std::string& script) {
  state_->send(script);
  (void)state_->finish(PGRES_COMMAND_OK);
}

void Link::copy_in(const std::string& sql, const std::function<bool(std::string&)>& more) {
  state_->send(sql);
  if (libpq().PQresultStatus(state_->finish(PGRES_COPY_IN).get()) != PGRES_COPY_IN) state_->fail(nullptr);
  std::string buffer;
  try {
    for (bool going = true; going;) {
      buffer.clear();
      going = more(buffer);
      if (buffer.empty()) continue;
      state_->until_taken(
          [&] { return libpq().PQputCopyData(state_->handle, buffer.data(), static_cast<int>(buffer.size())); });
    }
  } catch (const FleetError&) {
    throw;
  } catch (...) {  // the store could not be read: the server must not take what came so far for all
    while (libpq().PQputCopyEnd(state_->handle, "the store could not be read") == 0) state_->flush();
    while (state_->next()) {
    }
    throw;
  }
  state_->until_taken([&] { return libpq().PQputCopyEnd(state_->handle, nullptr); });
  (void)state_->finish(PGRES_COMMAND_OK);
}

void Link::copy_out(const std::string& sql, const std::function<void(std::string_view)>& take) {
  state_->send(sql);
  if (libpq().PQresultStatus(state_->finish(PGRES_COPY_OUT).get()) != PGRES_COPY_OUT) state_->fail(nullptr);
  struct Piece {
    char* bytes = nullptr;
    ~Piece() { libpq().PQfreemem(bytes); }
  };
  for (;;) {
    Piece piece;
    const int size = libpq().PQgetCopyData(state_->handle, &piece.bytes, 1);
    if (size > 0) {
      take({piece.bytes, static_cast<std::size_t>(size)});
    } else if (size == 0) {
      state_->wait(false, Time::now() + state_->silence);
      state_->take_input();
    } else {
      break;  // its end, or an error, which the result holds
    }
  }
  (void)state_->finish(PGRES_COMMAND_OK);
}

Transaction::Transaction(Link& link, const char* manner) : link_(link) {
  link_.execute(std::string("BEGIN ") + manner);
}
Transaction::~Transaction() {
  try {
    if (open_) link_.execute("ROLLBACK");
  } catch (const FleetError&) {  // with the link the server rolls back
  }
}
void Transaction::commit() {
  open_ = false;
  link_.execute("COMMIT");
}

}  // namespace tactbench::db::fleet

#endif
