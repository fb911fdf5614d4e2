// Annexes on demand: tables and maps of the data, without prose.
#include <algorithm>
#include <cmath>

#include "analysis/report/document/document.h"
#include "analysis/report/page/chart.h"
#include "analysis/report/report_facts.h"
#include "analysis/report/sections/sections.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {

namespace {

using doc::Document;
using doc::Phrase;

Document annex_of_maps(const PageData& data) {
  Document out;
  if (!data.readings) return out;
  const ReadingFigures& readings = *data.readings;
  const PressureUnit unit = data.input.unit;
  out.add(doc::Paragraph{
      {"White: a tenth of ", doc::both_units(readings.tolerance_psi), " or less; darkest: four times it."}});
  doc::SideBySide row;
  for (const ReadingLevel& level : readings.levels) {
    TaxelMap map{.title = fmt::format("|error| + U at {}, {}", doc::text_of(doc::pressure(level.pressure_psi), unit),
                                      direction_text(level.up)),
                 .rows = data.input.health.rows,
                 .columns = data.input.health.columns,
                 .values = {},
                 .low = 0.1 * unit.of(readings.tolerance_psi),
                 .high = 4.0 * unit.of(readings.tolerance_psi),
                 .logarithmic = true,
                 .size = 150.0,
                 .counted = false};
    for (std::size_t i = 0; i < level.error_psi.size(); ++i) map.values.push_back(unit.of(level.sum_psi(i)));
    Document part;
    part.add(doc::Drawing{taxel_map_svg(map), map.title, {map.title}});
    row.parts.push_back(std::move(part));
    if (row.parts.size() == 4) out.add(std::exchange(row, {}));
  }
  if (!row.parts.empty()) {
    row.parts.resize(4);
    out.add(std::move(row));
  }
  return out;
}

Document annex_of_taxels(const PageData& data) {
  const ReportInput& input = data.input;
  const std::vector<TaxelHealth>& findings = input.health.findings;
  doc::Table table{.id = "annex-taxels",
                   .caption = fmt::format("Each taxel; pressures in {}, the largest |error| + U over the levels",
                                          input.unit.symbol()),
                   .columns = {{"taxel"},
                               {"state"},
                               {"mean |error|", true},
                               {"|error| + U", true},
                               {"sensitivity", true},
                               {"hysteresis, % FS", true},
                               {"noise, mV", true}},
                   .dense = true};
  const auto at = [](const std::vector<double>& values, std::size_t i) { return i < values.size() ? values[i] : kNan; };
  for (std::size_t i = 0; i < static_cast<std::size_t>(input.health.rows * input.health.columns); ++i) {
    std::string state;
    for (const TaxelHealth& finding : findings)
      if (finding.taxel == static_cast<int>(i))
        state += (state.empty() ? "" : ", ") + finding.state + ": " + finding.reason;
    double most = kNan;
    if (data.readings)
      for (const ReadingLevel& level : data.readings->levels)
        if (const double sum = level.sum_psi(i); std::isfinite(sum))
          most = std::isnan(most) ? sum : std::max(most, sum);
    table.rows.push_back(
        {{doc::Taxel{static_cast<int>(i), input.health.columns}, state.empty() ? "used" : state,
          doc::bare_pressure(at(input.evaluation.taxel_mean_error_psi, i), 2), doc::bare_pressure(most),
          doc::number(at(input.behaviour.gain, i), 3), doc::percent_of(at(input.behaviour.hysteresis_mean, i), 1),
          doc::number(1e3 * at(input.health.noise_v, i), 2)}});
  }
  Document out;
  out.add(std::move(table));
  return out;
}

// The models: how closely each follows the run from which it was made.
Document annex_of_models(const PageData& data) {
  const SensorModel& fit = data.input.fit;
  Document out;
  if (fit.taxels.empty()) return out;
  doc::Table table{
      .id = "annex-models",
      .caption = model_name(fit) + ": the direct model against the output of the run that it was made from",
      .columns = {{"taxel"},
                  {"full scale, V", true},
                  {"mean error, mV", true},
                  {"largest error, mV", true},
                  {"J, V²", true},
                  {"parameters at a bound"}},
      .dense = true};
  const auto row = [&](const ModelTaxel& taxel, const Phrase& name) {
    if (!taxel.fitted()) return;
    table.rows.push_back({{name, doc::number(taxel.full_scale(), 3), doc::number(1e3 * taxel.fit.mean_error, 1),
                           doc::number(1e3 * taxel.fit.max_error, 1), doc::number(taxel.fit.j, 3),
                           taxel.fit.at_bound != 0 ? "▲ yes" : "no"}});
  };
  row(fit.mean_taxel(), "mean of all");
  for (std::size_t i = 0; i < fit.array().size(); ++i) row(fit.taxels[i], doc::Taxel{static_cast<int>(i), fit.columns});
  out.add(std::move(table));
  return out;
}

Document annex_of_parameters(const PageData& data) {
  const SensorModel& fit = data.input.fit;
  Document out;
  if (fit.taxels.empty() || fit.mean_taxel().fit.model == nullptr) return out;
  doc::Table table{
      .id = "annex-parameters", .caption = "Parameters of " + model_name(fit), .columns = {{"taxel"}}, .dense = true};
  const auto parameters = fit.mean_taxel().fit.model->parameters();
  constexpr std::size_t kMostColumns = 12;  // Preisach has hundreds of weights, which are only in the data
  const std::size_t shown = std::min(parameters.size(), kMostColumns);
  for (std::size_t i = 0; i < shown; ++i) table.columns.push_back({parameters[i].name, true});
  const auto row = [&](const ModelTaxel& taxel, const Phrase& name) {
    if (!taxel.fitted()) return;
    doc::Row cells{{name}};
    const auto own = taxel.fit.model->parameters();
    for (std::size_t i = 0; i < std::min(shown, own.size()); ++i) cells.cells.push_back(doc::number(own[i].value, 4));
    table.rows.push_back(std::move(cells));
  };
  row(fit.mean_taxel(), "mean of all");
  for (std::size_t i = 0; i < fit.array().size(); ++i) row(fit.taxels[i], doc::Taxel{static_cast<int>(i), fit.columns});
  out.add(std::move(table));
  return out;
}

Document annex_of_events(const PageData& data) {
  const ReportInput& input = data.input;
  Document out;
  doc::Table events{.id = "annex-events",
                    .caption = "Pauses, retries and warnings",
                    .columns = {{"time, s", true}, {"kind"}, {"what"}},
                    .dense = true};
  for (const RunLogEvent& event : input.history.events)
    events.rows.push_back({{doc::number(event.time_s, 0), event.kind, doc::stated(event.text)}});
  doc::Table voids{.id = "annex-voids",
                   .caption = "Void branches: kept in the store, left out of every figure, and repeated",
                   .columns = {{"sequence"}, {"repeat", true}, {"branch", true}, {"attempt", true}, {"reason"}},
                   .dense = true};
  for (const VoidBranch& own : input.history.voids)
    voids.rows.push_back({{doc::stated(own.sequence), std::to_string(own.repeat + 1), std::to_string(own.branch + 1),
                           std::to_string(own.attempt + 1), doc::stated(own.reason)}});
  for (doc::Table* table : {&events, &voids}) {
    if (table->rows.empty()) table->rows.push_back({{"none"}});
    out.add(std::move(*table));
  }
  return out;
}

Document annex_of_hashes(const PageData& data) {
  const ReportInput& input = data.input;
  const db::RunRecord& run = input.run;
  std::vector<std::pair<std::string, Phrase>> rows = {
      {"run", std::to_string(run.run)},
      {"UUID", doc::code_text(run.uuid)},
      {"computer", doc::stated(run.host)},
      {"seeds", fmt::format("noise and faults {}, sensor {}", run.seed, run.sensor_seed)},
      {"settings changed on the command line", doc::code_text(run.overrides_json)},
      {"program of the run", fmt::format("{}, commit {}{}; {}", run.program_version, run.git_commit,
                                         run.git_dirty ? " (dirty)" : "", run.build_id)},
      {"program of this report", input.program_version},
      {"run's content", doc::code_text(run.content_sha256)},
      {"bench file", doc::code_text(run.bench_sha256)},
      {"sensor file", doc::code_text(run.sensor_sha256)},
      {"models", doc::code_text(input.fit.taxels.empty() ? "" : model_sha256(input.fit))},
      {"limits file", doc::code_text(input.judgement.limits_sha256)},
      {"laboratory file", doc::code_text(input.laboratory.sha256)}};
  for (const db::SequenceRecord& sequence : run.sequences)
    rows.emplace_back("recipe " + sequence.name, doc::code_text(sequence.recipe_sha256));
  Document out;
  out.add(doc::pairs("Program, files, SHA-256", std::move(rows)));
  return out;
}

}  // namespace

Document annex(const PageData& data, const std::string& name) {
  using Maker = Document (*)(const PageData&);
  static constexpr std::pair<std::string_view, Maker> kMakers[] = {
      {"maps", annex_of_maps},     {"taxels", annex_of_taxels},
      {"models", annex_of_models}, {"parameters", annex_of_parameters},
      {"events", annex_of_events}, {"hashes", annex_of_hashes}};
  Document out;
  const auto* const maker = std::ranges::find(kMakers, name, &std::pair<std::string_view, Maker>::first);
  if (maker == std::end(kMakers)) return out;
  out.add(doc::PageBreak{});
  out.add(doc::Heading{2, "Annex: " + name, "annex-of-" + name});
  Document own = maker->second(data);
  if (own.blocks.empty()) own.add(doc::Paragraph{{"not available"}});
  out.add(std::move(own));
  return out;
}

}  // namespace tactbench::analysis
