// Fits that older programs stored are what this one makes of the same frames, and their documents can be read.
#include <catch2/catch.hpp>
#include <filesystem>

#include "analysis/identify/stored/fit_rows.h"
#include "analysis/identify/stored/model_document.h"
#include "db/run_store.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench::analysis;
using namespace tactbench::tests;
namespace db = tactbench::db;

namespace {

db::RunStore store_of(const TemporaryFolder& folder, int version) {
  const std::string name = "version_" + std::to_string(version) + ".db";
  std::filesystem::copy_file(source_path("tests/db/stores/" + name), folder.path(name));
  return db::RunStore::open(folder.path(name));
}

}  // namespace

TEST_CASE("the fits in rows of older stores are recomputed from their frames") {
  for (const int version : {3, 4, 5, 6}) {
    INFO("schema " << version);
    const TemporaryFolder folder;
    const db::RunStore store = store_of(folder, version);
    const db::FitRecord record = store.fit(1);
    REQUIRE(record.model == kElamFit);
    const FitRows stored{record, store.fit_taxels(1)};
    FitOptions options;
    options.identify = options_of(record);
    CHECK(first_difference(stored, rows_of(fit_array(load_dataset(store, 1), options)), kRelativeTolerance).empty());
    // Read and written again they are the same rows, bit for bit.
    CHECK(first_difference(stored, rows_of(load_fit(store, record)), 0.0).empty());
    CHECK(load_fit(store, 1).fitted().size() == 256);
  }
}

TEST_CASE("documents of an older store can be read, with the loop computed where they hold none") {
  const TemporaryFolder folder;
  const db::RunStore store = store_of(folder, 6);
  const SensorModel gpi = load_fit(store, store.fit(2)), elam = load_fit(store, store.fit(3));
  CHECK((gpi.model == "gpi" && gpi.run == 1 && gpi.fit == 2));
  CHECK((elam.model == "elam" && elam.validity.mount == "film"));
  for (const SensorModel* model : {&gpi, &elam}) {
    REQUIRE(model->taxels.size() == 1);
    const ModelTaxel& mean = model->mean_taxel();
    CHECK(mean.fitted());
    CHECK(mean.full_scale() == Approx(3.43).epsilon(0.01));
    CHECK((mean.x0() == 0.0 && mean.xu() == 60.0));
    CHECK(mean.descending(40.0) > mean.ascending(40.0));
  }
}
