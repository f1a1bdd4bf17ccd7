// SqlConnection: one connection to a database, whichever engine has it: SqliteDb (a file) or PostgresDb (a
// server). SQL above this is written once, in what both engines read; where they cannot agree, dialect() says
// which one it is. A connection is used by one thread at a time. Errors: as Statement.
//
// What a Transaction keeps apart. In SQLite there is one writer: BEGIN IMMEDIATE, whatever `flight` says. In
// PostgreSQL statements see what was committed when they began (READ COMMITTED), so a transaction that reads
// and then writes what it read takes an advisory lock first, held to its end: of its flight, or of the whole
// catalogue where it names none; the latter waits for all of the former. Two flights do not wait for each
// other, and no transaction has to be done again because of another, as under SERIALIZABLE, where all of them
// would, with the records and files that they write meanwhile. Claims alone take no such lock: rows that they
// lock are passed over by other claims (claim_job in functions_postgres.sql), and who must not see a job
// begin locks its row (ForShare).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/base/try.h"
#include "storage/db/clock.h"

namespace skyquilt::storage {

// What an engine does for a Statement.
class StatementDriver {
 public:
  StatementDriver() = default;
  virtual ~StatementDriver() = default;
  StatementDriver(const StatementDriver&) = delete;
  StatementDriver& operator=(const StatementDriver&) = delete;
  virtual void BindInt64(int index, std::int64_t value) = 0;
  virtual void BindDouble(int index, double value) = 0;
  virtual void BindText(int index, std::string_view value) = 0;
  virtual void BindBlob(int index, std::span<const std::uint8_t> value) = 0;
  virtual void BindNull(int index) = 0;
  virtual Result<bool> Step() = 0;
  virtual void Reset() = 0;
  virtual std::int64_t ColumnInt64(int column) const = 0;
  virtual double ColumnDouble(int column) const = 0;
  virtual std::string_view ColumnText(int column) const = 0;
  virtual std::span<const std::uint8_t> ColumnBlob(int column) const = 0;
  virtual bool IsNull(int column) const = 0;
};

// Statement: one prepared SQL statement of a SqlConnection. Bind (1-based), Step until false, Reset, use
// again. What is bound is copied, so that a temporary may be bound: no engine keeps a view of it.
// Views that ColumnText and ColumnBlob return live until the next Step or Reset. One thread at a time; must
// not outlive its database. Parameters are written ? or ?1, in every engine. Errors: kOutOfSpace, kCorrupt,
// kConflict (a constraint), kUnavailable (locked, or the connection was lost), kInvalidArgument (text that
// the engine cannot store), kIo.
class Statement {
 public:
  Statement() = default;
  explicit Statement(std::unique_ptr<StatementDriver> driver) : driver_(std::move(driver)) {}

  Statement& Bind(int index, std::int64_t value) {
    driver_->BindInt64(index, value);
    return *this;
  }
  Statement& Bind(int index, int value) { return Bind(index, static_cast<std::int64_t>(value)); }
  Statement& Bind(int index, double value) {
    driver_->BindDouble(index, value);
    return *this;
  }
  Statement& Bind(int index, std::string_view value) {
    driver_->BindText(index, value);
    return *this;
  }
  Statement& Bind(int index, const char* value) { return Bind(index, std::string_view(value)); }
  Statement& Bind(int index, std::span<const std::uint8_t> value) {
    driver_->BindBlob(index, value);
    return *this;
  }
  Statement& BindNull(int index) {
    driver_->BindNull(index);
    return *this;
  }
  // Nothing is NULL.
  template <typename T>
  Statement& Bind(int index, const std::optional<T>& value) {
    return value ? Bind(index, *value) : BindNull(index);
  }
  // The first parameters, in their order.
  template <typename... Values>
  Statement& BindAll(const Values&... values) {
    [[maybe_unused]] int index = 0;
    (Bind(++index, values), ...);
    return *this;
  }

  // True: a row is there. False: done.
  Result<bool> Step() { return driver_->Step(); }
  // Shows `visit` each row that is left.
  template <typename Visit>
  Result<void> Each(const Visit& visit) {
    while (true) {
      SKYQUILT_TRY_ASSIGN(const bool row, Step());
      if (!row) return {};
      visit(*this);
    }
  }
  // What `read` makes of each row that is left.
  template <typename Read>
  auto All(const Read& read) -> Result<std::vector<std::invoke_result_t<Read, const Statement&>>> {
    std::vector<std::invoke_result_t<Read, const Statement&>> all;
    SKYQUILT_TRY(Each([&](const Statement& row) { all.push_back(read(row)); }));
    return all;
  }
  // What `read` makes of the first row, if there is one; then as Run: RETURNING hands out its row before the
  // statement is done, and only done is committed.
  template <typename Read>
  auto First(const Read& read) -> Result<std::optional<std::invoke_result_t<Read, const Statement&>>> {
    std::optional<std::invoke_result_t<Read, const Statement&>> first;
    SKYQUILT_TRY_ASSIGN(const bool row, Step());
    if (!row) return first;
    first.emplace(read(*this));
    SKYQUILT_TRY(Run());
    return first;
  }
  // The first column of the first row, as First; 0 where there is none.
  Result<std::int64_t> Number();
  // Steps to the end, drops any rows and resets: for statements that write.
  Result<void> Run();
  void Reset() {
    if (driver_) driver_->Reset();
  }

  std::int64_t ColumnInt64(int column) const { return driver_->ColumnInt64(column); }
  double ColumnDouble(int column) const { return driver_->ColumnDouble(column); }
  std::string_view ColumnText(int column) const { return driver_->ColumnText(column); }
  std::span<const std::uint8_t> ColumnBlob(int column) const { return driver_->ColumnBlob(column); }
  bool IsNull(int column) const { return driver_->IsNull(column); }
  // A column as this type has it. NULL is nothing of an optional, 0 or empty of all else.
  template <typename T>
  T Get(int column) const {
    if constexpr (requires {
                    typename T::value_type;
                    requires std::is_same_v<T, std::optional<typename T::value_type>>;
                  }) {
      return IsNull(column) ? T() : T(Get<typename T::value_type>(column));
    } else if constexpr (std::is_same_v<T, Time>) {
      return FromUs(ColumnInt64(column));
    } else if constexpr (std::is_same_v<T, double>) {
      return ColumnDouble(column);
    } else if constexpr (std::is_same_v<T, bool>) {
      return ColumnInt64(column) != 0;
    } else if constexpr (std::is_integral_v<T>) {
      return static_cast<T>(ColumnInt64(column));
    } else {
      return T(ColumnText(column));
    }
  }
  // The first columns, each into its field.
  template <typename... Fields>
  void Into(Fields&... fields) const {
    int column = 0;
    ((fields = Get<Fields>(column++)), ...);
  }

 private:
  std::unique_ptr<StatementDriver> driver_;
};

// For All and First: a row's first columns, as the members of a `Made`.
template <typename Made, typename... Columns>
Made RowOf(const Statement& row) {
  const auto make = [&]<int... Column>(std::integer_sequence<int, Column...>) {
    return Made{row.Get<Columns>(Column)...};
  };
  return make(std::make_integer_sequence<int, sizeof...(Columns)>());
}
template <typename T>
T FirstColumn(const Statement& row) {
  return row.Get<T>(0);
}

enum class Dialect { kSqlite, kPostgres };

class SqlConnection {
 public:
  virtual ~SqlConnection() = default;
  SqlConnection(const SqlConnection&) = delete;
  SqlConnection& operator=(const SqlConnection&) = delete;

  // One or several statements without parameters; rows are dropped.
  virtual Result<void> Exec(const std::string& sql) = 0;
  virtual Result<Statement> Prepare(std::string_view sql) = 0;
  // One statement with its first parameters, in their order.
  template <typename... Values>
  Result<Statement> Query(std::string_view sql, const Values&... values) {
    Result<Statement> query = Prepare(sql);
    if (query) query->BindAll(values...);
    return query;
  }
  // The same of one that writes, to its end.
  template <typename... Values>
  Result<void> Change(std::string_view sql, const Values&... values) {
    SKYQUILT_TRY_ASSIGN(Statement change, Query(sql, values...));
    return change.Run();
  }
  // The same, as Statement::All, First, AllText and Number.
  template <typename Read, typename... Values>
  auto All(const Read& read, std::string_view sql, const Values&... values)
      -> decltype(std::declval<Statement&>().All(read)) {
    SKYQUILT_TRY_ASSIGN(Statement query, Query(sql, values...));
    return query.All(read);
  }
  template <typename Read, typename... Values>
  auto First(const Read& read, std::string_view sql, const Values&... values)
      -> decltype(std::declval<Statement&>().First(read)) {
    SKYQUILT_TRY_ASSIGN(Statement query, Query(sql, values...));
    return query.First(read);
  }
  // As First, where no row is an error.
  template <typename Read, typename... Values>
  auto One(const Read& read, const Error& if_none, std::string_view sql, const Values&... values)
      -> Result<std::invoke_result_t<Read, const Statement&>> {
    SKYQUILT_TRY_ASSIGN(auto first, First(read, sql, values...));
    if (!first) return if_none;
    return *std::move(first);
  }
  template <typename... Values>
  Result<std::vector<std::string>> AllText(std::string_view sql, const Values&... values) {
    return All(FirstColumn<std::string>, sql, values...);
  }
  // The first column of the first row; empty where there is none.
  template <typename... Values>
  Result<std::string> Text(std::string_view sql, const Values&... values) {
    SKYQUILT_TRY_ASSIGN(const auto first, First(FirstColumn<std::string>, sql, values...));
    return first.value_or("");
  }
  template <typename... Values>
  Result<std::int64_t> Number(std::string_view sql, const Values&... values) {
    SKYQUILT_TRY_ASSIGN(Statement query, Query(sql, values...));
    return query.Number();
  }
  // Whether it has a row.
  template <typename... Values>
  Result<bool> Finds(std::string_view sql, const Values&... values) {
    SKYQUILT_TRY_ASSIGN(Statement query, Query(sql, values...));
    return query.Step();
  }
  // Rows changed by the last INSERT, UPDATE or DELETE.
  virtual std::int64_t Changes() const = 0;
  virtual Dialect dialect() const = 0;
  // The latest failure was the server's choice between transactions that waited for each other: nothing was
  // done, and the same again is right.
  virtual bool WasUndoneByOthers() const { return false; }
  // " FOR SHARE" where other writers can be beside this one: rows read so cannot change before the
  // transaction's end.
  const char* ForShare() const { return dialect() == Dialect::kPostgres ? " FOR SHARE" : ""; }

 protected:
  SqlConnection() = default;
  SqlConnection(SqlConnection&&) = default;
  SqlConnection& operator=(SqlConnection&&) = default;

 private:
  friend class Transaction;
  friend class UnsyncedCommits;
  virtual Result<void> BeginTransaction(std::string_view flight) = 0;
  virtual Result<void> CommitTransaction() = 0;
  virtual void RollbackTransaction() = 0;
  virtual Result<void> SyncCommits(bool on) = 0;
};

// Begins now; rolled back by a Commit that fails, or at the end of the scope without one. One Commit.
class Transaction {
 public:
  // `flight`: the only one whose rows depend on what is read here; empty: any.
  static Result<Transaction> Begin(SqlConnection& db, std::string_view flight = {});
  Result<void> Commit();

 private:
  struct Rollback {
    void operator()(SqlConnection* db) const { db->RollbackTransaction(); }
  };
  explicit Transaction(SqlConnection& db) : db_(&db) {}
  std::unique_ptr<SqlConnection, Rollback> db_;
};

// While it lives, commits of this connection do not wait for the disk, and leave checkpoints to later ones. A
// power cut may undo them, last ones first; the end of a process does not, and the database stays whole. The
// next commit that waits takes them along. Made and ended outside of transactions.
class UnsyncedCommits {
 public:
  static Result<UnsyncedCommits> Begin(SqlConnection& db);

 private:
  struct SyncAgain {
    void operator()(SqlConnection* db) const;
  };
  explicit UnsyncedCommits(SqlConnection& db) : db_(&db) {}
  std::unique_ptr<SqlConnection, SyncAgain> db_;
};

}  // namespace skyquilt::storage
