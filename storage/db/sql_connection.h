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
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "storage/db/statement.h"

namespace skyquilt::storage {

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
    Result<Statement> change = Query(sql, values...);
    if (!change) return change.error();
    return change->Run();
  }
  // The same, as Statement::Number.
  template <typename... Values>
  Result<std::int64_t> Number(std::string_view sql, const Values&... values) {
    Result<Statement> query = Query(sql, values...);
    if (!query) return query.error();
    return query->Number();
  }
  // Whether it has a row.
  template <typename... Values>
  Result<bool> Finds(std::string_view sql, const Values&... values) {
    Result<Statement> query = Query(sql, values...);
    if (!query) return query.error();
    return query->Step();
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

// Begins now; rolled back at the end of the scope unless Commit was called.
class Transaction {
 public:
  // `flight`: the only one whose rows depend on what is read here; empty: any.
  static Result<Transaction> Begin(SqlConnection& db, std::string_view flight = {});
  ~Transaction();
  Transaction(Transaction&& other) noexcept;
  Transaction& operator=(Transaction&&) = delete;
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  Result<void> Commit();

 private:
  explicit Transaction(SqlConnection& db) : db_(&db) {}
  SqlConnection* db_;
};

// While it lives, commits of this connection do not wait for the disk, and leave checkpoints to later ones. A
// power cut may undo them, last ones first; the end of a process does not, and the database stays whole. The
// next commit that waits takes them along. Made and ended outside of transactions.
class UnsyncedCommits {
 public:
  static Result<UnsyncedCommits> Begin(SqlConnection& db);
  ~UnsyncedCommits();
  UnsyncedCommits(UnsyncedCommits&& other) noexcept;
  UnsyncedCommits& operator=(UnsyncedCommits&&) = delete;
  UnsyncedCommits(const UnsyncedCommits&) = delete;
  UnsyncedCommits& operator=(const UnsyncedCommits&) = delete;

 private:
  explicit UnsyncedCommits(SqlConnection& db) : db_(&db) {}
  SqlConnection* db_;
};

}  // namespace skyquilt::storage
