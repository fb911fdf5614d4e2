// The data on as found and as left, studies and objects.
#include <nlohmann/json.hpp>

#include "analysis/documents/run_json.h"
#include "analysis/json_fields.h"
#include "analysis/report/data/data.h"
#include "analysis/report/report_facts.h"

namespace tactbench::analysis {
namespace {

using MoreJson = nlohmann::ordered_json;

// A tenth of a millivolt, a thousandth of a psi.
MoreJson curve_json(const std::vector<double>& values) { return number_list(values, 5); }

MoreJson zone_json(const CrosstalkZone& zone) { return {JSON_FIELDS(zone, mean_share, u_share, max_share, samples)}; }

MoreJson lines_json(const std::vector<CrosstalkLine>& lines) {
  MoreJson out = MoreJson::array();
  for (const CrosstalkLine& line : lines) out.push_back({JSON_FIELDS(line, line, mean_share)});
  return out;
}

MoreJson bins_json(const std::vector<Bin>& bins) {
  MoreJson out = MoreJson::array();
  for (const Bin& bin : bins)
    out.push_back({JSON_FIELDS(bin, low, high),
                   {"samples", bin.error.samples},
                   {"mean_psi", bin.error.mean()},
                   {"max_psi", bin.error.max}});
  return out;
}

MoreJson figures_json(const ContactFigures& figures) {
  return {JSON_FIELDS(figures, force_n, x_mm, y_mm, moment_x_nmm, moment_y_nmm, area_mm2, threshold_psi)};
}

MoreJson uniformity_json(const Uniformity& u) {
  if (!u.assessed()) return {{"not_assessed", u.not_assessed}};
  return {{"angles_deg", u.angles_deg},
          {"pressure_psi", number_list(u.pressure_psi)},
          {"u_psi", number_list(u.u_psi)},
          {"residual_psi", number_list(u.residual_psi)},
          {"chamber_share", number_list(u.chamber_share)},
          {"chamber_psi", number_list(u.chamber_psi)},
          {"sensor_share", number_list(u.sensor_share)},
          JSON_FIELDS(u, u_share, u_offset_psi, residual_rms_psi, residual_other_sense_psi, undetermined)};
}

MoreJson remount_json(const Remount& r) {
  if (!r.assessed()) return {{"not_assessed", r.not_assessed}};
  return {{"mounts", r.runs.size()},
          {"pressure_psi", number_list(r.pressure_psi)},
          {"within_psi", number_list(r.within_psi)},
          {"between_psi", number_list(r.between_psi)},
          {"mean_between_psi", number_list(r.mean_between_psi)},
          {"taxel_between_psi", number_list(r.taxel_between_psi)},
          JSON_FIELDS(r, within_share, s_share, degrees)};
}

MoreJson crosstalk_json(const Crosstalk& c) {
  if (!c.assessed()) return {{"not_assessed", c.not_assessed}};
  return {JSON_FIELDS(c, positions, force_n, reach_pitches),
          {"row", zone_json(c.row)},
          {"column", zone_json(c.column)},
          {"elsewhere", zone_json(c.elsewhere)},
          {"ghost_rows", lines_json(c.ghost_rows)},
          {"ghost_columns", lines_json(c.ghost_columns)},
          {"distance_pitches", number_list(c.distance_pitches)},
          {"along_row_share", number_list(c.along_row_share)},
          {"along_column_share", number_list(c.along_column_share)}};
}

MoreJson instrument_json(const InstrumentUncertainty& instrument) {
  MoreJson rows = MoreJson::array();
  for (const InstrumentRow& row : instrument.rows) {
    MoreJson out = {{"source", row.name}};
    if (row.assessed()) {
      out.update({JSON_FIELDS(row, width, distribution, divisor), {"u", row.u()}});
    } else {
      out[row.part.missing.empty() ? "contained" : "not_assessed"] =
          row.part.missing.empty() ? row.part.from : row.part.missing;
    }
    rows.push_back(out);
  }
  return {{"unit", instrument.unit},
          {"certificate_covers", display_text(instrument.covers)},
          {"rows", rows},
          {"expanded", instrument.expanded()},
          {"factor", 2.0},
          {"complete", instrument.complete()}};
}

MoreJson contact_json(const ContactResult& contact) {
  MoreJson levels = MoreJson::array();
  for (const ContactLevel& level : contact.levels)
    levels.push_back({JSON_FIELDS(level, target_n, rising, frames, force_n, torque_nmm),
                      {"raw", figures_json(level.raw)},
                      {"compensated", figures_json(level.compensated)},
                      JSON_FIELDS(level, raw_force_error_n, compensated_force_error_n, raw_place_error_mm,
                                  compensated_place_error_mm, raw_wander_mm, compensated_wander_mm, clamped_taxels),
                      {"raw_std_fs", level.raw_std},
                      {"compensated_std_fs", level.compensated_std},
                      {"raw_v", curve_json(level.raw_v)},
                      {"compensated_psi", curve_json(level.compensated_psi)}});
  return {JSON_FIELDS(contact, sequence, object, force_traceability),
          {"force_uncertainty", instrument_json(contact.force_uncertainty)},
          JSON_FIELDS(contact, positions, repeats),
          {"registered", contact.mount_run != 0},
          JSON_FIELDS(contact.geometry, pitch_mm, taxel_area_mm2),
          JSON_FIELDS(contact, full_scale_v, full_scale_psi, raw_mean_error_n, raw_max_error_n,
                      compensated_mean_error_n, compensated_max_error_n),
          {"raw_distance_fs", number_list(contact.raw_distance)},
          {"compensated_distance_fs", number_list(contact.compensated_distance)},
          {"levels", levels}};
}

}  // namespace

std::string as_found_json(const ReportInput& input) {
  MoreJson found;
  if (const std::optional<AsFound>& previous = input.more.previous) {
    found["fitted_taxels"] = previous->fitted_taxels;
    found.update(whole_evaluation_json(previous->evaluation, previous->fitted_taxels));
    MoreJson verdicts = MoreJson::array();
    for (const JudgedFigure& figure : previous->judgement.figures) verdicts.push_back(figure_json(figure));
    found["verdicts"] = std::move(verdicts);
    found["overall"] = verdict_text(previous->judgement.overall);
    found["doubt"] = previous->doubt;
  }
  return json_text(found);
}

std::string studies_json(const ReportInput& input) {
  const Studies& studies = input.more.studies;
  MoreJson rate_hold;
  if (studies.rate_hold.assessed()) {
    rate_hold = MoreJson::array();
    for (const RateHoldRun& run : studies.rate_hold.runs)
      rate_hold.push_back({{"sequence", run.sequence},
                           {"mean_psi", run.error.mean()},
                           {"max_psi", run.error.max},
                           {"samples", run.error.samples},
                           JSON_FIELDS(run, output_max_share, output_mean_share),
                           {"by_hold_s", bins_json(run.by_hold)},
                           {"by_rate_psi_per_s", bins_json(run.by_rate)}});
  } else {
    rate_hold = {{"not_assessed", studies.rate_hold.not_assessed}};
  }
  return json_text({{"crosstalk", crosstalk_json(studies.crosstalk)},
                    {"rate_hold", rate_hold},
                    {"remount", remount_json(studies.remount)},
                    {"uniformity", uniformity_json(studies.uniformity)}});
}

std::string objects_json(const ReportInput& input) {
  MoreJson contacts = MoreJson::array();
  for (const ContactResult& contact : input.more.contacts) contacts.push_back(contact_json(contact));
  return json_text(contacts);
}

}  // namespace tactbench::analysis
