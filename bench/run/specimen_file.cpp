#include "bench/run/specimen_file.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "analysis/whole_file.h"
#include "bench/common/error.h"
#include "bench/rig/rig.h"
#include "bench/simulation/plant.h"

namespace tactbench::bench {

void load_specimen(Rig& rig, const std::string& file) {
  if (file.empty() || rig.plant() == nullptr || !std::filesystem::exists(file)) return;
  constexpr std::size_t kLargestState = 256'000'000;  // bytes; 64 x 64 taxels need about a hundredth
  try {
    rig.plant()->set_specimen_state(analysis::whole_file(file, {kLargestState}, "TB-SPECIMEN-STATE", ""));
  } catch (const std::exception& error) {
    throw Error("TB-SPECIMEN-STATE", fmt::format("not a specimen state: {}", error.what()), file);
  }
}

void save_specimen(Rig& rig, const std::string& file) {
  if (file.empty() || rig.plant() == nullptr) return;
  std::ofstream stream(file);
  stream << rig.plant()->specimen_state();
  if (!stream.flush()) {
    throw Error("TB-SPECIMEN-STATE", "cannot write the specimen state", file, "check folder and space");
  }
}

// A rig simulated in this process gets the recipe's object on its stage.
BenchConfig with_object(BenchConfig bench, const std::vector<sequences::Recipe>& recipes) {
  if (!bench.simulation) return bench;
  constexpr std::array<std::pair<const char*, Footprint>, 3> kObjects = {
      {{"ring", Footprint::kRing}, {"point", Footprint::kPoint}, {"flat", Footprint::kFlat}}};
  for (const sequences::Recipe& recipe : recipes) {
    for (const auto& [word, footprint] : kObjects) {
      if (recipe.press.object != word) continue;
      bench.simulation->plant.contact.object = footprint;
      return bench;
    }
  }
  return bench;
}

}  // namespace tactbench::bench
