#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "analysis/json_io.h"
#include "bench/simulation/specimen_film.h"

namespace tactbench::bench {
namespace {

constexpr const char* kFormat = "tactbench-specimen-state";
constexpr int kVersion = 1;

double number(const nlohmann::json& json, const char* key) {
  const double value = json.at(key).get<double>();
  if (!std::isfinite(value)) throw std::invalid_argument(std::string("specimen state: ") + key + " is not finite");
  return value;
}

template <std::size_t kCount>
void read_columns(const nlohmann::json& json, const char* key, std::size_t taxels,
                  std::array<std::vector<double>, kCount>& columns) {
  const auto given = json.at(key).get<std::vector<std::vector<double>>>();
  if (given.size() != kCount) throw std::invalid_argument(std::string("specimen state: wrong number of ") + key);
  for (std::size_t k = 0; k < kCount; ++k) {
    if (given[k].size() != taxels) throw std::invalid_argument(std::string("specimen state: wrong length of ") + key);
    for (const double value : given[k]) {
      if (!std::isfinite(value) || value < 0.0) {
        throw std::invalid_argument(std::string("specimen state: a value of ") + key + " is negative or not finite");
      }
    }
    columns[k] = given[k];
  }
}

}  // namespace

std::string write_state(const FilmMemory& memory, const SpecimenOptions& options) {
  // nlohmann writes the shortest text that reads back to the same double.
  const nlohmann::json json = {
      {"format", kFormat},         {"version", kVersion},        {"sensor_seed", options.sensor_seed},
      {"rows", options.rows},      {"columns", options.columns}, {"pressure_psi", memory.pressure_psi},
      {"lag_psi", memory.lag_psi}, {"virgin", memory.virgin},    {"travel_psi", memory.travel_psi},
      {"plays", memory.plays},     {"creep", memory.creep}};
  return analysis::json_line(json);
}

FilmMemory read_state(const std::string& text, const SpecimenOptions& options) {
  try {
    const auto json = analysis::parse_json(text);
    if (json.at("format").get<std::string>() != kFormat || json.at("version").get<int>() != kVersion) {
      throw std::invalid_argument("specimen state: not a state of this program, or of another version");
    }
    if (json.at("sensor_seed").get<std::uint64_t>() != options.sensor_seed ||
        json.at("rows").get<int>() != options.rows || json.at("columns").get<int>() != options.columns) {
      throw std::invalid_argument("specimen state: belongs to another sensor (sensor_seed, rows or columns differ)");
    }
    FilmMemory memory;
    memory.pressure_psi = number(json, "pressure_psi");
    memory.lag_psi = number(json, "lag_psi");
    memory.virgin = number(json, "virgin");
    memory.travel_psi = number(json, "travel_psi");
    const auto taxels = static_cast<std::size_t>(options.rows) * static_cast<std::size_t>(options.columns);
    read_columns(json, "plays", taxels, memory.plays);
    read_columns(json, "creep", taxels, memory.creep);
    return memory;
  } catch (const nlohmann::json::exception& error) {
    throw std::invalid_argument(std::string("specimen state: ") + error.what());
  }
}

}  // namespace tactbench::bench
