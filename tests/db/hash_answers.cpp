// Hashes as a second implementation of the bytes under a link (hash_chain.h), in another language, gives them. It was
// held against the stores of tests/db/stores first, whose links and contents it finds.
#include <openssl/evp.h>

#include <catch2/catch.hpp>
#include <limits>

#include "db/hash_chain.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::HashChain;

namespace {

db::BranchRecord fourth_attempt() {
  db::BranchRecord branch;
  branch.sequence = 1;
  branch.repeat = 2;
  branch.ordinal = 3;
  branch.attempt = 4;
  branch.from_psi = 0.5;
  return branch;
}

}  // namespace

TEST_CASE("the content of a run hashes to what another program finds") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"));
  const std::int64_t run = store_example(store);
  CHECK(store.run(run).content_sha256 == "058012ec21c9467134fc0dc98492780abafd573ad5ed9fa7f15e0181a6779295");
}

TEST_CASE("header and frames hash to what another program finds") {
  HashChain chain;
  const db::Digest header = chain.header(example_run());
  CHECK(db::hex(header) == "b50aae7688d59992466f0454025f289c15a320d866dbf20c7c3214f7f891f273");
  CHECK(db::hex(chain.frame(header, example_branch(), example_frame(0, 0))) ==
        "79d87add49a56d1d510247fee4b26d545b5045e18a938173fa8e867eff2b6629");
  // Without flags, trace, wrench and counts, and with a pressure that is no number.
  db::FrameRecord bare = example_frame(0, 0);
  bare.feedback_psi = -std::numeric_limits<double>::quiet_NaN();
  bare.counts.clear();
  bare.flags.clear();
  bare.trace.clear();
  bare.wrench.reset();
  CHECK(db::hex(chain.frame({}, fourth_attempt(), bare)) ==
        "0873c62e582ec4fbf2e7c96fe3198705252d535ce2f7734d1b5e29427c06030a");
}

TEST_CASE("the end of a run hashes to what another program finds, with a force at one end of a branch and with none") {
  HashChain chain;
  db::RunEnd end;
  end.branches = {fourth_attempt()};
  CHECK(db::hex(chain.close({}, 0, end)) == "6ab156d05270123364a89c51e1bd9963df2088e0a87c85902b0da5dbf3337fa4");
  end.branches.front().to_n = 2.0;
  CHECK(db::hex(chain.close({}, 0, end)) == "f80818f0d4921084dbc07da1195f53796f23f6f59cb1c4701ca02674253eba12");
  end.branches.front().to_n.reset();
  end.branches.front().from_n = 2.0;
  const db::Digest other = chain.close({}, 0, end);
  end.branches.front().to_n = 2.0;
  CHECK(chain.close({}, 0, end) != other);
}

TEST_CASE("sealed data hash to what another program finds") {
  HashChain chain;
  const db::FitRecord first{3, 1, "elam", true, 256, R"({"p":[-0.0,5e-324]})", "a build", "0.1.0", "2024"};
  db::FitRecord second;
  second.fit = 4;
  second.model = "gpi";
  CHECK(db::hex(chain.fits({first, second})) == "b00d2686459ea5dafe70a98dd8be33f0ea423e27f0ef000d8621bfa626f2ed82");
  const db::VerdictRecord verdict{0, 2, "error", "array", 1.5, 2.5, "psi", "simple", "pass", "limits", "sha"};
  CHECK(db::hex(chain.verdicts({verdict, {}})) == "b64a834aef20507ab100cb962d338dcce2a877dc228136d24b99c09e90a3c8c0");
  CHECK(db::hex(chain.approvals(
            {{1, "1-a", "ca", "K. Lee", "2024", "", ""}, {1, "1-b", "cb", "M. Ito", "2025", "1-a", ""}})) ==
        "abe096aeb543994bd3cf721612465f65d3f1896f216dba8c82e4c28a7ea14fea");
  db::RunRecord run = example_run();
  run.void_reason = "gauge closed";
  run.void_by = "K. Lee";
  run.void_utc = "2026";
  CHECK(db::hex(chain.voided(run)) == "41b8e56961715f5668775219045d2d45afdb941e26e987a3377de3bba0d0b906");
}

TEST_CASE("without SHA-256 nothing is hashed") {
  REQUIRE(EVP_set_default_properties(nullptr, "provider=none_of_that_name") == 1);
  const std::string id = store_error([] { const HashChain chain; });
  REQUIRE(EVP_set_default_properties(nullptr, "") == 1);
  CHECK(id == "TB-STORE-SQL");
  CHECK(db::sha256_hex("abc").substr(0, 8) == "ba7816bf");
}

TEST_CASE("outcomes and safe states have a word each, and no other word is one") {
  using db::Outcome, db::SafeState;
  const std::vector<std::pair<Outcome, std::string>> outcomes = {
      {Outcome::kIncomplete, "incomplete"}, {Outcome::kCompleted, "completed"}, {Outcome::kStopped, "stopped"},
      {Outcome::kAborted, "aborted"},       {Outcome::kFailed, "failed"},       {Outcome::kInterrupted, "interrupted"}};
  for (const auto& [outcome, word] : outcomes) {
    CHECK(db::to_string(outcome) == word);
    CHECK(db::outcome_from(word) == outcome);
  }
  const std::vector<std::pair<SafeState, std::string>> states = {{SafeState::kUnknown, "unknown"},
                                                                 {SafeState::kVerified, "verified"},
                                                                 {SafeState::kUnverified, "unverified"},
                                                                 {SafeState::kFailed, "failed"}};
  for (const auto& [state, word] : states) {
    CHECK(db::to_string(state) == word);
    CHECK(db::safe_state_from(word) == state);
  }
  CHECK(!db::outcome_from("verified"));
  CHECK(!db::safe_state_from("completed"));
}
