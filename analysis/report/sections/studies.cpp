// Further studies and objects on the array, if such runs were named: one table each, objects with frames.
#include <algorithm>
#include <cmath>

#include "analysis/counted.h"
#include "analysis/report/document/document.h"
#include "analysis/report/page/chart.h"
#include "analysis/report/report_facts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

namespace {

using doc::Document;
using doc::Phrase;

void add_rate_rows(const RateHold& study, doc::Table& table) {
  for (const RateHoldRun& run : study.runs) {
    table.rows.push_back({{"rate and hold, " + run.sequence, Phrase("mean |error| ", doc::pressure(run.error.mean(), 2),
                                                                    ", largest ", doc::pressure(run.error.max))}});
    for (const auto& [bins, unit] : {std::pair{&run.by_hold, "s held"}, std::pair{&run.by_rate, "psi/s"}})
      for (const Bin& bin : *bins)
        table.rows.push_back(
            {{fmt::format("… {} to {} {}", doc::fixed_text(bin.low, 1), doc::fixed_text(bin.high, 1), unit),
              Phrase("mean |error| ", doc::pressure(bin.error.mean(), 2),
                     fmt::format(", {}", counted(bin.error.samples, "reading")))}});
  }
}

void add_crosstalk_rows(const Crosstalk& study, doc::Table& table) {
  for (const auto& [name, zone] :
       {std::pair{"in a loaded row", &study.row}, std::pair{"in a loaded column", &study.column},
        std::pair{"elsewhere", &study.elsewhere}})
    table.rows.push_back({{fmt::format("crosstalk {}, unloaded over loaded taxel", name),
                           Phrase("mean ", doc::percent_of(zone->mean_share, 2), " %, highest ",
                                  doc::percent_of(zone->max_share, 2), " %")}});
  std::string ghosts;
  for (const auto& [what, lines] : {std::pair{"row", &study.ghost_rows}, std::pair{"column", &study.ghost_columns}})
    for (const CrosstalkLine& line : *lines)
      ghosts += fmt::format("{}{} {}", ghosts.empty() ? "" : ", ", what, line.line);
  table.rows.push_back(
      {{"ghost rows and columns",
        ghosts.empty() ? Phrase("none") : Phrase(doc::StyledText{"▲ " + ghosts, doc::TextStyle::kDoubt})}});
}

const ContactLevel& highest_level(const ContactResult& contact) {
  return *std::ranges::max_element(contact.levels, {}, &ContactLevel::target_n);
}

doc::Table forces(const ContactResult& contact) {
  const double u = contact.force_uncertainty.expanded();
  doc::Table table{.id = "forces-" + std::to_string(contact.run),
                   .caption = "Total force of the array against the force sensor, centre of pressure",
                   .columns = {{"level, N", true},
                               {"force"},
                               {u > 0.0 ? "force sensor\n± U (k = 2), N" : "force sensor, N", true},
                               {"indication | force, N", true},
                               {"indication | error, N", true},
                               {"indication | off axis, mm", true},
                               {"corrected | force, N", true},
                               {"corrected | error, N", true},
                               {"corrected | off axis, mm", true},
                               {"corrected | area, mm²", true}},
                   .dense = true};
  for (const ContactLevel& level : contact.levels) {
    doc::Row row{{doc::number(level.target_n, 1), direction_text(level.rising),
                  u > 0.0 ? doc::number_with_u(level.force_n, u) : doc::number(level.force_n, 2)}};
    for (const auto& [figures, off] : {std::pair{&level.raw, level.raw_place_error_mm},
                                       std::pair{&level.compensated, level.compensated_place_error_mm}}) {
      row.cells.push_back(doc::number(figures->force_n, 2));
      row.cells.push_back(doc::number(figures->force_n - level.force_n, 2));
      row.cells.push_back(doc::number(off, 2));
    }
    row.cells.push_back(doc::number(level.compensated.area_mm2, 0));
    table.rows.push_back(std::move(row));
  }
  return table;
}

doc::Drawing force_chart(const ContactResult& contact) {
  Chart chart{.title = "Total force of the array over that of the force sensor",
              .width = 330.0,
              .height = 210.0,
              .x = {"force sensor, N", 0.0, {}},
              .y = {"array, N", 0.0, {}},
              .labels_at_ends = true};
  for (const bool corrected : {false, true})
    for (const bool rising : {true, false}) {
      Curve curve{fmt::format("{}, {}", corrected ? "corrected" : "indication", rising ? "incr." : "decr."),
                  {},
                  {},
                  kStrokes[(corrected ? 1 : 3) + (rising ? 0 : 1)]};
      for (const ContactLevel& level : contact.levels) {
        if (level.rising != rising) continue;
        curve.x.push_back(level.force_n);
        curve.y.push_back((corrected ? level.compensated : level.raw).force_n);
      }
      if (!curve.x.empty()) chart.curves.push_back(std::move(curve));
    }
  const double most = highest_level(contact).force_n;
  chart.curves.push_back({"force sensor", {0.0, most}, {0.0, most}, kBlack});
  return {chart_svg(chart), chart.title, {"Total force."}};
}

doc::Drawing frame(const ContactResult& contact, const ReportInput& input) {
  const ContactLevel& level = highest_level(contact);
  TaxelMap map{.title = "Corrected frame under the object",
               .rows = input.fit.rows,
               .columns = input.fit.columns,
               .values = level.compensated_psi,
               .size = 200.0};
  for (double& value : map.values) value = input.unit.of(value);
  for (const double value : map.values)
    if (value > map.high) map.high = value;
  return {taxel_map_svg(map),
          map.title,
          {"Corrected frame at ", doc::number(level.force_n, 1),
           fmt::format(" N: white 0, darkest {} {}.", doc::fixed_text(map.high, 0), input.unit.symbol())}};
}

Document object_part(const ContactResult& contact, const ReportInput& input) {
  Document out, left, right;
  out.add(doc::Heading{
      3, fmt::format("{}, run {}", contact.object.empty() ? contact.sequence : contact.object, contact.run), {}});
  out.add(doc::Paragraph{
      {"Error of the total force over all frames, ", counted(contact.positions, "place"), ", ",
       counted(contact.repeats, "repeat"), ": corrected ",
       doc::strong(doc::fixed_text(contact.compensated_mean_error_n, 2) + " N"), " on average, at most ",
       doc::number(contact.compensated_max_error_n, 2), " N; indication ", doc::number(contact.raw_mean_error_n, 2),
       " N, at most ", doc::number(contact.raw_max_error_n, 2), " N.",
       contact.compensated_mean_error_n > contact.raw_mean_error_n
           ? Phrase(doc::StyledText{" ▲ The corrected force is worse than the indication.", doc::TextStyle::kDoubt})
           : Phrase("")}});
  std::string u = contact.force_uncertainty.u() > 0.0
                      ? fmt::format("U of the force sensor {} N (k = 2)",
                                    doc::text_of(doc::two_digits(contact.force_uncertainty.expanded()), {}))
                      : "U of the force sensor not stated";
  for (const InstrumentRow& row : contact.force_uncertainty.rows)
    if (!row.part.missing.empty()) u += fmt::format("; without {}", row.name);
  out.add(doc::Paragraph{{contact.force_traceability, contact.force_traceability.empty() ? "" : " ", u + "."}});
  if (contact.levels.empty()) return out;
  left.add(force_chart(contact));
  if (contact.positions == 1) right.add(frame(contact, input));
  out.add(right.blocks.empty() ? doc::SideBySide{{left}, {1}} : doc::SideBySide{{left, right}, {3, 2}});
  out.add(forces(contact));
  double clamped = 0.0;
  for (const ContactLevel& level : contact.levels) clamped = std::max(clamped, level.clamped_taxels);
  if (clamped > 0.0)
    out.add(doc::Paragraph{{doc::StyledText{
        fmt::format(
            "▲ Up to {} taxels were at the highest pressure of their models: higher pressures are not measured.",
            doc::fixed_text(clamped, 1)),
        doc::TextStyle::kDoubt}}});
  return out;
}

}  // namespace

Document studies_pages(const PageData& data) {
  const Studies& studies = data.input.more.studies;
  doc::Table table{
      .id = "studies", .caption = "Further studies", .columns = {{"study"}, {"result"}}, .rows = {}, .dense = true};
  if (studies.rate_hold.assessed()) add_rate_rows(studies.rate_hold, table);
  if (studies.crosstalk.assessed()) add_crosstalk_rows(studies.crosstalk, table);
  if (studies.remount.assessed())
    table.rows.push_back(
        {{fmt::format("re-mounting, {} mounts: standard deviation", studies.remount.runs.size()),
          Phrase("between mounts ", doc::percent_of(studies.remount.s_share, 2), " % of the pressure, within one ",
                 doc::percent_of(studies.remount.within_share, 2), " %")}});
  if (studies.uniformity.assessed()) {
    table.rows.push_back({{fmt::format("uniformity of the pressure, {} angles: standard deviation over the chamber",
                                       studies.uniformity.angles_deg.size()),
                           Phrase(doc::percent_of(studies.uniformity.u_share, 2), " % of the pressure and ",
                                  doc::pressure(studies.uniformity.u_offset_psi, 3))}});
    if (studies.uniformity.residual_other_sense_psi < 0.8 * studies.uniformity.residual_rms_psi)
      table.rows.push_back(
          {{"angles", Phrase(doc::StyledText{"▲ clockwise angles fit better: were they typed with the opposite sign?",
                                             doc::TextStyle::kDoubt})}});
  }
  Document out;
  if (!table.rows.empty()) out.add(std::move(table));
  return out;
}

Document contact_pages(const PageData& data) {
  Document out;
  if (data.input.more.contacts.empty()) return out;
  const auto& contacts = data.input.more.contacts;
  const auto worst = std::ranges::max_element(contacts, {}, &ContactResult::compensated_max_error_n);
  out.add(doc::Heading{2,
                       fmt::format("Under objects the total force is off by {} N on average, at most {} N{}",
                                   doc::fixed_text(worst->compensated_mean_error_n, 2),
                                   doc::fixed_text(worst->compensated_max_error_n, 2),
                                   contacts.size() > 1 ? ", of the worst of them" : ""),
                       "objects"});
  for (const ContactResult& contact : data.input.more.contacts) out.add(object_part(contact, data.input));
  out.add(doc::Paragraph{
      {fmt::format(
          "Force of the array: sum of pressure times {} mm², the effective area of a taxel; indication: each taxel "
          "read by one straight line through the ends of the mean taxel’s loop; corrected: by its own model, unloaded "
          "before each rise. Area and centre: taxels of at least 10 % of the frame’s highest pressure. U of the "
          "array’s own "
          "force and centre is not stated: U of a reading holds under uniform pressure.",
          doc::fixed_text(data.input.more.contacts.front().geometry.taxel_area_mm2, 2))},
      doc::Paragraph::kNote});
  return out;
}

}  // namespace tactbench::analysis
