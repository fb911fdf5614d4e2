#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "analysis/json_fields.h"
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

void check_values(const std::vector<double>& values, const char* key, std::size_t taxels) {
  if (values.size() != taxels) throw std::invalid_argument(std::string("specimen state: wrong length of ") + key);
}

template <typename Columns>
void read_columns(const nlohmann::json& json, const char* key, std::size_t taxels, Columns& columns) {
  const auto given = json.at(key).get<std::vector<std::vector<double>>>();
  if (given.size() != columns.size())
    throw std::invalid_argument(std::string("specimen state: wrong number of ") + key);
  for (std::size_t k = 0; k < given.size(); ++k) {
    check_values(given[k], key, taxels);
    for (const double value : given[k]) {
      if (!std::isfinite(value) || value < 0.0) {
        throw std::invalid_argument(std::string("specimen state: a value of ") + key + " is negative or not finite");
      }
    }
    columns[k] = given[k];
  }
}

constexpr std::array kHarshValues = {
    std::pair{"load_psi", &HarshMemory::load_psi}, std::pair{"sliding", &HarshMemory::sliding},
    std::pair{"drag_psi", &HarshMemory::drag_psi}, std::pair{"zero_walk_v", &HarshMemory::zero_v},
    std::pair{"gain_walk", &HarshMemory::gain}};

nlohmann::json harsh_json(const HarshMemory& memory) {
  nlohmann::json json = {JSON_FIELDS(memory, path_psi, time_s)};
  for (const auto& [key, values] : kHarshValues) json[key] = memory.*values;
  return json;
}

HarshMemory read_harsh(const nlohmann::json& json, std::size_t taxels) {
  HarshMemory memory;
  memory.path_psi = number(json, "path_psi");
  memory.time_s = number(json, "time_s");
  if (memory.path_psi < 0.0 || memory.time_s < 0.0)
    throw std::invalid_argument("specimen state: path_psi or time_s is negative");
  for (const auto& [key, values] : kHarshValues) {
    memory.*values = json.at(key).get<std::vector<double>>();
    check_values(memory.*values, key, taxels);
    if (!std::ranges::all_of(memory.*values, [](double value) { return std::isfinite(value); }))
      throw std::invalid_argument(std::string("specimen state: a value of ") + key + " is not finite");
  }
  return memory;
}

void check_foam(const FoamMemory& memory, std::size_t taxels) {
  if (memory.taxels.size() != taxels) throw std::invalid_argument("specimen state: wrong length of foam");
  if (memory.calm_s < 0.0) throw std::invalid_argument("specimen state: calm_s is negative");
  for (const FoamTaxelState& taxel : memory.taxels) {
    if (!(taxel.load_psi >= 0.0)) throw std::invalid_argument("specimen state: a value of load_psi is negative");
    if (!(std::abs(taxel.strain) < 1.0))
      throw std::invalid_argument("specimen state: a value of strain is not below 1");
  }
}

}  // namespace

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FoamTaxelState, load_psi, strain, greatest, worked_in, unrelaxed, friction_psi)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FoamMemory, taxels, calm_s)

std::string write_state(const FilmMemory& memory, const SpecimenOptions& options) {
  // nlohmann writes the shortest text that reads back to the same double.
  nlohmann::json json = {{"format", kFormat},
                         {"version", kVersion},
                         JSON_FIELDS(options, sensor_seed, rows, columns),
                         JSON_FIELDS(memory, pressure_psi, lag_psi, virgin, travel_psi, plays, creep)};
  if (options.kind == SpecimenKind::kHarsh) json["harsh"] = harsh_json(memory.harsh);
  if (options.kind == SpecimenKind::kFoam) json["foam"] = memory.foam;
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
    const bool harsh = options.kind == SpecimenKind::kHarsh, foam = options.kind == SpecimenKind::kFoam;
    const std::string own = word_of(options.kind);
    const std::string given = json.contains("harsh") ? "harsh" : json.contains("foam") ? "foam" : "paper";
    if (given != own) {
      throw std::invalid_argument("specimen state: belongs to the specimen \"" + given + "\", this one is \"" + own +
                                  "\"");
    }
    FilmMemory memory;
    memory.pressure_psi = number(json, "pressure_psi");
    memory.lag_psi = number(json, "lag_psi");
    memory.virgin = number(json, "virgin");
    memory.travel_psi = number(json, "travel_psi");
    const auto taxels = static_cast<std::size_t>(options.rows) * static_cast<std::size_t>(options.columns);
    if (foam) {
      memory.foam = json.at("foam").get<FoamMemory>();
      check_foam(memory.foam, taxels);
      return memory;
    }
    read_columns(json, "plays", taxels, memory.plays);
    memory.creep.resize(harsh ? kHarshCreepTimes : kCreepTimes);
    read_columns(json, "creep", taxels, memory.creep);
    if (harsh) memory.harsh = read_harsh(json.at("harsh"), taxels);
    return memory;
  } catch (const nlohmann::json::exception& error) {
    throw std::invalid_argument(std::string("specimen state: ") + error.what());
  }
}

}  // namespace tactbench::bench
