#include "bench/fleet/facts.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "analysis/documents/run_json.h"
#include "analysis/error.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "analysis/judgement/figure.h"
#include "bench/reporting/evidence.h"
#include "bench/reporting/judgement.h"

namespace tactbench::bench {

namespace {

using Json = nlohmann::ordered_json;

Json verdicts_of(const db::RunStore& store, std::int64_t run) {
  Json list = Json::array();
  std::map<std::int64_t, std::vector<db::FitRecord>> fits;  // by run
  for (const db::VerdictRecord& v : store.verdicts(run)) {
    list.push_back(analysis::figure_json(analysis::figure_of(v)));
    if (v.model_run == 0) continue;
    list.back()["models_of"] = store.run(v.model_run).uuid;
    const auto [known, is_new] = fits.try_emplace(v.model_run);
    if (is_new) known->second = store.fits(v.model_run);
    list.back()["fit"] = std::ranges::find(known->second, v.fit, &db::FitRecord::fit) - known->second.begin();
  }
  return list;
}

Json rests_on(const db::RunStore& store, const db::RunRecord& run) {
  std::set<std::string> uuids;
  for (const db::VerdictRecord& verdict : store.verdicts(run.run))
    if (verdict.model_run != 0) uuids.insert(store.run(verdict.model_run).uuid);
  for (const db::FitRecord& fit : store.fits(run.run)) {
    if (fit.model != analysis::kDynamicModel) continue;
    try {
      for (const std::int64_t source : source_runs(store, analysis::load_fit(fit)))
        uuids.insert(store.run(source).uuid);
    } catch (const analysis::AnalysisError&) {  // verify reports what is wrong
    }
  }
  uuids.erase(run.uuid);
  return uuids;
}

void drop_zero_bytes(Json& json) {
  if (json.is_string())
    std::erase(json.get_ref<std::string&>(), '\0');
  else if (json.is_structured())
    for (Json& part : json) drop_zero_bytes(part);
}

Json remarks_json(const db::RunStore& store, const db::RunRecord& run) {
  Json fits = Json::array(), reports = Json::array(), figures = Json::object();
  for (const db::FitRecord& fit : store.fits(run.run))
    fits.push_back({JSON_FIELDS(fit, model, program_version, created_utc)});
  for (const db::ReportRecord& report : store.reports(run.run))
    reports.push_back({JSON_FIELDS(report, number, content_sha256, approved_by, approved_utc, replaces, reason)});
  for (const std::string& subject : store.subjects_of(run.run)) figures[subject] = store.figures_of(run.run, subject);
  const auto worst = standing(store, run.run).verdict;
  return {JSON_FIELDS(run, tags, notes, void_reason, void_by, void_utc),
          {"verdict", worst ? Json(analysis::to_string(*worst)) : Json()},
          {"fits", fits},
          {"verdicts", verdicts_of(store, run.run)},
          {"figures", figures},
          {"reports", reports}};
}

}  // namespace

std::string said_sha256(const db::RunStore& store, const db::RunRecord& run) {
  return db::sha256_hex(run.content_sha256 + analysis::printable_json(remarks_json(store, run)));
}

std::string facts_of(const db::RunStore& store, const db::RunRecord& run) {
  Json facts = analysis::run_json(run);
  facts.update(remarks_json(store, run));
  const auto sensor = store.sensor(run.sensor_serial);
  facts["sensor_type"] = sensor ? Json(sensor->type) : Json();
  facts["frames"] = store.frame_count(run.run);
  facts["rests_on"] = rests_on(store, run);
  drop_zero_bytes(facts);
  return analysis::printable_json(facts);
}

std::vector<LocalRun> ended_runs(const db::RunStore& store) {
  std::vector<LocalRun> runs;
  for (const db::RunRecord& listed : store.runs()) {
    if (listed.outcome == db::Outcome::kIncomplete || store.pruned(listed.run)) continue;
    LocalRun& own = runs.emplace_back(LocalRun{listed, {}});
    try {
      own.run = store.run(listed.run);
      own.said_sha256 = said_sha256(store, own.run);
    } catch (const db::StoreError&) {  // it counts as waiting, and sending it reports what is wrong
    }
  }
  return runs;
}

std::vector<LocalRun> waiting_runs(db::fleet::Link& link, const std::vector<LocalRun>& runs,
                                   const std::string& source) {
  std::vector<std::string> uuids;
  for (const LocalRun& own : runs)  // so that a damaged run does not prevent the query for the others
    if (own.run.uuid.find_first_not_of("0123456789abcdef-") == std::string::npos) uuids.push_back(own.run.uuid);
  std::multimap<std::string, db::fleet::KnownRow> known;  // by UUID; oldest first
  for (db::fleet::KnownRow& row : db::fleet::known_rows(link, uuids)) known.emplace(row.uuid, row);
  std::vector<LocalRun> waiting;
  for (LocalRun own : runs) {
    bool said = false, last = true;  // last: of this store's rows
    for (auto [row, end] = known.equal_range(own.run.uuid); row != end; ++row) {
      const bool same = row->second.said_sha256 == own.said_sha256;
      if (row->second.content_sha256 == own.run.content_sha256) own.content = false;
      said = said || same;
      if (row->second.source == source) last = same;
    }
    if (!(said && last)) waiting.push_back(own);
  }
  return waiting;
}

std::string source_name(const std::string& store) {
  std::array<char, 256> host{};
  if (gethostname(host.data(), host.size() - 1) != 0) host[0] = '?';
  return fmt::format("{}:{}", host.data(), std::filesystem::weakly_canonical(store).string());
}

ModelsOfVerdicts models_of_verdicts(const nlohmann::json& facts) {
  ModelsOfVerdicts models;
  for (const nlohmann::json& verdict : facts.at("verdicts")) {
    auto& [uuid, position] = models.emplace_back();
    if (!verdict.contains("models_of")) continue;
    verdict.at("models_of").get_to(uuid);
    verdict.at("fit").get_to(position);
  }
  return models;
}

void link_verdicts(db::RunStore& store, std::int64_t run, const ModelsOfVerdicts& models) {
  std::vector<std::int64_t> links;
  for (const auto& [uuid, position] : models) {
    std::int64_t& link = links.emplace_back(0);
    const std::int64_t models_run = uuid.empty() ? 0 : store.run_of_uuid(uuid);
    if (models_run == 0 || models_run == run) continue;
    const std::vector<db::FitRecord> fits = store.fits(models_run);
    if (position < fits.size()) link = fits[position].fit;
  }
  if (std::ranges::any_of(links, [](std::int64_t link) { return link != 0; })) store.link_verdicts(run, links);
}

}  // namespace tactbench::bench
