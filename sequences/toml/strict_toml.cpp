#include "sequences/toml/strict_toml.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <sstream>

#include "sequences/toml/strict_toml_view.h"

namespace tactbench::sequences {

namespace {
char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }
}  // namespace

std::string nearest_word(const std::string& word, const std::vector<std::string>& known) {
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : known) {
    std::vector<std::size_t> row(candidate.size() + 1);
    std::iota(row.begin(), row.end(), 0U);
    for (std::size_t i = 1; i <= word.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i;
      for (std::size_t j = 1; j <= candidate.size(); ++j) {
        const std::size_t changed = diagonal + (lower(word[i - 1]) == lower(candidate[j - 1]) ? 0 : 1);
        diagonal = row[j];
        row[j] = std::min({row[j] + 1, row[j - 1] + 1, changed});
      }
    }
    if (row.back() < best_distance) {
      best_distance = row.back();
      best = candidate;
    }
  }
  return best;
}

namespace {

// toml++ bounds the depth of arrays but not that of dotted keys: one of 200,000 parts would overflow the stack.
constexpr std::size_t kLongestLine = 16384;
constexpr std::size_t kLargestFile = 16'000'000;  // bytes

void check_lines(const std::string& text, const std::string& name) {
  std::size_t line = 1;
  for (std::size_t at = 0; at < text.size(); ++line) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    if (end - at > kLongestLine) {
      throw FileError("TB-FILE-SYNTAX", fmt::format("a line of {} characters", end - at),
                      fmt::format("{}:{}", name, line),
                      fmt::format("break it: a line may have {} characters", kLongestLine));
    }
    at = end + 1;
  }
}

toml::table parse(const std::string& text, const std::string& name) {
  check_lines(text, name);
  try {
    return toml::parse(text, name);
  } catch (const toml::parse_error& error) {
    const auto& at = error.source().begin;
    throw FileError("TB-FILE-SYNTAX", fmt::format("not valid TOML: {}", error.description()),
                    fmt::format("{}:{}:{}", name, at.line, at.column),
                    "a quantity is a plain number with its unit in the key (dwell_s = 2.0); text needs quotes");
  }
}

}  // namespace

std::string FileError::shown(std::string message) {
  for (std::size_t at = 0; (at = message.find('\0', at)) != std::string::npos;) message.replace(at, 1, "\\x00");
  return message;
}

TomlDocument TomlDocument::from_file(const std::string& path) {
  namespace fs = std::filesystem;
  const auto refuse = [&](const std::string& message, const std::string& remedy) {
    throw FileError("TB-FILE-MISSING", message, path, remedy);
  };
  std::error_code unknown;
  const fs::file_status status = fs::status(path, unknown);
  const bool found = !unknown && status.type() != fs::file_type::not_found;
  if (found && status.type() != fs::file_type::regular) {
    refuse(fmt::format("'{}' is not a regular file", path), "name a file: devices, folders and pipes are not read");
  }
  // Files of /proc and /sys also have size 0; reading some of them blocks forever.
  if (found && fs::file_size(path, unknown) == 0)
    refuse(fmt::format("'{}' is empty", path), "check that it is the right file");
  std::ifstream stream;
  if (found) stream.open(path, std::ios::binary);
  if (!found || !stream) {
    refuse(fmt::format("cannot read the file '{}'", path),
           "check the name; 'tactbench init' writes files to start from");
  }
  std::string text;
  std::vector<char> block(std::size_t{1} << 16);
  while (stream.read(block.data(), static_cast<std::streamsize>(block.size())), stream.gcount() > 0) {
    text.append(block.data(), static_cast<std::size_t>(stream.gcount()));
    if (text.size() > kLargestFile) {
      refuse(fmt::format("'{}' is longer than {} bytes", path, kLargestFile), "check that it is the right file");
    }
  }
  if (stream.bad()) refuse(fmt::format("reading the file '{}' failed", path), "check the disk and the file");
  return from_text(text, path);
}

TomlDocument TomlDocument::from_text(const std::string& text, const std::string& name) {
  TomlDocument document;
  document.text_ = text;
  document.name_ = name;
  document.node_ = std::make_shared<Node>(Node{parse(text, name)});
  return document;
}

void TomlDocument::set(const Override& override_value, const std::string& prefix) {
  const std::string where = "--set " + prefix + override_value.key + "=" + override_value.value;
  node_->typed_prefix = prefix;
  node_->typed.erase(override_value.key);  // of an earlier setting
  if (!override_value.typed.empty() && override_value.typed != override_value.value)
    node_->typed[override_value.key] = override_value.typed;
  toml::table holder;
  try {
    holder = toml::parse("v = " + override_value.value, where);
  } catch (const toml::parse_error&) {
    holder.insert_or_assign("v", override_value.value);
  }
  toml::table* table = &node_->table;
  std::string rest = override_value.key;
  for (std::size_t dot = rest.find('.'); dot != std::string::npos; dot = rest.find('.')) {
    const std::string head = rest.substr(0, dot);
    rest.erase(0, dot + 1);
    if (!table->contains(head)) table->insert_or_assign(head, toml::table{});
    table = table->get(head)->as_table();
    if (table == nullptr) {
      throw FileError("TB-FILE-VALUE", fmt::format("'{}' is not a table", head), where,
                      "write the key as in the file, table.key");
    }
  }
  if (rest.empty()) throw FileError("TB-FILE-VALUE", "an empty key", where, "write --set table.key=value");
  table->insert_or_assign(rest, *holder.get("v"));
}

void TomlDocument::remove(const std::string& key) { node_->table.erase(key); }

void TomlDocument::define(const std::string& name, double value) { node_->parameters[name] = value; }
bool TomlDocument::uses(const std::string& name) const { return node_->parameters_used.contains(name); }

std::string TomlDocument::to_text() const {
  std::ostringstream stream;
  stream << node_->table << '\n';
  return stream.str();
}

TomlTable TomlDocument::root() const {
  auto view = std::make_shared<TomlTable::View>();
  view->owner = node_;
  view->table = &node_->table;
  view->file = name_;
  return TomlTable(std::move(view));
}

const std::vector<Setting>& TomlDocument::settings() const { return node_->settings; }

}  // namespace tactbench::sequences
