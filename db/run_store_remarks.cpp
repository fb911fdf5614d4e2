// People's remarks on a run: tags, notes, void.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "db/run_store_database.h"
#include "db/utf8.h"

namespace tactbench::db {

namespace {

void check_tag(const std::string& tag) {
  const auto fits = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("._:/+-=").find(c) != std::string_view::npos;
  };
  const std::size_t equals = tag.find('=');  // of KEY=VALUE: one, with something on both sides
  const bool pair = equals == std::string::npos || (equals > 0 && equals + 1 < tag.size() && tag.rfind('=') == equals);
  if (!tag.empty() && tag.size() <= 64 && pair && std::ranges::all_of(tag, fits)) return;
  throw StoreError(
      "TB-STORE-TAG", fmt::format("'{}' is not a valid tag", tag),
      "a tag is one word of up to 64 letters, digits and . _ : / + -, or two with = between them (lot=A7); "
      "longer words go into a note");
}

}  // namespace

void check_words(const std::string& what, const std::string& text, std::size_t longest) {
  std::size_t characters = 0;
  for (std::string_view rest = text; !rest.empty(); ++characters) {
    const CodePoint c = decode_utf8(rest);
    if (!c.valid)
      throw StoreError("TB-STORE-NOT-TEXT", fmt::format("{} is not UTF-8", what), "type it again; nothing was stored");
    rest.remove_prefix(c.bytes);
  }
  if (characters <= longest) return;
  throw StoreError("TB-STORE-TOO-LONG",
                   fmt::format("{} has {} characters, at most {} are allowed", what, characters, longest),
                   "shorten it; nothing was stored");
}

void check_said(const std::string& what, const std::string& text, std::size_t longest) {
  check_words(what, text, longest);
  if (!is_blank(text)) return;
  throw StoreError("TB-STORE-BLANK", fmt::format("{} is empty or blank", what),
                   "write what is to stand there; nothing was stored");
}

void RunStore::set_tags(std::int64_t run, const std::vector<std::string>& add, const std::vector<std::string>& remove) {
  for (const std::string& tag : add) check_tag(tag);
  for (const std::string& tag : remove) check_tag(tag);
  sqlite::Transaction transaction(database_->connection);
  const std::vector<std::string> before = database_->run(run).tags;
  std::set<std::string> tags(before.begin(), before.end());
  for (const std::string& tag : add) {
    if (const std::size_t equals = tag.find('='); equals != std::string::npos)  // a key has one value
      std::erase_if(tags, [&](const std::string& old) { return old.starts_with(tag.substr(0, equals + 1)); });
    tags.insert(tag);
  }
  for (const std::string& tag : remove) tags.erase(tag);
  if (tags.size() > kMostTags) {
    throw StoreError("TB-STORE-TAG",
                     fmt::format("run {} would have {} tags, at most {} are allowed", run, tags.size(), kMostTags),
                     "remove some with --remove");
  }
  sqlite::Statement(database_->connection, "UPDATE runs SET tags = ? WHERE run = ?")
      .bind(fmt::format("{}", fmt::join(tags, " ")), run)
      .run();
  transaction.commit();
}

void RunStore::add_note(std::int64_t run, const std::string& text) {
  check_said("the note", text, kLongestText);
  sqlite::Transaction transaction(database_->connection);
  database_->require_run(run);
  sqlite::Statement(database_->connection,
                    "UPDATE runs SET notes = CASE notes WHEN '' THEN '' ELSE notes || char(10) END || ? WHERE run = ?")
      .bind(text, run)
      .run();
  transaction.commit();
}

void RunStore::void_run(std::int64_t run, const std::string& reason, const std::string& by, const std::string& utc) {
  const auto refuse = [&](const std::string& what, const std::string& remedy) {
    throw StoreError("TB-STORE-CONFLICT", fmt::format("store {}: run {} {}", path(), run, what), remedy);
  };
  check_said("the reason", reason, kLongestText);
  check_said("the name of the person who voids it", by, kLongestName);
  sqlite::Transaction transaction(database_->connection);
  const RunRecord record = database_->run(run);
  if (record.outcome == Outcome::kIncomplete) refuse("has not ended", "wait for its end, or stop it");
  if (record.is_void()) {
    refuse(fmt::format("is void already, by {} ({})", record.void_by, record.void_reason),
           "write additions into a note");
  }
  if (utc.empty()) refuse("is not made void without a date", "this is a defect of the caller: please report it");
  sqlite::Statement(database_->connection, "UPDATE runs SET void_reason = ?, void_by = ?, void_utc = ? WHERE run = ?")
      .bind(reason, by, utc, run)
      .run();
  seal(run, "void");
  transaction.commit();
}

}  // namespace tactbench::db
