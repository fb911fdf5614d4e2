#include "bench/simulation/specimen.h"

#include <stdexcept>

#include "bench/simulation/counter_noise.h"
#include "bench/simulation/specimen_film.h"

namespace tactbench::bench {

std::vector<std::string> specimen_words() { return {"paper", "harsh", "foam"}; }
std::string word_of(SpecimenKind kind) { return specimen_words().at(static_cast<std::size_t>(kind)); }

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

}  // namespace tactbench::bench
