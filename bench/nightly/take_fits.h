// Copies to a store what another store recorded about a run after its end: fits, verdicts by them, figures.
#pragma once

#include <cstddef>
#include <cstdint>

#include "db/run_store.h"

namespace tactbench::bench {

// Run `there` of `other` and run `here` of `store` have the same content. Takes the fits that `store` does not have,
// with the verdicts on this run by them, and the figures of subjects that have none here. Returns the number of fits.
// Throws StoreError TB-STORE-CONFLICT when they are not what was stored.
std::size_t take_fits(const db::RunStore& other, std::int64_t there, db::RunStore& store, std::int64_t here);

}  // namespace tactbench::bench
