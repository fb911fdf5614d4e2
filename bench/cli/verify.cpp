// Is a stored run still what was measured, and does its analysis follow from it? Everything is recomputed from the raw
// frames; nothing is written.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/identify/fit_rows.h"
#include "analysis/statistics/evaluation.h"
#include "analysis/statistics/limits.h"
#include "bench/cli/evaluation.h"
#include "bench/cli/verify.h"
#include "bench/config.h"

namespace tactbench::bench {

namespace {

class Verification {
 public:
  Verification(const db::RunStore& store, std::int64_t run) : store_(store), run_(run) {}

  VerifiedResult verify_fit(const db::FitRecord& fit) {
    VerifiedResult result{fit.fit, fit.run, fit.model, {}, {}, false, 0};
    if (fit.model != analysis::kElamFit) {
      result.compared = "not recomputed: it is kept as a document, not as rows";
      return result;
    }
    return compared(result, fit, [&](double tolerance) {
      const analysis::FitRows stored{fit, store_.fit_taxels(fit.fit)};
      result.rows = stored.taxels.size();
      return analysis::first_difference(stored, analysis::rows_of(recomputed(fit)), tolerance);
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
    if (fit.model != analysis::kElamFit) {
      result.compared = "not recomputed: their fit is kept as a document, not as rows";
      return result;
    }
    if (fit.run != run_) {
      const db::ContentCheck content = store_.check_content(fit.run);
      if (!content.holds()) {
        result.compared = "not recomputed: the run of their models is not what was stored";
        result.difference = fmt::format("run {}, whose models they rest on: {}", fit.run, content.difference);
        return result;
      }
    }
    return compared(result, fit, [&](double tolerance) {
      const std::string& toml = verdicts.front().limits_toml;
      if (db::sha256_hex(toml) != verdicts.front().limits_sha256) return std::string("the limits file kept with them");
      const analysis::Limits limits = parse_limits(toml, "the limits kept with the verdicts");
      const analysis::ArrayFit& models = recomputed(fit);
      const analysis::Evaluation evaluation = analysis::evaluate(analysis::load_dataset(store_, run_), models);
      return analysis::first_difference(verdicts, judge_anew(store_, models, evaluation, limits), tolerance);
    });
  }

 private:
  // contract.md, "Runs": same build and class of processor, same bits; otherwise 1e-12. What cannot be recomputed from
  // an intact run is a difference, too.
  template <class Compare>
  VerifiedResult compared(VerifiedResult& result, const db::FitRecord& fit, Compare compare) {
    const std::string maker = analysis::made_by(fit);
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
                          ? "1e-12 relative: the fit does not say which build made it"
                          : fmt::format("1e-12 relative: the fit is of {}, this is {}", maker, this_build());
    return result;
  }

  const analysis::ArrayFit& recomputed(const db::FitRecord& fit) {
    const analysis::ElamOptions elam = analysis::options_of(fit);
    auto& kept = fits_[{fit.run, elam.exact_outer}];
    if (!kept) {
      analysis::ArrayFitOptions options;
      options.elam = elam;
      kept = analysis::fit_array(analysis::load_dataset(store_, fit.run), options);
    }
    return *kept;
  }

  const db::RunStore& store_;
  std::int64_t run_;
  std::map<std::pair<std::int64_t, bool>, std::optional<analysis::ArrayFit>> fits_;
};

}  // namespace

RunVerification verify_run(const db::RunStore& store, std::int64_t run) {
  RunVerification verified;
  verified.content = store.check_content(run);
  verified.first_difference = verified.content.difference;
  if (!verified.content.holds()) return verified;
  Verification verification(store, run);
  for (const db::FitRecord& fit : store.fits(run)) verified.results.push_back(verification.verify_fit(fit));
  const std::vector<db::VerdictRecord> verdicts = store.verdicts(run);
  if (!verdicts.empty()) verified.results.push_back(verification.verify_verdicts(verdicts));
  const auto differing =
      std::ranges::find_if(verified.results, [](const VerifiedResult& result) { return !result.difference.empty(); });
  if (differing != verified.results.end()) {
    verified.first_difference =
        fmt::format("{}: {}", differing->what == "verdicts" ? "verdicts" : fmt::format("fit {}", differing->fit),
                    differing->difference);
  }
  return verified;
}

namespace {

nlohmann::ordered_json result_json(const VerifiedResult& result) {
  return {{"what", result.what},
          {"fit", result.fit},
          {"fit_run", result.fit_run},
          {"rows", result.rows},
          {"recomputed", result.recomputed},
          {"compared", result.compared},
          {"difference", result.difference}};
}

void print_result(const VerifiedResult& result) {
  const std::string name = result.what == "verdicts" ? fmt::format("{} verdicts", result.rows)
                                                     : fmt::format("fit {} ({})", result.fit, result.what);
  const std::string state = !result.difference.empty() ? fmt::format("DIFFER: {}", result.difference)
                            : result.recomputed        ? "equal"
                                                       : "";
  fmt::print("  {:<14}{}{}{}\n", name, state, state.empty() ? "" : "; ", result.compared);
}

void verify(std::int64_t number, Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  const db::RunRecord run = store.run(number);
  if (run.outcome == db::Outcome::kIncomplete) {
    throw Error(ExitCode::kInconclusive, "TB-VERIFY-NOT-ENDED",
                fmt::format("run {} has not ended: it has no hash to compare with yet", number), session.db,
                "wait for its end; a run whose process died is closed at the next start of a run");
  }
  const RunVerification verified = verify_run(store, number);
  const auto& [content, results, first] = verified;
  if (!content.holds()) {
    session.code = ExitCode::kStore;
  } else if (!first.empty()) {
    session.code = ExitCode::kCriterionFailed;
  }
  if (session.json) {
    auto list = nlohmann::ordered_json::array();
    for (const VerifiedResult& result : results) list.push_back(result_json(result));
    print_json("verify", {{"run", number},
                          {"origin", run.origin},
                          {"holds", first.empty()},
                          {"first_difference", first},
                          {"content",
                           {{"holds", content.holds()},
                            {"frames", content.frames},
                            {"stored_sha256", content.stored_sha256},
                            {"computed_sha256", content.computed_sha256}}},
                          {"analysis", list}});
    return;
  }
  fmt::print("run {} ({}), {} frames\n", number, run.origin, content.frames);
  if (content.holds()) {
    fmt::print("  {:<14}as it was stored, sha256 {}\n", "content", content.computed_sha256);
  } else {
    fmt::print("  {:<14}DIFFERS: {}\n  {:<14}stored sha256 {}, recomputed {}; the analysis was not looked at\n",
               "content", content.difference, "", content.stored_sha256, content.computed_sha256);
  }
  for (const VerifiedResult& result : results) print_result(result);
  if (content.holds() && results.empty()) fmt::print("  {:<14}no stored fit, no verdict\n", "analysis");
  fmt::print("{}\n", first.empty() ? "verified" : fmt::format("NOT verified; first difference: {}", first));
}

}  // namespace

void add_verify(CLI::App& app, Session& session) {
  auto number = std::make_shared<std::int64_t>(0);
  CLI::App* verb = app.add_subcommand(
      "verify", "recompute a run's content hash and its analysis from the raw frames; name the first difference");
  verb->add_option("run", *number, "run number")->required();
  verb->footer("Exit codes: 0 all as stored, 1 a fit or verdict differs, 5 the run's content differs, 6 not ended.");
  add_common(*verb, session);
  verb->callback([number, &session] { verify(*number, session); });
}

}  // namespace tactbench::bench
