// Recognition of a store's file by its first hundred bytes, after sqlite.org/fileformat2.html, and of network file
// systems. Mounting one needs rights that a test does not have, so here statfs reports NFS for one folder and the truth
// for all others.
#include <fcntl.h>
#include <linux/magic.h>
#include <mntent.h>
#include <sys/syscall.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <string_view>
#include <vector>

#include "bench/cli/session.h"
#include "bench/common/error.h"
#include "db/sqlite.h"
#include "db/store_file.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::FileKind;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

// Each bit of the header of a store's file, flipped: reading or writing reports it, or is not affected.

namespace {

constexpr std::size_t kHeaderBytes = 100;

// True when `use` ends with an error, which must be one of the store.
template <class Use>
bool told(Use use) {
  try {
    use();
    return false;
  } catch (const db::StoreError&) {
    CHECK(bench::as_error(std::current_exception()).code() == bench::ExitCode::kStore);
    return true;
  }
}

bool as_it_was(const RunStore& store, const std::string& content) {
  return store.content_hash(1) == content && store.check_content(1).holds() && store.check_seals(1).empty();
}

void write_something(RunStore& store) {
  store.add_note(1, "written after the flip");
  db::RunRecord record = example_run();
  record.purpose = std::string(30'000 / 4, 'x');  // more than a page
  const std::int64_t run = store.begin_run(record);
  const std::int64_t branch = store.begin_branch(run, example_branch());
  for (int i = 0; i < 5; ++i) store.append_frame(run, example_frame(branch, i));
  store.end_run(run, db::Outcome::kStopped, "", db::SafeState::kVerified, "2024-05-02T10:00:00Z");
}

void remove_all_of(const std::string& path) {
  for (const char* ending : {"", "-wal", "-shm", "-journal"}) std::filesystem::remove(path + ending);
}

struct Fates {
  int refused = 0, harmless = 0;
};

Fates flip_each(const std::string& whole, const std::string& content, std::size_t first, std::size_t end) {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  Fates fates;
  for (std::size_t bit = 8 * first; bit < 8 * end; ++bit) {
    CAPTURE(bit / 8, bit % 8);
    std::string bytes = whole;
    bytes[bit / 8] = static_cast<char>(static_cast<unsigned char>(bytes[bit / 8]) ^ (1U << (bit % 8)));
    write_file(path, bytes);
    bool same = true;
    const bool read = !told([&] { same = as_it_was(RunStore::open_read_only(path), content); });
    CHECK(same);
    remove_all_of(path);
    write_file(path, bytes);
    const bool written = !told([&] {
      RunStore store = RunStore::open(path, db::Durability::kNormal);
      write_something(store);
    });
    CHECK(!(written && !read));
    if (read) {  // rows of a refused attempt are not lost either
      CHECK_FALSE(told([&] { same = as_it_was(RunStore::open_read_only(path), content); }));
      CHECK(same);
    }
    ++(written ? fates.harmless : fates.refused);
    remove_all_of(path);
  }
  return fates;
}

std::string store_in(const std::string& path, bool with_free_pages) {
  std::string content;
  {
    RunStore store = RunStore::open(path, db::Durability::kNormal);
    content = store.run(store_example(store)).content_sha256;
  }
  if (with_free_pages)
    Connection(path, Access::kReadWrite)
        .execute("CREATE TABLE gone (b BLOB); INSERT INTO gone VALUES (zeroblob(20000)); DROP TABLE gone");
  REQUIRE_FALSE(std::filesystem::exists(path + "-wal"));
  return content;
}

}  // namespace

TEST_CASE("store header: each flipped bit is refused, or does not affect reading and writing") {
  const TemporaryFolder folder;
  const std::string content = store_in(folder.path("runs.db"), false);
  const Fates fates = flip_each(read_file(folder.path("runs.db")), content, 0, kHeaderBytes);
  CHECK(fates.refused + fates.harmless == 800);
  CHECK(fates.refused > 400);   // page size, versions, formats, pages, encoding, schema, application
  CHECK(fates.harmless > 100);  // counters of changes, reserved bytes, the version of the library
}

TEST_CASE("store header: each flipped bit of the page fields is refused or harmless, also with free pages") {
  const TemporaryFolder folder;
  const std::string content = store_in(folder.path("runs.db"), true);
  REQUIRE(Connection(folder.path("runs.db"), Access::kReadOnly).integer("PRAGMA freelist_count") > 3);
  const Fates fates = flip_each(read_file(folder.path("runs.db")), content, 24, 40);
  CHECK(fates.refused + fates.harmless == 128);
}

TEST_CASE("store header: an impossible schema version is reported as damage") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  RunStore::open(path);
  for (const int version : {-1, -5, -2147483647, 0}) {
    Connection(path, Access::kReadWrite).execute("PRAGMA user_version = " + std::to_string(version));
    CHECK(store_error([&] { RunStore::open(path); }) == "TB-STORE-OPEN");
    CHECK(store_error([&] { RunStore::open_read_only(path); }) == "TB-STORE-OPEN");
    CHECK(store_error([&] { (void)db::schema_version_of(path); }) == "TB-STORE-OPEN");
  }
  CHECK_FALSE(std::filesystem::exists(path + ".schema--1.backup"));
}

namespace {

std::string& put(std::string& header, std::size_t at, std::size_t bytes, std::uint32_t value) {
  for (std::size_t i = 0; i < bytes; ++i)
    header[at + i] = static_cast<char>(static_cast<unsigned char>(value >> (8 * (bytes - 1 - i))));
  return header;
}

std::string good_header() {
  std::string header("SQLite format 3\0", 16);
  header.resize(100, '\0');
  put(header, 16, 2, 4096);
  put(header, 18, 1, 2);
  put(header, 19, 1, 2);
  put(header, 21, 1, 64);
  put(header, 22, 1, 32);
  put(header, 23, 1, 32);
  put(header, 28, 4, 10);
  put(header, 44, 4, 4);
  put(header, 56, 4, 1);
  put(header, 68, 4, 0x54424348);  // "TBCH"
  return header;
}

bool is_store(const std::string& bytes) {
  const TemporaryFolder folder;
  write_file(folder.path("runs.db"), bytes);
  FileKind kind = FileKind::kStore;
  const std::string id = store_error([&] { kind = db::check_store_file(folder.path("runs.db")); });
  CHECK(kind == FileKind::kStore);
  CHECK((id.empty() || id == "TB-STORE-OPEN"));
  return id.empty();
}

bool is_store_with(std::size_t at, std::size_t bytes, std::uint32_t value) {
  std::string header = good_header();
  return is_store(put(header, at, bytes, value));
}

}  // namespace

TEST_CASE("store header: a store is recognised by its first 100 bytes, and not by fewer") {
  CHECK(is_store(good_header()));
  CHECK(is_store(good_header() + std::string(5000, 'x')));
  CHECK_FALSE(is_store(good_header().substr(0, 99)));
  CHECK_FALSE(is_store_with(15, 1, 'x'));
  CHECK_FALSE(is_store_with(0, 1, 's'));
  const TemporaryFolder folder;
  CHECK(db::check_store_file(folder.path("runs.db")) == FileKind::kMissing);
  write_file(folder.path("runs.db"), "");
  CHECK(db::check_store_file(folder.path("runs.db")) == FileKind::kEmpty);
}

TEST_CASE("store header: a file with another application id is not a store") {
  CHECK_FALSE(is_store_with(68, 4, 0x54424349));
  CHECK_FALSE(is_store_with(68, 1, 0x55));
  CHECK_FALSE(is_store_with(68, 4, 0));
}

TEST_CASE("store header: each constant byte is checked") {
  struct HeaderField {
    std::size_t at, bytes;
    std::uint32_t value;
  };
  // Page size, bytes left free, fractions of payload, schema format, cache size, root page, encoding, vacuum.
  for (const HeaderField& field : std::vector<HeaderField>{{16, 2, 4096},
                                                           {20, 1, 0},
                                                           {21, 1, 64},
                                                           {22, 1, 32},
                                                           {23, 1, 32},
                                                           {44, 4, 4},
                                                           {48, 4, 0},
                                                           {52, 4, 0},
                                                           {56, 4, 1},
                                                           {64, 4, 0}}) {
    for (std::size_t byte = 0; byte < field.bytes; ++byte) {
      CAPTURE(field.at, byte);
      CHECK_FALSE(is_store_with(field.at, field.bytes, field.value ^ (0x80U << (8 * byte))));
    }
  }
}

TEST_CASE("store header: both format versions must be 1, or both 2") {
  for (const std::uint32_t write : {0U, 1U, 2U, 3U}) {
    for (const std::uint32_t read : {0U, 1U, 2U, 3U}) {
      CAPTURE(write, read);
      CHECK(is_store_with(18, 2, (write << 8) | read) == (write == read && (write == 1 || write == 2)));
    }
  }
}

TEST_CASE("store header: free pages are within the page count, and the first is set only if there are some") {
  const auto holds = [](std::uint32_t pages, std::uint32_t first_free, std::uint32_t free) {
    std::string header = good_header();
    put(header, 28, 4, pages);
    put(header, 32, 4, first_free);
    put(header, 36, 4, free);
    return is_store(header);
  };
  CHECK((holds(10, 0, 0) && holds(10, 5, 3) && holds(10, 10, 1) && holds(10, 2, 9) && holds(0, 0, 0)));
  CHECK((!holds(10, 0, 1) && !holds(10, 5, 0) && !holds(10, 11, 1) && !holds(10, 2, 10) && !holds(10, 2, 11)));
  // All four bytes of each.
  CHECK((holds(0x01020304, 0x01020304, 1) && !holds(0x01020304, 0x01020305, 1)));
  CHECK((holds(0x01020304, 1, 0x01020303) && !holds(0x01020304, 1, 0x01020304)));
}

TEST_CASE("network file systems: are recognised by the numbers of statfs(2) and the kernel's header") {
  const std::vector<std::pair<std::uint64_t, std::string>> known = {
      {NFS_SUPER_MAGIC, "NFS"},
      {SMB_SUPER_MAGIC, "SMB"},
      {CIFS_SUPER_MAGIC, "CIFS"},
      {SMB2_SUPER_MAGIC, "SMB"},
      {V9FS_MAGIC, "9P"},
      {CODA_SUPER_MAGIC, "Coda"},
      {AFS_SUPER_MAGIC, "AFS"},
      {AFS_FS_MAGIC, "AFS"},
      {NCP_SUPER_MAGIC, "NCP"},
      {CEPH_SUPER_MAGIC, "Ceph"},
      {OCFS2_SUPER_MAGIC, "OCFS2"},
      // Of file systems outside the kernel, or without a name there.
      {0x01161970, "GFS2"},
      {0x0bd00bd0, "Lustre"},
      {0x20030528, "OrangeFS"},
      {0x19830326, "BeeGFS"},
      {0x47504653, "GPFS"},
      {0xaad7aaea, "PanFS"},
      {0x786f4256, "vboxsf"},
      {0xbacbacbc, "vmhgfs"}};
  for (const auto& [number, name] : known) CHECK(db::network_file_system(number, "") == name);
  CHECK(db::network_file_system(FUSE_SUPER_MAGIC, "fuse.rclone") == "fuse.rclone");
  for (const char* local : {"fuseblk", "fuse.fuse-overlayfs"}) {
    CHECK_FALSE(db::network_file_system(FUSE_SUPER_MAGIC, local));
  }
  CHECK_FALSE(db::network_file_system(EXT4_SUPER_MAGIC, "fuse.sshfs"));
}

namespace {

std::string networked;
std::int64_t magic_there = 0x6969;  // NFS

// The type of the file system on which a folder lies, by the longest mount point above it.
std::string mounted_type(const std::string& folder) {
  std::string type;
  std::size_t longest = 0;
  FILE* mounts = ::setmntent("/proc/self/mounts", "r");
  REQUIRE(mounts != nullptr);
  while (const mntent* entry = ::getmntent(mounts)) {
    std::string point = entry->mnt_dir;
    if (!point.ends_with('/')) point += '/';
    if (!(folder + '/').starts_with(point) || point.size() < longest) continue;
    longest = point.size();
    type = entry->mnt_type;
  }
  ::endmntent(mounts);
  return type;
}

}  // namespace

extern "C" int statfs(const char* path, struct statfs* status) noexcept {
  const long result = ::syscall(SYS_statfs, path, status);
  if (result == 0 && !networked.empty() && std::string_view(path).starts_with(networked)) status->f_type = magic_there;
  return static_cast<int>(result);
}

TEST_CASE("network store: a store on a network file system is not created, opened or copied to") {
  const TemporaryFolder folder;
  const std::string local = folder.path("local"), there = folder.path("there");
  std::filesystem::create_directory(local);
  std::filesystem::create_directory(there);
  const RunStore store = RunStore::open(local + "/runs.db");
  RunStore::open(there + "/old.db");  // before the folder is reported as NFS
  networked = there;
  std::string message;
  CHECK(store_error([&] { RunStore::open(there + "/new.db"); }, &message) == "TB-STORE-NETWORK");
  CHECK_THAT(message, Catch::Contains("NFS"));
  CHECK(store_error([&] { RunStore::open(there + "/old.db"); }) == "TB-STORE-NETWORK");
  CHECK(store_error([&] { store.snapshot(there + "/copy.db"); }) == "TB-STORE-NETWORK");
  CHECK(store_error([&] { db::schema_version_of(there + "/old.db"); }) == "TB-STORE-NETWORK");
  CHECK(store_error([&] { RunStore::open(local + "/other.db"); }).empty());
  networked.clear();
  CHECK_FALSE(std::filesystem::exists(there + "/new.db"));
  CHECK_FALSE(std::filesystem::exists(there + "/copy.db"));
  CHECK(store_error([&] { RunStore::open(there + "/old.db"); }).empty());
}

TEST_CASE("network store: a finished store is readable with a warning, one with a non-empty log is not") {
  const TemporaryFolder folder;
  const std::string there = folder.path("there"), path = there + "/runs.db", log = path + "-wal";
  std::filesystem::create_directory(there);
  std::int64_t run = 0;
  {
    RunStore store = RunStore::open(path);
    run = store_example(store);
  }
  networked = there;
  std::vector<std::string> warnings;
  db::set_warning_handler([&](const std::string& text) { warnings.push_back(text); });
  {
    RunStore store = RunStore::open_read_only(path);
    REQUIRE(warnings.size() == 1);
    CHECK_THAT(warnings[0], Catch::Contains(path) && Catch::Contains("NFS"));
    (void)RunStore::open_read_only(path);
    CHECK(warnings.size() == 1);
    CHECK(store.check_content(run).holds());
    CHECK(store_error([&] { store.add_note(run, "late"); }) == "TB-STORE-OPEN");
    CHECK_FALSE(std::filesystem::exists(path + "-shm"));  // no memory is shared over a network
    RunStore local = RunStore::open(folder.path("local.db"));
    CHECK(store_error([&] { (void)local.copy_runs_from(store, {run}); }) == "TB-STORE-NETWORK");
  }
  write_file(log, "");  // a log in which there is nothing
  CHECK(RunStore::open_read_only(path).frame_count(run) == 3);
  CHECK(warnings.size() == 1);
  write_file(log, "1");
  CHECK(store_error([&] { RunStore::open_read_only(path); }) == "TB-STORE-NETWORK");
  write_file(log, "frames that are not in the file yet");
  CHECK(store_error([&] { RunStore::open_read_only(path); }) == "TB-STORE-NETWORK");
  networked.clear();
  db::set_warning_handler({});
}

TEST_CASE("network store: the warning escapes control characters of the file name") {
  const TemporaryFolder folder;
  const std::string there = folder.path("th\x1b[31mere"), told = folder.path("told");
  std::filesystem::create_directory(there);
  RunStore::open(there + "/runs.db");
  networked = there;
  std::vector<std::string> words = {"tactbench", "runs", "list", "--db", there + "/runs.db"};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  const int terminal = dup(STDERR_FILENO), file = open(told.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  REQUIRE((terminal >= 0 && file >= 0 && dup2(file, STDERR_FILENO) >= 0));
  const int code = bench::run_command_line(static_cast<int>(arguments.size()), arguments.data());
  REQUIRE(dup2(terminal, STDERR_FILENO) >= 0);
  for (const int descriptor : {terminal, file}) close(descriptor);
  networked.clear();
  db::set_warning_handler({});
  CHECK(code == 0);
  CHECK_THAT(read_file(told), Catch::Contains("th\\x1b[31mere/runs.db") && !Catch::Contains("\x1b"));
}

TEST_CASE("network store: a FUSE file system is named as in the mount table") {
  const TemporaryFolder folder;
  const std::string type = mounted_type(folder.path());
  networked = folder.path();
  magic_there = 0x65735546;
  std::string message;
  const std::string id = store_error([&] { RunStore::open(folder.path("runs.db")); }, &message);
  networked.clear();
  magic_there = 0x6969;
  CAPTURE(message, type);
  CHECK(id == "TB-STORE-NETWORK");
  CHECK_THAT(message, Catch::Contains("(" + type + ")"));
}

TEST_CASE("network store: a 32-bit file system number is recognised with and without sign extension") {
  const TemporaryFolder folder;
  networked = folder.path();
  for (const std::int64_t number : {std::int64_t{0xff534d42}, std::int64_t{0xff534d42} - (std::int64_t{1} << 32)}) {
    magic_there = number;
    std::string message;
    CHECK(store_error([&] { RunStore::open(folder.path("runs.db")); }, &message) == "TB-STORE-NETWORK");
    CHECK_THAT(message, Catch::Contains("(CIFS)"));
  }
  networked.clear();
  magic_there = 0x6969;
}
