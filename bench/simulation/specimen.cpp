#include "bench/simulation/specimen.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "bench/simulation/counter_noise.h"
#include "bench/simulation/specimen_film.h"

namespace tactbench::bench {

std::vector<std::string> specimen_kind_names() { return {"paper", "harsh", "foam"}; }
std::string keyword_of(SpecimenKind kind) { return specimen_kind_names().at(static_cast<std::size_t>(kind)); }

Specimen::Specimen(const SpecimenOptions& options) : film_(std::make_unique<Film>(options)) {}
Specimen::~Specimen() = default;

void Specimen::advance(double pressure_psi, double seconds, std::span<const double> contact_psi) {
  if (!(seconds > 0.0)) throw std::invalid_argument("Specimen::advance: seconds must be positive");
  if (!contact_psi.empty() && contact_psi.size() != static_cast<std::size_t>(film_->taxels)) {
    throw std::invalid_argument("Specimen::advance: contact_psi does not fit the array");
  }
  film_->advance(film_->memory, pressure_psi, seconds, contact_psi);
}

void Specimen::output(std::span<double> volts) const { film_->output(film_->memory, volts); }

void Specimen::output_after(double pressure_psi, double seconds, std::span<double> volts,
                            std::span<const double> contact_psi) const {
  if (!(seconds > 0.0)) return film_->output(film_->memory, volts);
  FilmMemory memory = film_->memory;
  film_->advance(memory, pressure_psi, seconds, contact_psi);
  film_->output(memory, volts);
}

double Specimen::noise_v(int taxel) const { return film_->noise_v.at(static_cast<std::size_t>(taxel)); }
double Specimen::white_noise(std::uint64_t hash) const { return film_->harsh ? heavy_tailed_of(hash) : bell_of(hash); }

void Specimen::add_film_noise(double time_s, std::span<double> volts) const {
  if (film_->harsh) film_->harsh->add_flicker(time_s, volts);
}

std::string Specimen::state() const { return write_state(film_->memory, film_->options); }
void Specimen::set_state(const std::string& text) { film_->memory = read_state(text, film_->options); }
const SpecimenOptions& Specimen::options() const { return film_->options; }

namespace {

// Streams of the sensor seed.
enum Stream : std::uint64_t { kThickness = 1, kSensitivity, kExponent, kLiftOff, kFriction, kZero, kCreep, kLag, kAge };

// Inverse of the normal distribution on (0, 1), by bisection: exact to rounding and quick enough for one array.
double normal_quantile(double probability) {
  double low = -8.0;
  double high = 8.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(-middle / std::sqrt(2.0)) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// One standard normal, truncated at +-kTruncation, per taxel: one value from each of `taxels` equal shares of the
// distribution, dealt out in the order of `keys`.
std::vector<double> deal_normals(const std::vector<double>& keys, std::uint64_t seed, std::uint64_t stream) {
  const std::size_t taxels = keys.size();
  std::vector<std::size_t> order(taxels);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return keys[a] < keys[b]; });
  const double tail = 0.5 * std::erfc(film::kTruncation / std::sqrt(2.0));
  std::vector<double> values(taxels);
  for (std::size_t rank = 0; rank < taxels; ++rank) {
    const double within = uniform_of(hash_of(seed, stream + 1000, rank));
    const double share = (static_cast<double>(rank) + within) / static_cast<double>(taxels);
    values[order[rank]] = normal_quantile(tail + share * (1.0 - 2.0 * tail));
  }
  return values;
}

std::vector<double> white_keys(std::size_t taxels, std::uint64_t seed, std::uint64_t stream) {
  std::vector<double> keys(taxels);
  for (std::size_t i = 0; i < taxels; ++i) keys[i] = bell_of(hash_of(seed, stream, i));
  return keys;
}

// Spin-coated: half of the variance of the film's thickness is a bowl and a tilt across the array.
std::vector<double> thickness_keys(const SpecimenOptions& options) {
  const auto taxels = static_cast<std::size_t>(options.rows) * static_cast<std::size_t>(options.columns);
  std::vector<double> keys = white_keys(taxels, options.sensor_seed, kThickness);
  const auto draw = [&](std::uint64_t index) {
    return bell_of(hash_of(options.sensor_seed, kThickness + 2000, index));
  };
  const double tilt_x = draw(0);
  const double tilt_y = draw(1);
  const double bowl = 1.5 * draw(2);
  std::size_t taxel = 0;
  for (int r = 0; r < options.rows; ++r) {
    for (int c = 0; c < options.columns; ++c, ++taxel) {
      const double y = options.rows > 1 ? 2.0 * r / (options.rows - 1) - 1.0 : 0.0;
      const double x = options.columns > 1 ? 2.0 * c / (options.columns - 1) - 1.0 : 0.0;
      keys[taxel] += tilt_x * x + tilt_y * y + bowl * (x * x + y * y - 0.7);
    }
  }
  return keys;
}

}  // namespace

std::array<double, kFrictionElements> element_shares(double centre, double spread) {
  std::array<double, kFrictionElements> shares{};
  double sum = 0.0;
  for (std::size_t k = 0; k < shares.size(); ++k) {
    const double distance = (film::kWidths[k] - centre) / spread;
    shares[k] = std::exp(-0.5 * distance * distance);
    sum += shares[k];
  }
  for (double& share : shares) share /= sum;
  return shares;
}

FilmMake make_film(const SpecimenOptions& options) {
  const auto taxels = static_cast<std::size_t>(options.rows) * static_cast<std::size_t>(options.columns);
  const std::uint64_t seed = options.sensor_seed;
  const auto white = [&](std::uint64_t stream) { return deal_normals(white_keys(taxels, seed, stream), seed, stream); };
  const auto thickness = deal_normals(thickness_keys(options), seed, kThickness);
  const auto sensitivity = white(kSensitivity);
  const auto exponent = white(kExponent);
  const auto lift_off = white(kLiftOff);
  const auto friction = white(kFriction);
  const auto zero = white(kZero);
  const auto creep = white(kCreep);
  const auto lag = white(kLag);

  FilmMake make;
  make.age_drift = white(kAge);
  make.rest_share = element_shares(film::kRestCentre, film::kRestSpread);
  make.displaced_share = element_shares(film::kDisplacedCentre, film::kDisplacedSpread);
  const auto blend = [](double correlation, double shared, double own) {
    return correlation * shared + std::sqrt(1.0 - correlation * correlation) * own;
  };
  for (std::size_t i = 0; i < taxels; ++i) {
    const double s = blend(film::kAmplitudeSensitivity, thickness[i], sensitivity[i]);
    const double n = blend(film::kSensitivityExponent, s, exponent[i]);
    make.amplitude_v.push_back(film::kAmplitudeV * (1.0 + film::kAmplitudeSpread * thickness[i]));
    make.sensitivity.push_back(std::exp(film::kSensitivitySpread * s));
    make.exponent.push_back(std::max(film::kExponentFloor, film::kExponent + film::kExponentSpread * n));
    make.friction.push_back(std::exp(film::kFrictionSpread * friction[i]));
    make.lift_off_psi.push_back(options.effects.lift_off_psi * std::exp(film::kLiftOffSpread * lift_off[i]));
    make.zero_v.push_back(film::kZeroV * (1.0 + film::kZeroSpread * zero[i]));
    make.creep.push_back(1.0 + film::kCreepSpread * creep[i]);
    make.lag_share.push_back(film::kLagShare * (1.0 + film::kLagSpread * lag[i]));
  }
  return make;
}

namespace {

constexpr std::uint64_t kMountStream = 50;
constexpr double kAtTheRim = 0.25;  // of a line's width still feels the membrane on the outermost line

double edge_share(const SpecimenOptions& options, int row, int column) {
  if (options.edge_outside_lines <= 0) return 1.0;
  int line = 0;  // from the edge
  switch (options.edge_outside) {
    case MountEdge::kFirstRow:
      line = row;
      break;
    case MountEdge::kLastRow:
      line = options.rows - 1 - row;
      break;
    case MountEdge::kFirstColumn:
      line = column;
      break;
    case MountEdge::kLastColumn:
      line = options.columns - 1 - column;
      break;
  }
  return std::min(1.0, (line + kAtTheRim) / options.edge_outside_lines);
}

// What the chamber's tilt adds at each taxel of the film.
std::vector<double> tilt_shares(const SpecimenOptions& options) {
  const std::vector<std::size_t> wiring = turned_wiring(options);
  const double degrees = options.effects.chamber_tilt_deg - options.turned_in_chamber_deg;
  const double angle = degrees * std::numbers::pi / 180.0;
  const double side = std::max({options.rows - 1, options.columns - 1, 1});
  std::vector<double> shares(wiring.size());
  for (std::size_t lead = 0; lead < wiring.size(); ++lead) {
    const int row = static_cast<int>(lead) / options.columns;
    const int column = static_cast<int>(lead) % options.columns;
    const double up = 0.5 * (options.rows - 1) - row;
    const double right = column - 0.5 * (options.columns - 1);
    const double toward = right * std::cos(angle) + up * std::sin(angle);
    shares[wiring[lead]] = options.effects.chamber_tilt * toward / side;
  }
  return shares;
}

}  // namespace

std::vector<std::string> mount_turn_names(bool square) {
  std::vector<std::string> words = {"none",      "turned-180", "rows-mirrored", "columns-mirrored",
                                    "turned-90", "turned-270", "transposed",    "anti-transposed"};
  if (!square) words.resize(4);
  return words;
}

std::vector<std::string> mount_edge_names() { return {"first-row", "last-row", "first-column", "last-column"}; }

std::vector<double> shares_of_chamber(const SpecimenOptions& options) {
  std::vector<double> shares;
  const std::vector<double> tilt = tilt_shares(options);
  const double half_rows = 0.5 * (options.rows - 1);
  const double half_columns = 0.5 * (options.columns - 1);
  const double corner = std::max(half_rows * half_rows + half_columns * half_columns, 1e-12);
  for (int i = 0; i < options.rows * options.columns; ++i) {
    const int row = i / options.columns;
    const int column = i % options.columns;
    const double y = row - half_rows;
    const double x = column - half_columns;
    double share = 1.0 + options.effects.chamber_nonuniformity * (x * x + y * y) / corner;
    share += tilt[static_cast<std::size_t>(i)];
    if (options.mount_seed != 0) {
      const auto key = hash_of(options.sensor_seed, kMountStream, options.mount_seed);
      const double change = options.effects.remount_variation * bell_of(hash_of(key, 0, static_cast<std::uint64_t>(i)));
      share *= std::max(0.0, 1.0 + change);
    }
    shares.push_back(share * edge_share(options, row, column));
  }
  return shares;
}

std::vector<std::size_t> turned_wiring(const SpecimenOptions& options) {
  const int last_row = options.rows - 1;
  const int last_column = options.columns - 1;
  const auto from = [&](int r, int c) -> std::pair<int, int> {
    switch (options.mount_turn) {
      case MountTurn::kNone:
        break;
      case MountTurn::kBy90:
        return {last_row - c, r};
      case MountTurn::kBy180:
        return {last_row - r, last_column - c};
      case MountTurn::kBy270:
        return {c, last_column - r};
      case MountTurn::kRowsMirrored:
        return {last_row - r, c};
      case MountTurn::kColumnsMirrored:
        return {r, last_column - c};
      case MountTurn::kTransposed:
        return {c, r};
      case MountTurn::kAntiTransposed:
        return {last_row - c, last_column - r};
    }
    return {r, c};
  };
  std::vector<std::size_t> wiring;
  for (int r = 0; r < options.rows; ++r) {
    for (int c = 0; c < options.columns; ++c) {
      const auto [row, column] = from(r, c);
      if (row < 0 || row > last_row || column < 0 || column > last_column) {
        throw std::invalid_argument("specimen: an array that is not square cannot be turned by a quarter");
      }
      wiring.push_back(static_cast<std::size_t>(row) * static_cast<std::size_t>(options.columns) +
                       static_cast<std::size_t>(column));
    }
  }
  return wiring;
}

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
    const std::string own = keyword_of(options.kind);
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
