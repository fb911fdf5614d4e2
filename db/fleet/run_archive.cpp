#include "db/fleet/run_archive.h"

#include <fmt/format.h>

#define ZLIB_CONST  // what is read is not written
#include <zlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "db/fleet/fleet_error.h"

namespace tactbench::db::fleet {

std::string pack_run(const RunStore& store, std::int64_t run, const std::string& scratch) {
  const std::string path = scratch + "/packed.db";
  for (const char* ending : {"", "-wal", "-shm"}) std::filesystem::remove(path + ending);
  // A copy checks the content and the sealed records that it copies.
  (void)RunStore::open(path, Durability::kNormal).copy_runs_from(store, {run});
  std::string plain(std::filesystem::file_size(path), '\0');
  if (plain.size() > kMaxStoreBytes)
    throw FleetError(FleetCause::kStore, "TB-FLEET-LARGE",
                     fmt::format("run {} has {} MB, but the fleet keeps runs up to {} MB", run,
                                 plain.size() / 1'000'000, kMaxStoreBytes / 1'000'000),
                     "the run stays in the store; back the store up instead (tactbench runs copy --to FILE)");
  std::ifstream(path, std::ios::binary).read(plain.data(), static_cast<std::streamsize>(plain.size()));
  std::filesystem::remove(path);
  uLongf size = compressBound(plain.size());
  std::string body(size, '\0');
  (void)compress(reinterpret_cast<Bytef*>(body.data()), &size, reinterpret_cast<const Bytef*>(plain.data()),
                 plain.size());
  body.resize(size);
  return body;
}

void unpack_run(const std::string& body, const std::string& path) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  std::string piece(1 << 18, '\0');
  z_stream stream{};
  stream.next_in = reinterpret_cast<const Bytef*>(body.data());
  stream.avail_in = static_cast<uInt>(std::min(body.size(), kMaxStoreBytes));
  int state = inflateInit(&stream);
  while (state == Z_OK && stream.total_out <= kMaxStoreBytes && file) {
    stream.next_out = reinterpret_cast<Bytef*>(piece.data());
    stream.avail_out = static_cast<uInt>(piece.size());
    state = inflate(&stream, Z_NO_FLUSH);
    file.write(piece.data(), static_cast<std::streamsize>(piece.size() - stream.avail_out));
  }
  const bool whole = state == Z_STREAM_END && stream.total_in == body.size();
  inflateEnd(&stream);
  file.close();
  if (!file)
    throw StoreError("TB-STORE-FULL", fmt::format("{} could not be written", path), "free space for temporary files");
  if (!whole)
    throw FleetError(FleetCause::kStore, "TB-FLEET-CHANGED",
                     "the pushed data of the run are not a store compressed by zlib",
                     "use the run in the bench's own store");
}

}  // namespace tactbench::db::fleet
