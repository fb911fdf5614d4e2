// JSON text to documents and back. Parser and serializer are compiled only here: they take most of the compile time of
// a source that includes <nlohmann/json.hpp>.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace tactbench::analysis {

// JSON comes from files, stores and sockets: text with more bytes or deeper nesting is refused, because a parsed text
// needs many times its length of memory, and nested values are written by recursion.
inline constexpr std::size_t kMaxJsonBytes = 64'000'000;  // a Preisach model of 64 x 64 taxels has about 20 million
inline constexpr int kMaxJsonDepth = 100;

// Throws nlohmann::json::exception if `text` is not JSON.
nlohmann::json parse_json(const std::string& text);
nlohmann::ordered_json parse_ordered_json(const std::string& text);
// Returns a discarded value (nlohmann's is_discarded()) instead of throwing.
nlohmann::json try_json(const std::string& text);
nlohmann::ordered_json try_ordered_json(const std::string& text);
// Returns null instead of throwing, also for empty text: for text that is embedded in a document.
nlohmann::ordered_json ordered_json_or_null(const std::string& text);

// One line. Throw nlohmann::json::type_error if a text in it is not UTF-8.
std::string json_line(const nlohmann::json& json);
std::string json_line(const nlohmann::ordered_json& json);
// Replaces bytes that are not UTF-8 by U+FFFD. Indent below 0: one line; else that many blanks per level.
std::string printable_json(const nlohmann::json& json, int indent = -1);
std::string printable_json(const nlohmann::ordered_json& json, int indent = -1);

}  // namespace tactbench::analysis
