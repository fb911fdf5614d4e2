// Metadata of the command line as tags, at the length that a tag may have, and as a filter.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/cli/runs/metadata_options.h"
#include "db/record.h"
#include "tests/support/refusal.h"

using namespace tactbench;
using bench::MetadataOptions;

namespace {

using Tags = std::vector<std::string>;

std::string metadata_refusal(const MetadataOptions& options) {
  const auto error = tests::refusal_by([&] { (void)bench::metadata_tags(options); });
  return error ? error->id() + " at " + error->where() : "";
}

MetadataOptions with_pairs(const Tags& pairs) {
  MetadataOptions options;
  options.pairs = pairs;
  return options;
}

}  // namespace

TEST_CASE("metadata tags: lot and order first, then the pairs in their order") {
  MetadataOptions options = with_pairs({"film=B12", "a.b_c:/+-Z9=x=y"});
  CHECK_FALSE(metadata_refusal(options).empty());  // no sign of equality in a value
  options.pairs = {"film=B12", "a.b_c:/+-Z9=0aZ._:/+-"};
  options.lot = "A7";
  options.order = "55/26";
  CHECK(bench::metadata_tags(options) == Tags{"lot=A7", "order=55/26", "film=B12", "a.b_c:/+-Z9=0aZ._:/+-"});
  CHECK(bench::metadata_tags({}).empty());
  CHECK(bench::metadata_tags(with_pairs({"k=" + std::string(62, 'x')})).size() == 1);  // 64 characters
}

TEST_CASE("metadata tags: what cannot be kept, with its option") {
  for (const std::string& pair : Tags{"=x", "a=", "a b=x", "a=x y", "a=\xC3\xA4", "a@=x", "a[=x", "a`=x", "a{=x", "a=;",
                                      "a=,", "k=" + std::string(63, 'x'), "film"})
    CHECK(metadata_refusal(with_pairs({pair})) == "TB-USAGE at --meta");
  MetadataOptions lot, order;
  lot.lot = "a b";
  CHECK(metadata_refusal(lot) == "TB-USAGE at --lot");
  order.order = "#";
  CHECK(metadata_refusal(order) == "TB-USAGE at --order");
  CHECK(metadata_refusal(with_pairs({"a=1", "b=1", "a=2"})) == "TB-USAGE at --meta");
  MetadataOptions both = with_pairs({"lot=1"});
  both.lot = "1";
  CHECK(metadata_refusal(both) == "TB-USAGE at --meta");
  both = with_pairs({"order=1"});
  both.order = "1";
  CHECK(metadata_refusal(both) == "TB-USAGE at --meta");
}

TEST_CASE("metadata as a filter: all that is asked for must be there, a key alone with any value") {
  db::RunRecord run;
  run.tags = {"film=B12", "lot=A7", "night", "order=55/26"};
  const auto fits = [&](const std::string& lot, const std::string& order, const Tags& pairs) {
    MetadataOptions asked = with_pairs(pairs);
    asked.lot = lot;
    asked.order = order;
    return bench::fits_metadata(asked, run);
  };
  CHECK(fits("", "", {}));
  CHECK(fits("A7", "55/26", {"film=B12", "film", "lot=A7"}));
  CHECK_FALSE(fits("A8", "", {}));
  CHECK_FALSE(fits("", "55", {}));
  CHECK_FALSE(fits("A7", "55", {}));
  CHECK_FALSE(fits("A8", "55/26", {}));
  CHECK_FALSE(fits("A7", "55/26", {"film=B13"}));
  CHECK_FALSE(fits("", "", {"film", "station"}));
  CHECK_FALSE(fits("", "", {"night"}));  // a tag, no metadata
  CHECK_FALSE(fits("", "", {"station=left"}));
}
