#include "bench/reporting/study_roles.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "bench/common/error.h"
#include "bench/run/run_record.h"

namespace tactbench::bench {

namespace {

struct Recorded {
  std::string value, where;  // "90", "simulation.turned_in_chamber_deg"
};

std::optional<Recorded> metadata_of(const db::RunRecord& run, std::string_view key) {
  for (const std::string& tag : run.tags)
    if (tag.size() > key.size() && tag.starts_with(key) && tag[key.size()] == '=')
      return Recorded{tag.substr(key.size() + 1), fmt::format("its tag {}", tag)};
  return std::nullopt;
}

std::optional<SpecimenOptions> specimen_of(const db::RunRecord& run) {
  if (run.origin != "simulated") return std::nullopt;
  const std::optional<BenchConfig> bench = stored_bench(run);
  if (!bench || !bench->simulation) return std::nullopt;
  return bench->simulation->plant.specimen;
}

std::optional<Recorded> turn_of(const db::RunRecord& run) {
  if (std::optional<Recorded> stated = metadata_of(run, "turned")) return stated;
  const std::optional<SpecimenOptions> specimen = specimen_of(run);
  if (!specimen) return std::nullopt;
  return Recorded{fmt::format("{:g}", specimen->turned_in_chamber_deg),
                  fmt::format("simulation.turned_in_chamber_deg = {:g}", specimen->turned_in_chamber_deg)};
}

std::optional<Recorded> mount_of(const db::RunRecord& run) {
  if (std::optional<Recorded> stated = metadata_of(run, "mount")) return stated;
  const std::optional<SpecimenOptions> specimen = specimen_of(run);
  if (!specimen) return std::nullopt;
  return Recorded{std::to_string(specimen->mount_seed),
                  fmt::format("simulation.mount_seed = {}", specimen->mount_seed)};
}

std::optional<double> degrees_in(const Recorded& recorded) {
  double value = 0.0;
  const char* const end = recorded.value.data() + recorded.value.size();
  const auto [stopped, error] = std::from_chars(recorded.value.data(), end, value);
  return error == std::errc() && stopped == end ? std::optional(value) : std::nullopt;
}

[[noreturn]] void refuse(const StudyRun& study, const std::string& what, const std::string& remedy) {
  throw Error("TB-REPORT-STUDY", what, fmt::format("--studies {}:{}", study.run, study.role), remedy);
}

// Turned against the report's own run, 0 to 360 degrees; none where the run does not record it.
std::optional<double> turned_against(const db::RunRecord& own, const Recorded& recorded) {
  const std::optional<double> there = degrees_in(recorded);
  if (!there) return std::nullopt;
  const std::optional<Recorded> ours = turn_of(own);
  const double here = ours ? degrees_in(*ours).value_or(0.0) : 0.0;
  return std::fmod(std::fmod(*there - here, 360.0) + 360.0, 360.0);
}

}  // namespace

void check_role(const StudyRun& study, const db::RunRecord& own, const db::RunRecord& other, StudyPurpose purpose) {
  if (study.role.empty()) return;
  if (purpose != StudyPurpose::kPlainLoops)
    refuse(
        study,
        fmt::format("run {} {}, by its own recipe: it is no run of a study of {}", study.run,
                    purpose == StudyPurpose::kPresses ? "presses an object" : "goes at several rates or holds levels",
                    study.role == "mount" ? "mounts" : "turns"),
        fmt::format("its recipe shows its purpose: --studies {}", study.run));
  const std::optional<Recorded> turned = turn_of(other);
  const std::optional<double> degrees = turned ? turned_against(own, *turned) : std::nullopt;
  const double stated = study.role == "mount" ? 0.0 : std::stod(study.role);
  if (degrees && std::abs(*degrees - stated) > 1e-6)
    refuse(
        study,
        fmt::format("run {} was turned by {:g} degrees against run {}, by its own record ({}){}", study.run, *degrees,
                    own.run, turned->where, study.role == "mount" ? "" : fmt::format(", not by {:g}", stated)),
        fmt::format("state what was done: {}:{:g}", study.run, *degrees));
  if (study.role != "mount") return;
  const std::optional<Recorded> ours = mount_of(own), theirs = mount_of(other);
  if (ours && theirs && ours->value == theirs->value)
    refuse(study,
           fmt::format("run {} was not mounted anew, by its own record: {}, as in run {}", study.run, theirs->where,
                       own.run),
           fmt::format("name runs of another mount; to see models on this run: --held-out {}", study.run));
}

}  // namespace tactbench::bench
