#include "bench/benchmarks/many_rigs.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "bench/benchmarks/own_program.h"

namespace tactbench::bench {

std::vector<Figure> benchmark_many_rigs(int rounds, const std::string& folder, const std::string& file) {
  const OwnProgram program(folder, file);
  std::ofstream(folder + "/rigs.toml") << "schema = 1\nname = \"rigs\"\n[[scenario]]\nname = \"rig\"\n"
                                          "about = \"one characterization\"\nrecipes = [\"production\"]\n";
  ManyRigsSpent spent;
  spent.rigs = 4 * rounds;
  const auto seconds = [&](const std::vector<std::string>& words) {
    return best_seconds(
        1, [&] { program.run(words); }, By::kEnded);
  };
  const auto bytes = [&](const char* name) {
    return static_cast<double>(std::filesystem::file_size(folder + "/" + name));
  };
  const std::string seeds = std::to_string(spent.rigs);
  for (const char* part : {"1", "2"})
    spent.carried_out_s += seconds({"nightly", "./rigs.toml", "-q", "--seeds", seeds, "--shard",
                                    fmt::format("{}/2", part), "--db", fmt::format("{}.db", part)});
  spent.merged_s = seconds({"runs", "merge", "1.db", "2.db", "--db", "all.db", "--html", "all.html"});
  spent.kept_bytes = bytes("all.db");
  spent.page_bytes = bytes("all.html");
  spent.pruning_s = seconds({"db", "prune", "--keep", "2999-01-01", "--yes", "--shrink", "--db", "all.db"});
  spent.left_bytes = bytes("all.db");
  return figures_of(spent);
}

std::vector<Figure> figures_of(const ManyRigsSpent& spent) {
  constexpr double kMillion = 1e6, kHour = 3600.0;
  const double carried_out = spent.carried_out_s / spent.rigs, merged = spent.merged_s / spent.rigs;
  const double kept = spent.kept_bytes / spent.rigs, left = spent.left_bytes / spent.rigs;
  FigureList figures("many-rigs");
  figures.add("carried_out_of_one", carried_out, "core s");
  figures.add("merge_of_one", 1e3 * merged, "core ms");
  figures.add("prune_of_one", 1e3 * spent.pruning_s / spent.rigs, "core ms");
  figures.add("store_of_one", 1e-6 * kept, "MB");
  figures.add("store_of_one_pruned", 1e-3 * left, "kB");
  figures.add("page_of_one", 1e-3 * spent.page_bytes / spent.rigs, "kB");
  figures.add("million_carried_out", kMillion * carried_out / kHour, "core h");
  figures.add("million_merge", kMillion * merged / kHour, "core h");
  figures.add("million_store", 1e-12 * kMillion * kept, "TB");
  figures.add("million_store_pruned", 1e-9 * kMillion * left, "GB");
  return figures.take();
}

}  // namespace tactbench::bench
