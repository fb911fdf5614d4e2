// Parts of a work: together all of it, no item twice.
#include "bench/common/shard.h"

#include <catch2/catch.hpp>
#include <string>

#include "bench/common/error.h"

using tactbench::bench::Error;
using tactbench::bench::Shard;
using tactbench::bench::shard_from;

TEST_CASE("shard: the parts cover each item once, and differ in size by at most one") {
  for (const int of : {1, 2, 3, 7, 8}) {
    int held = 0, least = 1080, most = 0;
    for (int number = 1; number <= of; ++number) {
      const Shard shard{number, of};
      int own = 0;
      for (std::size_t place = 0; place < 1080; ++place) {
        own += shard.holds(place) ? 1 : 0;
      }
      held += own;
      least = std::min(least, own);
      most = std::max(most, own);
    }
    CHECK(held == 1080);
    CHECK(most - least <= 1);
  }
}

TEST_CASE("shard: a part is given as K/N, anything else is rejected") {
  const Shard shard = shard_from("3/8");
  CHECK((shard.number == 3 && shard.of == 8 && shard.text() == "3/8" && !shard.is_whole()));
  CHECK(shard_from("1/1").is_whole());
  for (const char* typed :
       {"", "3", "0/8", "9/8", "-1/8", "3/", "/8", "3/8/2", "a/b", "3 / 8", "1/1001", "1/99999999999"}) {
    CAPTURE(typed);
    try {
      (void)shard_from(typed);
      FAIL("it was taken");
    } catch (const Error& error) {
      CHECK(error.id() == "TB-USAGE");
    }
  }
}
