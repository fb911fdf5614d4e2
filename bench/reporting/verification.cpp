// Verifies that a stored run is unchanged and that its analysis follows from it. Recomputes everything from the raw
// frames; writes nothing.
#include "bench/reporting/verification.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/figures/limits.h"
#include "bench/config/config.h"
#include "bench/reporting/evaluation.h"
#include "bench/reporting/evidence.h"

namespace tactbench::bench {

namespace {

class Verification {
 public:
  Verification(const db::RunStore& store, std::int64_t run) : store_(store), runs_(store), run_(run) {}

  VerifiedResult verify_fit(const db::FitRecord& fit) {
    VerifiedResult result{fit.fit, fit.run, fit.model, {}, {}, false, 0};
    if (result.compared = why_not(fit); !result.compared.empty()) return result;
    return compared(result, fit, [&](double tolerance) {
      const analysis::SensorModel& repeated = recomputed(fit);
      result.rows = repeated.taxels.size();
      return analysis::first_difference(fit.document, analysis::to_line(repeated), tolerance);
    });
  }

  VerifiedResult verify_verdicts(const std::vector<db::VerdictRecord>& verdicts) {
    VerifiedResult result{verdicts.front().fit, 0, "verdicts", {}, {}, false, verdicts.size()};
    if (result.fit == 0) {
      result.compared = "not recomputed: they were judged without a stored fit";
      return result;
    }
    const db::FitRecord fit = store_.fit(result.fit);
    result.fit_run = fit.run;
    if (store_.pruned(run_)) {
      result.compared = "not recomputed: the frames of this run were removed";
      return result;
    }
    if (result.compared = why_not(fit); !result.compared.empty()) return result;
    if (fit.run != run_) {
      const db::ContentCheck& content = content_of(fit.run);
      if (!content.holds()) {
        result.compared = "not recomputed: the run of their models has changed since it was stored";
        result.difference = fmt::format("run {}, on whose models they are based: {}", fit.run, content.difference);
        return result;
      }
    }
    bool by_laboratory = false;
    VerifiedResult verified = compared(result, fit, [&](double tolerance) {
      const std::string& toml = verdicts.front().limits_toml;
      if (db::sha256_hex(toml) != verdicts.front().limits_sha256) return std::string("the limits file kept with them");
      const analysis::Limits limits = parse_limits(toml, "the limits kept with the verdicts");
      const analysis::SensorModel& models = recomputed(fit);
      analysis::Evidence evidence =
          gather_evidence(runs_, models, {{"", analysis::evaluate(runs_.dataset(run_), models)}}, limits, true);
      const auto differs = [&](bool with_u) {
        std::vector<db::VerdictRecord> repeated;
        for (const analysis::JudgedFigure& figure : judge(evidence, limits).figures)
          repeated.push_back(analysis::record_of(figure, toml));
        return analysis::first_difference(verdicts, repeated, tolerance, with_u);
      };
      std::string difference = differs(true);
      if (difference.empty()) return difference;
      // The laboratory file is not in the store. Its dates can only withhold a verdict, and make U larger.
      evidence.runs.front().reference.overdue = true;
      by_laboratory = differs(false).empty();
      return by_laboratory ? std::string() : difference;
    });
    if (by_laboratory)
      verified.compared +=
          "; inconclusive if they depend on the reference, which was overdue according to a laboratory file that is "
          "not in the store";
    return verified;
  }

 private:
  // Same build and class of processor: same bits; otherwise 1e-12 (docs/rules.md, Runs). A result that cannot be
  // recomputed from an intact run is also a difference.
  template <class Compare>
  VerifiedResult compared(VerifiedResult& result, const db::FitRecord& fit, Compare compare) {
    const std::string& maker = fit.made_by;
    const bool same_build = maker == this_build() && maker.find("modified") == std::string::npos;
    try {
      result.recomputed = true;
      result.difference = compare(same_build ? 0.0 : analysis::kRelativeTolerance);
    } catch (const analysis::AnalysisError& error) {
      result.difference = fmt::format("cannot be recomputed: {} [{}]", error.what(), error.id());
    } catch (const sequences::FileError& error) {
      result.difference = fmt::format("cannot be recomputed: {} [{}]", error.what(), error.id());
    }
    result.compared = same_build ? "bit for bit: same build and class of processor"
                      : maker.empty()
                          ? "1e-12 relative: the fit does not record which build made it"
                          : fmt::format("1e-12 relative: the fit is of {}, this is {}", maker, this_build());
    return result;
  }

  const db::ContentCheck& content_of(std::int64_t run) {
    const auto known = contents_.find(run);
    return known != contents_.end() ? known->second : contents_.emplace(run, store_.check_content(run)).first->second;
  }

  // Empty: it can be recomputed from its run.
  std::string why_not(const db::FitRecord& fit) const {
    if (const auto pruned = store_.pruned(fit.run))
      return fmt::format("not recomputed: the frames of run {}, on which it is based, were removed on {}", fit.run,
                         pruned->pruned_utc);
    if (store_.run(fit.run).origin == "imported") return "not recomputed: it was made from an imported table";
    return why_not_dynamic(fit);
  }

  // Lag and creep come from further runs, which a copy of the run alone does not bring along.
  std::string why_not_dynamic(const db::FitRecord& fit) const {
    if (fit.model != analysis::kDynamicModel) return {};
    std::optional<analysis::SensorDynamics> dynamics;
    try {
      dynamics = analysis::document_of(fit).dynamics;
    } catch (const analysis::AnalysisError&) {
      return {};  // recomputing it says why
    }
    if (!dynamics) return "not recomputed: it does not record the runs of its lag and creep";
    for (const auto& [source, what] : {std::pair(dynamics->rate, "lag"), std::pair(dynamics->creep, "creep")}) {
      if (source.run == 0) continue;
      const std::optional<std::int64_t> run = run_of_source(store_, source);
      if (run && store_.pruned(*run))
        return fmt::format("not recomputed: the frames of run {}, source of its {}, were removed", *run, what);
      if (run) continue;
      return fmt::format(
          "not recomputed: this store does not have the source run of its {} (run {} in the original store, content "
          "{})",
          what, source.run, source.content_sha256.substr(0, 12));
    }
    return {};
  }

  // Throws AnalysisError TB-ANALYSIS-FRAME where a run's content has changed.
  analysis::SensorModel recomputed_dynamic(std::int64_t run, const analysis::SensorModel& stored) {
    // why_not_dynamic() has found those that are named in this store.
    const auto run_of = [&](const analysis::SensorDynamics::Source& source) {
      return source.run != 0 ? run_of_source(store_, source).value() : std::int64_t{0};
    };
    const std::int64_t rate = run_of(stored.dynamics->rate), creep = run_of(stored.dynamics->creep);
    for (const std::int64_t source : {rate, creep})
      if (source == 0)
        continue;
      else if (const db::ContentCheck& content = content_of(source); !content.holds())
        throw analysis::AnalysisError("TB-ANALYSIS-FRAME",
                                      fmt::format("run {}, on which it is based: {}", source, content.difference),
                                      "restore the store from a copy");
    const analysis::Dataset& fitted = runs_.dataset(run);
    analysis::SensorModel fit = rate != 0 && creep != 0
                                    ? analysis::fit_dynamic(fitted, runs_.dataset(rate), runs_.dataset(creep))
                                    : analysis::fit_dynamic_single_run(fitted);
    fit.dynamics->rate = stored.dynamics->rate;
    fit.dynamics->creep = stored.dynamics->creep;
    return fit;
  }

  const analysis::SensorModel& recomputed(const db::FitRecord& fit) {
    std::optional<analysis::SensorModel>& kept = fits_[fit.fit];
    if (kept) return *kept;
    const analysis::SensorModel stored = analysis::document_of(fit);
    if (stored.dynamics) {
      kept = recomputed_dynamic(fit.run, stored);
    } else {
      const analysis::Dataset& dataset = runs_.dataset(fit.run);
      analysis::FitOptions options;
      options.model = stored.model;
      options.identify = stored.options;
      const bool all = std::ranges::equal(stored.sequences, dataset.sequences, {}, {}, &analysis::SequenceData::name);
      if (!all) options.sequences = stored.sequences;
      options.mean_alone = stored.array().empty();
      kept = analysis::fit_array(dataset, options);
    }
    // Not contained in the frames. The run has another number in a copied store.
    kept->source = stored.source;
    kept->content_sha256 = stored.content_sha256;
    kept->program_version = stored.program_version;
    kept->validity.mount = stored.validity.mount;
    kept->validity.interface_material = stored.validity.interface_material;
    return *kept;
  }

  const db::RunStore& store_;
  analysis::Runs runs_;
  std::int64_t run_;
  std::map<std::int64_t, db::ContentCheck> contents_;
  std::map<std::int64_t, std::optional<analysis::SensorModel>> fits_;  // by number
};

}  // namespace

RunVerification verify_run(const db::RunStore& store, std::int64_t run) {
  RunVerification verified;
  verified.content = store.check_content(run);
  verified.changed_records = store.check_seals(run);
  verified.first_difference = verified.content.difference;
  if (!verified.content.holds()) return verified;
  Verification verification(store, run);
  for (const db::FitRecord& fit : store.fits(run)) verified.results.push_back(verification.verify_fit(fit));
  // By fit and limits, in the order stored.
  std::vector<std::vector<db::VerdictRecord>> judgements;
  for (const db::VerdictRecord& verdict : store.verdicts(run)) {
    const auto same = std::ranges::find_if(judgements, [&](const std::vector<db::VerdictRecord>& rows) {
      return rows.front().fit == verdict.fit && rows.front().limits_sha256 == verdict.limits_sha256;
    });
    (same == judgements.end() ? judgements.emplace_back() : *same).push_back(verdict);
  }
  for (const std::vector<db::VerdictRecord>& rows : judgements)
    verified.results.push_back(verification.verify_verdicts(rows));
  const auto differing =
      std::ranges::find_if(verified.results, [](const VerifiedResult& result) { return !result.difference.empty(); });
  if (differing != verified.results.end()) {
    verified.first_difference =
        fmt::format("{}: {}", differing->what == "verdicts" ? "verdicts" : fmt::format("fit {}", differing->fit),
                    differing->difference);
  } else if (!verified.changed_records.empty()) {
    verified.first_difference = verified.changed_records.front();
  }
  return verified;
}

}  // namespace tactbench::bench
