#include "sequences/toml/key_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

namespace tactbench::sequences {

void read_keys(const TomlTable& table, const KeyTable& keys) {
  for (const Key& key : keys) {
    if (key.presence == Key::Presence::kOptional && !table.has(key.facts.key)) continue;
    key.read(table, key.presence != Key::Presence::kDefault);
  }
}

void read_whole(const TomlTable& table, const KeyTable& keys) {
  read_keys(table, keys);
  table.finish();
}

void add_facts(std::vector<KeyFacts>& all, const std::string& path, const KeyTable& keys) {
  const auto add = [](std::string& text, const std::string& more, const char* between) {
    if (text != more && !more.empty()) text += (text.empty() ? "" : between) + more;
  };
  for (const Key& key : keys) {
    KeyFacts facts = key.facts;
    if (!path.empty()) facts.key = path + "." + facts.key;
    const auto known = std::ranges::find(all, facts.key, &KeyFacts::key);
    if (known == all.end()) {
      all.push_back(std::move(facts));
      continue;
    }
    add(known->type, facts.type, " or ");
    add(known->range, facts.range, "; or ");
    add(known->standard, facts.standard, " or ");
    add(known->meaning, facts.meaning, ". ");
  }
}

namespace key {

namespace {

std::string code(const std::string& toml) { return "`" + toml + "`"; }
std::string quoted(const std::string& text) { return code("\"" + text + "\""); }

std::string range_text(const Range& range) {
  if (range.low == range.high) return fmt::format("{:.6g}", range.low);
  if (!std::isfinite(range.low) && !std::isfinite(range.high)) return {};
  return fmt::format("{}{:.6g}{}", range.or_zero ? "0, or " : "", range.low,
                     std::isfinite(range.high) ? fmt::format(" to {:.10g}", range.high) : " or more");
}

Key with_presence(Key key, Key::Presence presence, const char* standard) {
  key.presence = presence;
  key.facts.standard = standard;
  return key;
}

}  // namespace

namespace detail {

Key number(const char* name, double standard, const Unit& unit, const Range& range, const char* meaning,
           std::function<void(double)> take) {
  return {{name, "number", unit.name, range_text(range), code(fmt::format("{:.6g}", standard)), meaning},
          [=, take = std::move(take)](const TomlTable& table, bool required) {
            const std::optional<double> fallback = required ? std::nullopt : std::optional(standard);
            take(range.or_zero ? table.zero_or_in(name, fallback, range.low, range.high)
                               : table.number_in(name, fallback, range.low, range.high));
          }};
}

Key whole(const char* name, long standard, const Unit& unit, const Range& range, const char* meaning,
          std::function<void(long)> take) {
  const long low = static_cast<long>(range.low), high = static_cast<long>(range.high);
  const std::string words = low == high ? fmt::format("{}", low) : fmt::format("{} to {}", low, high);
  return {{name, "whole number", unit.name, words, code(fmt::format("{}", standard)), meaning},
          [=, take = std::move(take)](const TomlTable& table, bool required) {
            take(required ? table.integer(name, low, high) : table.integer(name, standard, low, high));
          }};
}

Key span(const char* name, std::pair<double, double> standard, const Unit& unit, const char* meaning,
         std::function<void(double, double)> take) {
  return {{name, "[low, high]", unit.name, "low < high",
           code(fmt::format("[{:.6g}, {:.6g}]", standard.first, standard.second)), meaning},
          [=, take = std::move(take)](const TomlTable& table, bool /*required*/) {
            const auto [low, high] = table.span(name, standard);
            take(low, high);
          }};
}

Key word(const char* name, std::size_t standard, const std::vector<std::string>& words, const char* meaning,
         std::function<void(std::size_t)> take) {
  return {{name, "one of", "-", fmt::format("{}", fmt::join(words, ", ")), quoted(words[standard]), meaning},
          [=, take = std::move(take)](const TomlTable& table, bool required) {
            const std::string word = required ? table.word(name, words) : table.word(name, words[standard], words);
            take(static_cast<std::size_t>(std::ranges::find(words, word) - words.begin()));
          }};
}

}  // namespace detail

Key word(const char* name, bool& variable, const std::vector<std::string>& words, const char* yes,
         const char* meaning) {
  const auto standard = std::ranges::find_if(words, [&](const std::string& word) { return (word == yes) == variable; });
  return detail::word(name, static_cast<std::size_t>(standard - words.begin()), words, meaning,
                      [&variable, words, yes](std::size_t place) { variable = words[place] == yes; });
}

Key word(const char* name, std::string& variable, const std::vector<std::string>& words, const char* meaning) {
  const auto standard = std::ranges::find(words, variable);
  return detail::word(name, standard == words.end() ? 0 : static_cast<std::size_t>(standard - words.begin()), words,
                      meaning, [&variable, words](std::size_t place) { variable = words[place]; });
}

Key flag(const char* name, bool& variable, const char* meaning) {
  return {{name, "true or false", "-", "", code(variable ? "true" : "false"), meaning},
          [name, &variable](const TomlTable& table, bool) { variable = table.boolean(name, variable); }};
}

Key text(const char* name, std::string& variable, const char* meaning) {
  return {{name, "text", "-", "", quoted(variable), meaning}, [name, &variable](const TomlTable& table, bool required) {
            variable = required ? table.text(name) : table.text(name, variable);
          }};
}

Key name(const char* name, std::string& variable, const char* meaning) {
  return required({{name, "text", "-", "not blank", "", meaning},
                   [name, &variable](const TomlTable& table, bool) { variable = table.name(name); }});
}

Key texts(const char* name, std::vector<std::string>& variable, const char* meaning) {
  return {{name, "list of texts", "-", "", code("[]"), meaning},
          [name, &variable](const TomlTable& table, bool) { variable = table.texts(name); }};
}

Key numbers(const char* name, std::vector<double>& variable, const Unit& unit, const char* meaning) {
  return required({{name, "list of numbers", unit.name, "", "", meaning},
                   [name, &variable](const TomlTable& table, bool) { variable = table.numbers(name); }});
}

Key numbers_or_one(const char* name, std::vector<double>& variable, const Unit& unit, const char* meaning) {
  const double standard = variable.front();
  return {{name, "number, or list of numbers", unit.name, "", code(fmt::format("{:.6g}", standard)), meaning},
          [=, &variable](const TomlTable& table, bool) { variable = table.numbers_or_one(name, standard); }};
}

Key schema() {
  return required({{"schema", "whole number", "1", "1", "", "Version of this file's format"},
                   [](const TomlTable& table, bool) { (void)table.integer("schema", 1, 1); }});
}

Key made(KeyFacts facts, std::function<void(const TomlTable&)> read) {
  return {std::move(facts), [read = std::move(read)](const TomlTable& table, bool) { read(table); }};
}

Key required(Key key) { return with_presence(std::move(key), Key::Presence::kRequired, "required"); }
Key optional(Key key) { return with_presence(std::move(key), Key::Presence::kOptional, ""); }

Key described(Key key, const std::string& standard) {
  key.facts.standard = standard;
  return key;
}

}  // namespace key

}  // namespace tactbench::sequences
