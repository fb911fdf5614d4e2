// Inside Link: the connection and how it waits. Included by the sources of Link alone.
#pragma once

#include <libpq-fe.h>

#include <chrono>
#include <memory>
#include <string>

#include "db/fleet/postgres.h"

namespace tactbench::db::fleet {

// libpq is loaded when it is first asked for: with what it needs (Kerberos, LDAP) it would take longer to load than
// most of the program's other libraries, at each start.
// Formatting it again would change it each time.
// clang-format off
#define TACTBENCH_LIBPQ(X) \
  X(PQclear) X(PQconndefaults) X(PQconnectPoll) X(PQconnectStartParams) X(PQconnectionNeedsPassword) \
  X(PQconninfoFree) X(PQconninfoParse) X(PQconsumeInput) X(PQerrorMessage) X(PQfinish) X(PQflush) \
  X(PQfreemem) X(PQgetCopyData) X(PQgetResult) X(PQgetlength) X(PQgetvalue) X(PQisBusy) X(PQlibVersion) \
  X(PQnfields) X(PQntuples) X(PQputCopyData) X(PQputCopyEnd) X(PQresultErrorField) X(PQresultStatus) \
  X(PQsendQuery) X(PQsendQueryParams) X(PQsetErrorVerbosity) X(PQsetNoticeProcessor) X(PQsetnonblocking) \
  X(PQsocket) X(PQstatus) X(PQuser)
// clang-format on

struct Libpq {
  Libpq();                                                        // TB-FLEET-BUILD when it is not installed
#define TACTBENCH_MEMBER(name) decltype(&::name) name = nullptr;  // NOLINT(bugprone-macro-parentheses)
  TACTBENCH_LIBPQ(TACTBENCH_MEMBER)
#undef TACTBENCH_MEMBER
};
const Libpq& libpq();

using Time = std::chrono::steady_clock;

struct FreeResult {
  void operator()(PGresult* result) const { libpq().PQclear(result); }
};
using Result = std::unique_ptr<PGresult, FreeResult>;

// libpq's messages have several lines.
inline std::string trimmed(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  std::string line;
  for (const char c : text)
    if (c == '\n' || c == '\t')
      line += line.ends_with(' ') ? "" : " ";
    else
      line += c;
  return line;
}

struct Link::State {
  PGconn* handle = nullptr;
  std::string where, user;
  std::chrono::seconds silence = kSilence;

  ~State() {
    if (handle != nullptr) libpq().PQfinish(handle);  // where libpq cannot be loaded there is none, and libpq() throws
  }

  void wait(bool also_write, Time::time_point deadline) const;  // until the socket can be read, or also written
  void take_input() const;
  void flush() const;
  void until_taken(const std::function<int()>& give) const;  // part of a copy, which libpq takes now (1) or later (0)
  void send(const std::string& sql) const;                   // statements without parameters
  [[nodiscard]] Result next() const;                         // of the statement under way; none: it is over
  Result finish(ExecStatusType expected) const;  // its last result; an error of any is thrown after all were read
  [[noreturn]] void fail_link() const;
  [[noreturn]] void fail_text(const std::string& why) const;
  [[noreturn]] void fail(const PGresult* result) const;
};

}  // namespace tactbench::db::fleet
