// JSON text to documents and back. Parser and serializer are compiled once, here: they cost most of what a source that
// includes <nlohmann/json.hpp> takes to compile.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace tactbench::analysis {

// Throw nlohmann::json::parse_error where `text` is no JSON.
nlohmann::json parse_json(const std::string& text);
nlohmann::ordered_json parse_ordered_json(const std::string& text);
// A discarded value instead.
nlohmann::json try_json(const std::string& text);
nlohmann::ordered_json try_ordered_json(const std::string& text);
// Null instead: for text that goes into a document, empty text as well.
nlohmann::ordered_json ordered_json_or_null(const std::string& text);

// One line. Throw nlohmann::json::type_error where a text in it is not UTF-8.
std::string json_line(const nlohmann::json& json);
std::string json_line(const nlohmann::ordered_json& json);
// What is not UTF-8 is replaced by U+FFFD. Below 0 one line, else so many blanks a level.
std::string printable_json(const nlohmann::json& json, int indent = -1);
std::string printable_json(const nlohmann::ordered_json& json, int indent = -1);

}  // namespace tactbench::analysis
