#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace tactbench::db {

// The error type of db/. id: TB-STORE-OPEN, TB-STORE-GONE, TB-STORE-OTHER-SCHEMA, TB-STORE-NETWORK, TB-STORE-LOCKED,
// TB-STORE-FULL, TB-STORE-NOT-FOUND, TB-STORE-SQL, TB-STORE-CONFLICT, TB-STORE-EXISTS, TB-STORE-TAG, TB-STORE-FOREIGN,
// TB-STORE-TOO-LONG, TB-STORE-TOO-LARGE, TB-STORE-NOT-TEXT, TB-STORE-BLANK, TB-STORE-PRUNED.
class StoreError : public std::runtime_error {
 public:
  StoreError(std::string id, const std::string& message, std::string remedy)
      : std::runtime_error(message), id_(std::move(id)), remedy_(std::move(remedy)) {}
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const std::string& remedy() const { return remedy_; }

 private:
  std::string id_, remedy_;
};

}  // namespace tactbench::db
