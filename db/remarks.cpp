#include "db/remarks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <set>
#include <string_view>
#include <utility>

#include "db/database.h"
#include "db/run_reader.h"
#include "db/store_error.h"

namespace tactbench::db {

CodePoint decode_utf8(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(text[i])); };
  const std::uint32_t lead = byte(0);
  if (lead < 0x80) return {lead, 1, true};
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < length) return {};
  std::uint32_t value = lead & (0x7Fu >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0u) != 0x80u) return {};
    value = (value << 6) | (byte(i) & 0x3Fu);
  }
  const bool overlong = (length == 3 && value < 0x800) || (length == 4 && value < 0x10000);
  if (overlong || (value >= 0xD800 && value <= 0xDFFF) || value > 0x10FFFF) return {};
  return {value, length, true};
}

bool is_blank(std::string_view text) {
  using Span = std::pair<std::uint32_t, std::uint32_t>;
  // Unicode 15: White_Space, and those of Default_Ignorable_Code_Point that occur in people's texts.
  constexpr std::array kBlank{Span(0x09, 0x0D),     Span(0x20, 0x20),     Span(0x85, 0x85),     Span(0xA0, 0xA0),
                              Span(0xAD, 0xAD),     Span(0x061C, 0x061C), Span(0x115F, 0x1160), Span(0x1680, 0x1680),
                              Span(0x180E, 0x180E), Span(0x2000, 0x200F), Span(0x2028, 0x202F), Span(0x205F, 0x206F),
                              Span(0x3000, 0x3000), Span(0x3164, 0x3164), Span(0xFE00, 0xFE0F), Span(0xFEFF, 0xFEFF)};
  while (!text.empty()) {
    const CodePoint c = decode_utf8(text);
    const auto holds = [&](const Span& span) { return c.value >= span.first && c.value <= span.second; };
    if (!c.valid || std::ranges::none_of(kBlank, holds)) return false;
    text.remove_prefix(c.bytes);
  }
  return true;
}

void check_text(const std::string& what, const std::string& text, std::size_t longest) {
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

void check_nonblank_text(const std::string& what, const std::string& text, std::size_t longest) {
  check_text(what, text, longest);
  if (!is_blank(text)) return;
  throw StoreError("TB-STORE-BLANK", fmt::format("{} is empty or blank", what), "give the text; nothing was stored");
}

namespace {

void check_tag(const std::string& tag) {
  const auto fits = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("._:/+-=").find(c) != std::string_view::npos;
  };
  const std::size_t equals = tag.find('=');  // of KEY=VALUE: one, with something on both sides
  const bool pair = equals == std::string::npos || (equals > 0 && equals + 1 < tag.size() && tag.rfind('=') == equals);
  if (!tag.empty() && tag.size() <= 64 && pair && std::ranges::all_of(tag, fits)) return;
  throw StoreError("TB-STORE-TAG", fmt::format("'{}' is not a valid tag", tag),
                   "a tag is one word of up to 64 letters, digits and . _ : / + -, or two joined by = (lot=A7); "
                   "longer words go into a note");
}

}  // namespace

void Remarks::set_tags(std::int64_t run, const std::vector<std::string>& add, const std::vector<std::string>& remove) {
  for (const std::string& tag : add) check_tag(tag);
  for (const std::string& tag : remove) check_tag(tag);
  sqlite::Transaction transaction(database_->connection);
  const std::vector<std::string> before = RunReader(*database_).run(run).tags;
  std::set<std::string> tags(before.begin(), before.end());
  for (const std::string& tag : add) {
    if (const std::size_t equals = tag.find('='); equals != std::string::npos)  // a key has one value
      std::erase_if(tags, [&](const std::string& old) { return old.starts_with(tag.substr(0, equals + 1)); });
    tags.insert(tag);
  }
  for (const std::string& tag : remove) tags.erase(tag);
  if (tags.size() > kMaxTags) {
    throw StoreError("TB-STORE-TAG",
                     fmt::format("run {} would have {} tags, at most {} are allowed", run, tags.size(), kMaxTags),
                     "remove some with --remove");
  }
  sqlite::Statement(database_->connection, "UPDATE runs SET tags = ? WHERE run = ?")
      .bind(fmt::format("{}", fmt::join(tags, " ")), run)
      .run();
  transaction.commit();
}

void Remarks::add_note(std::int64_t run, const std::string& text) {
  check_nonblank_text("the note", text, kMaxTextLength);
  sqlite::Transaction transaction(database_->connection);
  database_->require_run(run);
  sqlite::Statement(database_->connection,
                    "UPDATE runs SET notes = CASE notes WHEN '' THEN '' ELSE notes || char(10) END || ? WHERE run = ?")
      .bind(text, run)
      .run();
  transaction.commit();
}

void Remarks::void_run(std::int64_t run, const std::string& reason, const std::string& by, const std::string& utc) {
  const auto refuse = [&](const std::string& what, const std::string& remedy) {
    throw StoreError("TB-STORE-CONFLICT", fmt::format("store {}: run {} {}", database_->path, run, what), remedy);
  };
  check_nonblank_text("the reason", reason, kMaxTextLength);
  check_nonblank_text("the name of the person who voids it", by, kMaxNameLength);
  sqlite::Transaction transaction(database_->connection);
  const RunRecord record = RunReader(*database_).run(run);
  if (record.outcome == Outcome::kIncomplete) refuse("has not ended", "wait for its end, or stop it");
  if (record.is_void()) {
    refuse(fmt::format("is void already, by {} ({})", record.void_by, record.void_reason),
           "write additions into a note");
  }
  if (utc.empty()) refuse("is not made void without a date", "this is a defect of the caller: please report it");
  sqlite::Statement(database_->connection, "UPDATE runs SET void_reason = ?, void_by = ?, void_utc = ? WHERE run = ?")
      .bind(reason, by, utc, run)
      .run();
  database_->seal(run, "void");
  transaction.commit();
}

}  // namespace tactbench::db
