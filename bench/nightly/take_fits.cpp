#include "bench/nightly/take_fits.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

namespace tactbench::bench {
namespace {

bool same_fit(const db::FitRecord& a, const db::FitRecord& b) {
  const auto said = [](const db::FitRecord& fit) {
    return std::tie(fit.model, fit.stands, fit.fitted, fit.document, fit.made_by, fit.program_version, fit.created_utc);
  };
  return said(a) == said(b);
}

void take_figures(const db::RunStore& other, std::int64_t there, db::RunStore& store, std::int64_t here) {
  const std::set<std::string> known = [&] {
    const std::vector<std::string> subjects = store.subjects_of(here);
    return std::set(subjects.begin(), subjects.end());
  }();
  for (const std::string& subject : other.subjects_of(there)) {
    if (known.contains(subject)) continue;
    store.replace_figures(here, subject, other.figures_of(there, subject));
  }
}

}  // namespace

std::size_t take_fits(const db::RunStore& other, std::int64_t there, db::RunStore& store, std::int64_t here) {
  if (const std::vector<std::string> wrong = other.check_seals(there); !wrong.empty())
    throw db::StoreError("TB-STORE-CONFLICT",
                         fmt::format("store {}: run {} is not what was stored: {}", other.path(), there, wrong.front()),
                         "tactbench verify RUN, and take the last snapshot");
  const std::vector<db::FitRecord> known = store.fits(here);
  std::map<std::int64_t, std::int64_t> taken;
  for (db::FitRecord fit : other.fits(there)) {
    if (std::ranges::any_of(known, [&](const db::FitRecord& own) { return same_fit(own, fit); })) continue;
    const std::int64_t number = fit.fit;
    fit.run = here;
    taken[number] = store.add_fit(fit);
  }
  std::map<std::pair<std::int64_t, std::string>, std::vector<db::VerdictRecord>> judged;  // by fit and limits
  for (const db::VerdictRecord& verdict : other.verdicts(there))
    if (taken.contains(verdict.fit)) judged[{verdict.fit, verdict.limits_sha256}].push_back(verdict);
  for (const auto& [by, verdicts] : judged) store.replace_verdicts(here, taken.at(by.first), verdicts);
  take_figures(other, there, store, here);
  return taken.size();
}

}  // namespace tactbench::bench
