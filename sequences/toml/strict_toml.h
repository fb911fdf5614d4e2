// A strict TOML reader: every key must be read, every value must have its type, and each error names file, line, column
// and the nearest known key. Recipes, bench, sensor and limits files are all read with it.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace tactbench::sequences {

// The error type of sequences/: a file that cannot be used. id: TB-FILE-MISSING, TB-FILE-SYNTAX, TB-FILE-KEY,
// TB-FILE-VALUE.
class FileError : public std::runtime_error {
 public:
  // A NUL in the message is shown as \x00, because what() would end at it.
  FileError(std::string id, const std::string& message, std::string where, std::string remedy)
      : std::runtime_error(shown(message)), id_(std::move(id)), where_(std::move(where)), remedy_(std::move(remedy)) {}
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const std::string& where() const { return where_; }  // file:line:column [table] key
  [[nodiscard]] const std::string& remedy() const { return remedy_; }

 private:
  static std::string shown(std::string message);
  std::string id_, where_, remedy_;
};

struct Override {          // --set key=value
  std::string key;         // dotted
  std::string value;       // a TOML value; a bare word counts as a string
  std::string typed = {};  // the text as typed, if it had another unit: "9bar"
};

struct Setting {       // a key read, with its value
  std::string key;     // dotted, list elements as sensor[0]
  std::string value;   // as TOML
  std::string origin;  // "file:line", "--set", or "default"
};

class TomlTable;
struct KeyFacts;  // key_table.h

class TomlDocument {
 public:
  // A regular file of at most 16 MB. Throws FileError TB-FILE-MISSING, TB-FILE-SYNTAX.
  static TomlDocument from_file(const std::string& path);
  static TomlDocument from_text(const std::string& text, const std::string& name);
  // Replaces or adds a value before reading; errors in it name the key as typed, after `prefix`. Throws FileError
  // TB-FILE-VALUE.
  void set(const Override& override_value, const std::string& prefix = {});
  void remove(const std::string& key);  // of the root; an absent key is not an error
  // From now on the text "$name" means `value` wherever a number is read.
  void define(const std::string& name, double value);
  [[nodiscard]] bool uses(const std::string& name) const;  // whether "$name" was read
  [[nodiscard]] TomlTable root() const;
  [[nodiscard]] std::string to_text() const;  // the document as TOML, with values set and removed; without comments
  [[nodiscard]] const std::string& text() const { return text_; }  // the text as read, without overrides
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::vector<Setting>& settings() const;  // all keys read so far, in the order of reading

 private:
  struct Node;
  friend class TomlTable;
  std::string text_, name_;
  std::shared_ptr<Node> node_;
};

// A table being read. Reading a key marks it known; finish() refuses the keys that were not read. If a key's name ends
// with _psi, its numbers may be texts with a unit, "100 kPa" (pressure_text.h).
class TomlTable {
 public:
  [[nodiscard]] bool has(const std::string& key) const;
  [[nodiscard]] std::vector<std::string> keys() const;  // does not mark them known
  // Without a fallback the key is required. All throw FileError with the place.
  [[nodiscard]] double number(const std::string& key) const;
  [[nodiscard]] double number(const std::string& key, double fallback) const;
  // Like number(), but refuses values outside low..high (both allowed). Without a fallback the key is required.
  [[nodiscard]] double number_in(const std::string& key, std::optional<double> fallback, double low, double high) const;
  // Like number_in(), but accepts 0 (none), too.
  [[nodiscard]] double zero_or_in(const std::string& key, std::optional<double> fallback, double low,
                                  double high) const;
  // Refuses a value of `key` outside low..high, as number_in() does: for limits that depend on other keys.
  void check_range(const std::string& key, double value, double low, double high) const;
  [[nodiscard]] long integer(const std::string& key, long low, long high) const;
  [[nodiscard]] long integer(const std::string& key, long fallback, long low, long high) const;
  [[nodiscard]] bool boolean(const std::string& key, bool fallback) const;
  [[nodiscard]] std::string text(const std::string& key) const;
  [[nodiscard]] std::string text(const std::string& key, const std::string& fallback) const;
  // A text that names something: neither empty nor blank.
  [[nodiscard]] std::string name(const std::string& key) const;
  // A text, or TOML's own date as "2026-01-31"; empty if absent.
  [[nodiscard]] std::string date_text(const std::string& key) const;
  [[nodiscard]] std::vector<std::string> texts(const std::string& key) const;  // an absent list reads as an empty one
  // One of `words`.
  [[nodiscard]] std::string word(const std::string& key, const std::vector<std::string>& words) const;
  [[nodiscard]] std::string word(const std::string& key, const std::string& fallback,
                                 const std::vector<std::string>& words) const;
  [[nodiscard]] std::vector<double> numbers(const std::string& key) const;
  [[nodiscard]] std::vector<double> numbers_or_one(const std::string& key, double fallback) const;
  // [[1, 2], [3, 4]]: at least one list, each of `size` numbers.
  [[nodiscard]] std::vector<std::vector<double>> number_lists(const std::string& key, std::size_t size) const;
  // Two numbers [low, high], low < high.
  [[nodiscard]] std::pair<double, double> span(const std::string& key, std::pair<double, double> fallback) const;
  [[nodiscard]] TomlTable table(const std::string& key) const;  // an absent table reads as an empty one
  [[nodiscard]] std::vector<TomlTable> tables(const std::string& key) const;
  void finish() const;
  // Throws FileError for `key`: the message, then the key's place in the file.
  [[noreturn]] void fail(const std::string& key, const std::string& message, const std::string& remedy) const;

 private:
  friend class TomlDocument;
  struct View;
  explicit TomlTable(std::shared_ptr<View> view) : view_(std::move(view)) {}
  std::shared_ptr<View> view_;
};

// The word of `known` closest to `word` by edit distance, empty when none is near.
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);

}  // namespace tactbench::sequences
