// Recognition of a store's file by its first hundred bytes, built here by hand after sqlite.org/fileformat2.html.
#include "db/store_file.h"

#include <linux/magic.h>

#include <catch2/catch.hpp>

#include "db/run_store.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::FileKind;

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
