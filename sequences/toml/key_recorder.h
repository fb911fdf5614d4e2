// Which keys a file may have, as the parser itself asks for them: while a KeyRecorder lives, every key that its thread
// reads through a TomlTable is noted with type, range and default. The reference of keys is made of it
// (bench/cli/words).
#pragma once

#include <string>
#include <vector>

namespace tactbench::sequences {

struct KeyUse {
  std::string key;   // dotted; an element of a list of tables is []: "scenario[].name"
  std::string type;  // "number", "whole number", "text", "one of", ...; empty: only asked whether it is there
  std::vector<std::string> ranges;    // "0 to 1", or the words of "one of"; several where they depend on other keys
  std::vector<std::string> defaults;  // as TOML; empty and `required`: there is none
  bool required = true;               // no reading of it knew a default, and none asked first whether it is there
};

class KeyRecorder {
 public:
  // Of the files that are read under this name; empty: of all. One a thread at a time; std::logic_error.
  explicit KeyRecorder(std::string file = {});
  ~KeyRecorder();
  KeyRecorder(const KeyRecorder&) = delete;
  KeyRecorder& operator=(const KeyRecorder&) = delete;
  [[nodiscard]] const std::vector<KeyUse>& keys() const { return keys_; }  // in the order of first reading

  // Of strict_toml*.cpp: notes a reading; one within another is part of it and not noted.
  class Reading {
   public:
    Reading(const std::string& file, const std::string& path, const std::string& key, const char* type,
            const std::string& range, const std::string* standard, bool asked_only = false);
    ~Reading();
    Reading(const Reading&) = delete;
    Reading& operator=(const Reading&) = delete;
  };
  // The keys of the table at `path` are names that the file chooses.
  static void chosen_names(const std::string& file, const std::string& path);

 private:
  void add(std::string key, const char* type, const std::string& range, const std::string* standard, bool asked_only);
  [[nodiscard]] bool listens(const std::string& file) const { return file_.empty() || file == file_; }

  std::string file_;
  std::vector<KeyUse> keys_;
  std::vector<std::string> chosen_;
};

}  // namespace tactbench::sequences
