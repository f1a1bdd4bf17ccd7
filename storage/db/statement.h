// Statement: one prepared SQL statement of a SqliteDb. Bind (1-based), Step until false, Reset, use again.
// Text and blobs are bound without a copy: what they point to must live until Reset or the last Step. Views
// that ColumnText and ColumnBlob return live until the next Step or Reset. One thread at a time; must not
// outlive its database. Errors: kOutOfSpace, kCorrupt, kConflict (a constraint), kUnavailable (locked), kIo.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

struct sqlite3_stmt;

namespace skyquilt::storage {

class Statement {
 public:
  Statement() = default;
  explicit Statement(sqlite3_stmt* handle) : handle_(handle) {}
  ~Statement();
  Statement(Statement&& other) noexcept;
  Statement& operator=(Statement&& other) noexcept;
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& Bind(int index, std::int64_t value);
  Statement& Bind(int index, int value) { return Bind(index, static_cast<std::int64_t>(value)); }
  Statement& Bind(int index, double value);
  Statement& Bind(int index, std::string_view value);
  Statement& Bind(int index, const char* value) { return Bind(index, std::string_view(value)); }
  Statement& Bind(int index, std::span<const std::uint8_t> value);
  Statement& BindNull(int index);

  // True: a row is there. False: done.
  Result<bool> Step();
  // The first column of all rows that are left.
  Result<std::vector<std::string>> AllText();
  // Steps to the end, drops any rows and resets: for statements that write.
  Result<void> Run();
  void Reset();

  std::int64_t ColumnInt64(int column) const;
  double ColumnDouble(int column) const;
  std::string_view ColumnText(int column) const;
  std::span<const std::uint8_t> ColumnBlob(int column) const;
  bool IsNull(int column) const;

 private:
  sqlite3_stmt* handle_ = nullptr;
};

}  // namespace skyquilt::storage
