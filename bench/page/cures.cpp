#include "bench/page/cures.h"

#include <sstream>
#include <vector>

#include "bench/page/assets.h"

namespace tactbench::bench {

namespace {

// Of devices and links whose errors advise differently from case to case.
constexpr const char* kOfADevice =
    "check the device, its supply and its cable: tactbench devices check names what answers; then tactbench resume";

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" `");
  const std::size_t last = text.find_last_not_of(" `");
  return first == std::string::npos ? std::string() : text.substr(first, last - first + 1);
}

// "| a | b |" -> a, b. A cell's own bar is written "\|".
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::string cell;
  for (std::size_t i = 1; i < line.size(); ++i) {
    if (line[i] == '\\' && i + 1 < line.size() && line[i + 1] == '|') {
      cell += line[++i];
    } else if (line[i] == '|') {
      cells.push_back(trimmed(cell));
      cell.clear();
    } else {
      cell += line[i];
    }
  }
  return cells;
}

}  // namespace

std::map<std::string, std::string, std::less<>> cures_of(std::string_view table) {
  std::map<std::string, std::string, std::less<>> cures;
  std::istringstream lines{std::string(table)};
  std::string id;
  std::vector<std::string> devices;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("|")) continue;
    const std::vector<std::string> cells = cells_of(line);
    if (cells.size() < 4) continue;
    if (cells[0].starts_with("TB-")) id = cells[0];
    if (id.empty()) continue;
    if (!cells[3].empty()) cures.try_emplace(id, cells[3]);
    if (cells[1] == "3") devices.push_back(id);
  }
  for (const std::string& device : devices) cures.try_emplace(device, kOfADevice);
  return cures;
}

std::string cure_of(std::string_view id) {
  static const auto cures = cures_of(asset("reference-errors.md"));
  const auto found = cures.find(id);
  return found == cures.end() ? std::string() : found->second;
}

}  // namespace tactbench::bench
