// model list: the stored models of a run, or of all runs.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/cli/session.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

struct ListedFit {
  db::FitRecord fit;
  std::string sensor, origin;
};

std::vector<ListedFit> fits_of(const db::RunStore& store, std::int64_t only) {
  std::vector<ListedFit> listed;
  if (only != 0) (void)store.run(only);  // an unknown one is an error
  for (const db::RunRecord& run : store.runs()) {
    if (only != 0 && run.run != only) continue;
    for (const db::FitRecord& fit : store.fits(run.run)) listed.push_back({fit, run.sensor_serial, run.origin});
  }
  return listed;
}

void list_models(std::int64_t run, const Session& session) {
  const std::vector<ListedFit> listed = fits_of(db::RunStore::open_read_only(session.db), run);
  if (session.json) {
    auto json = nlohmann::ordered_json::array();
    for (const ListedFit& one : listed)
      json.push_back({{"model", fmt::format("{}:{}", one.fit.run, one.fit.fit)},
                      {"run", one.fit.run},
                      {"fit", one.fit.fit},
                      {"kind", one.fit.model},
                      {"sensor", one.sensor},
                      {"origin", one.origin},
                      {"fitted_taxels", one.fit.fitted},
                      {"created", one.fit.created_utc},
                      {"program", one.fit.program_version}});
    return print_json("model.list", {{"models", json}});
  }
  tty::print("{:<10}{:<14}{:<16}{:>7}  {:<11}{}\n", "model", "kind", "sensor", "taxels", "origin", "created (UTC)");
  for (const ListedFit& one : listed)
    tty::print("{:<10}{}{}{:>7}  {:<11}{}\n", fmt::format("{}:{}", one.fit.run, one.fit.fit), cell(one.fit.model, 14),
               cell(one.sensor, 16), one.fit.fitted, one.origin, one_line(one.fit.created_utc));
  if (listed.empty())
    tty::print("{}\n", run == 0 ? "no models are stored: tactbench fit RUN makes some"
                                : fmt::format("run {0} has no models: tactbench fit {0} makes some", run));
}

}  // namespace

void add_model_list(CLI::App& model, Session& session) {
  auto run = std::make_shared<std::int64_t>(0);
  CLI::App* verb = model.add_subcommand("list", "the stored models, as RUN:FIT, oldest first");
  verb->add_option("run", *run, "of this run alone")->check(CLI::PositiveNumber);
  add_common(*verb, session);
  verb->callback([run, &session] { list_models(*run, session); });
}

}  // namespace tactbench::bench
