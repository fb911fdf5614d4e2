// Lines, cells of a table, and words of a command.
#pragma once

#include <sstream>
#include <string>
#include <vector>

namespace tactbench::tests {

// The text between its line ends, or another separator; nothing after the last one.
inline std::vector<std::string> lines_of(const std::string& text, char separator = '\n') {
  std::vector<std::string> lines;
  std::istringstream rest(text);
  for (std::string line; std::getline(rest, line, separator);) lines.push_back(line);
  return lines;
}

// The cells of each line of a CSV table without quotes.
inline std::vector<std::vector<std::string>> cells_of(const std::string& table) {
  std::vector<std::vector<std::string>> rows;
  for (const std::string& line : lines_of(table)) rows.push_back(lines_of(line + ",", ','));
  return rows;
}

inline std::vector<std::string> joined(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

}  // namespace tactbench::tests
