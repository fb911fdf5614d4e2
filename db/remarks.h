// Texts that people enter (UTF-8, of bounded length), and their remarks on a run: tags, notes, void.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tactbench::db {

class Database;

struct CodePoint {
  std::uint32_t value = 0;
  std::size_t bytes = 1;
  bool valid = false;  // false: one byte that starts no sequence
};
// The first sequence of the non-empty `text` (RFC 3629: no overlong forms, no surrogates, at most U+10FFFF).
CodePoint decode_utf8(std::string_view text);
// True if there is no visible character: only blanks of any kind, zero-width marks or line ends, or an empty text.
bool is_blank(std::string_view text);

// Greatest lengths, in characters. Longer texts and texts that are not UTF-8 are refused before anything is stored
// (TB-STORE-TOO-LONG, TB-STORE-NOT-TEXT), and so are names, notes and reasons without a visible character
// (TB-STORE-BLANK).
inline constexpr std::size_t kMaxNameLength = 200;    // names, serials, also those that instruments report
inline constexpr std::size_t kMaxTextLength = 10000;  // purposes, notes, reasons
inline constexpr std::size_t kMaxTags = 100;
void check_text(const std::string& what, const std::string& text, std::size_t longest);
void check_nonblank_text(const std::string& what, const std::string& text,
                         std::size_t longest);  // also refuses a blank text

// Part of a RunStore. Remarks are not part of the canonical content. All except void_run are possible in any state of
// the run.
class Remarks {
 public:
  explicit Remarks(Database& database) : database_(&database) {}

  // A tag is one word of letters, digits and . _ : / + -; adding one twice or removing an absent one is not an error.
  // TB-STORE-TAG for an invalid tag.
  void set_tags(std::int64_t run, const std::vector<std::string>& add, const std::vector<std::string>& remove);
  void add_note(std::int64_t run, const std::string& text);  // appends a line
  // Declares the run void, permanently; its rows stay. TB-STORE-BLANK without reason or name, TB-STORE-CONFLICT
  // without date, or if the run has not ended or is already void.
  void void_run(std::int64_t run, const std::string& reason, const std::string& by, const std::string& utc);

 private:
  Database* database_;
};

}  // namespace tactbench::db
