#include "db/library_versions.h"

#include <openssl/crypto.h>

#include "db/sqlite.h"

namespace tactbench::db {

std::vector<std::pair<std::string, std::string>> library_versions() {
  sqlite::Connection memory(":memory:", sqlite::Access::kReadWrite);
  return {{"SQLite", memory.text("SELECT sqlite_version()")}, {"OpenSSL", OpenSSL_version(OPENSSL_VERSION_STRING)}};
}

}  // namespace tactbench::db
