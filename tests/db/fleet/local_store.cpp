// A bench's store as a push reads it: which runs wait, under which fingerprint, and from a folder that nobody may
// write.
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "db/fleet/local_runs.h"
#include "db/fleet/remarks.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

namespace tactbench::tests::local_store {

using db::RunStore;
using namespace db::fleet;

namespace {

std::string eight(std::uint64_t value) {
  std::string text;
  for (int i = 7; i >= 0; --i) text += static_cast<char>(static_cast<unsigned char>(value >> (8 * i)));
  return text;
}
std::string text(const std::string& value) { return "t" + eight(value.size()) + value; }
std::string integer(std::uint64_t value) { return "i" + eight(value); }

// What a process that may not write sees of a store in a folder of this mode: the number of its ended runs, or 99.
int seen_without_rights(const TemporaryFolder& folder, const std::string& path, mode_t mode) {
  chmod(path.c_str(), 0444);
  chmod(folder.path().c_str(), mode);
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    if (geteuid() == 0 && (setgid(65534) != 0 || setuid(65534) != 0)) _exit(98);
    int runs = 99;
    store_error([&] { runs = static_cast<int>(LocalRuns(path).ended_runs().size()); });
    _exit(runs);
  }
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  chmod(folder.path().c_str(), 0755);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

TEST_CASE("fleet: a fingerprint is the hash of tags, notes, void, UUID, content, seals and figures in this order") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  db::RunRecord record = example_run();
  record.uuid = "01234567-89ab-4def-8123-456789abcdef";
  const std::int64_t run = store_example(store, record);
  const std::string content = store.run(run).content_sha256;
  LocalRuns local(store.path());
  const auto printed = [&](const std::string& tags, const std::string& notes, const std::string& figures) {
    std::string bytes = text(tags) + text(notes) + text("") + text(record.uuid) + text(content);
    for (const char* kind : {"approvals", "fits", "verdicts", "void"}) bytes += text(kind) + integer(0) + text("");
    return db::sha256_hex(bytes + figures);
  };
  CHECK(local.ended_runs().at(0).fingerprint == printed("", "", ""));
  store.set_tags(run, {"b", "a"}, {});
  store.add_note(run, "note");
  store.replace_figures(run, "sensor", {{"x_psi", 0.5}});
  store.replace_figures(run, "rig", {{"y", 0.0}});
  const std::string zero = "r" + eight(0), half = "r" + eight(0x3fe0000000000000);
  CHECK(local.ended_runs().at(0).fingerprint ==
        printed("a b", "note", text("rig") + text("y") + zero + text("sensor") + text("x_psi") + half));
}

TEST_CASE("fleet: ended runs wait in their order with what names them, and one without frames cannot be sent") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t first = store_example(store);
  const Begun open = begin_example(store);
  store.append_frame(open.run, example_frame(open.branch, 0));
  const std::int64_t third = store_example(store), pruned = store_example(store);
  store.set_tags(pruned, {"nightly"}, {});
  store.prune_frames(pruned, "a rule", kUtc);
  LocalRuns local(store.path());
  CHECK(local.path() == store.path());
  const std::vector<LocalRun> runs = local.ended_runs();
  REQUIRE(runs.size() == 2);
  for (const auto& [found, number] : {std::pair(&runs[0], first), std::pair(&runs[1], third)}) {
    const db::RunRecord own = store.run(number);
    CHECK((found->run == number && found->uuid == own.uuid && found->content_sha256 == own.content_sha256));
    CHECK((found->started_utc == own.started_utc && found->fingerprint.size() == 64));
  }
  CHECK((local.frame_count(first) == 3 && local.frame_count(open.run) == 1 && local.frame_count(third) == 3));
  CHECK((local.frame_count(pruned) == 0 && local.frame_count(99) == 0));
  const std::int64_t before = local.version();
  CHECK(local.version() == before);
  store.add_note(first, "more");
  CHECK(local.version() != before);
}

TEST_CASE("fleet: a store in a folder without write access is read, and with a log that cannot be followed it is not") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  {
    RunStore store = RunStore::open(path);
    store_example(store);
    store_example(store);
  }
  CHECK(seen_without_rights(folder, path, 0555) == 2);
  CHECK(seen_without_rights(folder, path, 0777) == 2);
  chmod(path.c_str(), 0644);
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    auto* store = new RunStore(RunStore::open(path));  // never closed: the log stays
    store->add_note(1, "in the log alone");
    _exit(0);
  }
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  REQUIRE(std::filesystem::file_size(path + "-wal") > 0);
  std::filesystem::remove(path + "-shm");
  CHECK(seen_without_rights(folder, path, 0555) == 99);
}

TEST_CASE("fleet: a note keeps each fleet's pushes and tries apart") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  PushedNote a(path, "a on here:1"), b(path, "b on here:1");
  a.keep({1, "uuid-1", "content", "2026", "print one"}, "day one");
  a.keep({2, "uuid-2", "content", "2026", "print two"}, "day two");
  b.keep({1, "uuid-1", "content", "2026", "print of b"}, "day three");
  a.keep({1, "uuid-1", "content", "2026", "print new"}, "day four");
  b.keep_try("day five", "away");
  using Prints = std::map<std::string, std::string>;
  CHECK(a.fingerprints() == Prints{{"uuid-1", "print new"}, {"uuid-2", "print two"}});
  CHECK(b.fingerprints() == Prints{{"uuid-1", "print of b"}});
  CHECK((a.last().pushed_utc == "day four" && a.last().tried_utc.empty() && a.last().error.empty()));
  CHECK((b.last().pushed_utc == "day three" && b.last().tried_utc == "day five" && b.last().error == "away"));
  PushedNote again(path, "a on here:1");  // what is there stays
  CHECK(again.last().pushed_utc == "day four");
}

TEST_CASE("fleet: equal fits of a run are counted, and each part of a fit and of remarks counts in its hash") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t run = store_example(store), other = store_example(store);
  db::FitTaxelRecord taxel;
  taxel.taxel = 3;
  taxel.status = "fitted";
  const db::FitRecord fit{0, run, "elam", "{}", "{}", "0.1.0", kUtc, "{}"};
  db::FitRecord changed = fit, elsewhere = fit;
  changed.options_json = R"({"o":1})";
  elsewhere.run = other;
  const std::int64_t first = store.add_fit(fit, {taxel}), strange = store.add_fit(elsewhere, {taxel}),
                     second = store.add_fit(fit, {taxel}), third = store.add_fit(changed, {taxel});
  taxel.at_bound = 1;
  const std::int64_t fourth = store.add_fit(fit, {taxel});
  LocalRuns local(store.path());
  const std::vector<Fit> fits = fits_in(local.connection(), run);
  REQUIRE(fits.size() == 4);
  CHECK((fits[0].number == first && fits[1].number == second && fits[2].number == third && fits[3].number == fourth));
  CHECK((fits[0].copy == 0 && fits[1].copy == 1 && fits[2].copy == 0 && fits[3].copy == 0));
  CHECK((fits[0].sha256 == fits[1].sha256 && fits[0].sha256 != fits[2].sha256 && fits[0].sha256 != fits[3].sha256));
  REQUIRE(fits_in(local.connection(), other).size() == 1);
  CHECK(fits_in(local.connection(), other)[0].number == strange);
  REQUIRE(fits[0].taxels.size() == 1);
  CHECK(fits[0].taxels[0][1].integer == 3);

  db::VerdictRecord verdict;
  verdict.verdict = "pass";
  verdict.limits_sha256 = "a";
  store.replace_verdicts(run, 0, {verdict});
  verdict.limits_sha256 = "b";
  store.replace_verdicts(run, strange, {verdict});
  std::map<std::int64_t, std::pair<std::string, std::string>> names;
  const Remarks remarks = remarks_in(local.connection(), run, names);
  REQUIRE(remarks.verdicts.size() == 2);
  CHECK((remarks.verdicts[0][2].bytes.empty() && remarks.verdicts[0][3].bytes.empty()));
  CHECK(remarks.verdicts[1][2].bytes == store.run(other).uuid);
  CHECK(remarks.verdicts[1][3].bytes == fits_in(local.connection(), other)[0].sha256);
  CHECK((remarks.verdicts[0][1].integer == 1 && remarks.verdicts[1][1].integer == 2));
  CHECK(names.size() == 1);
  const std::string hash = sha256_of(remarks);
  Remarks without = remarks;
  without.verdicts.pop_back();
  CHECK(sha256_of(without) != hash);
  for (std::string Remarks::*said :
       {&Remarks::tags, &Remarks::notes, &Remarks::void_reason, &Remarks::void_by, &Remarks::void_utc}) {
    Remarks more = remarks;
    more.*said = "x";
    CHECK(sha256_of(more) != hash);
  }
}

}  // namespace tactbench::tests::local_store
