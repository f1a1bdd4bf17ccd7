// PostgresDb: one connection to the PostgreSQL database of the catalogue, through libpq. It connects at its
// first use and again when it was lost: within a call for up to two seconds, then with growing pauses, in
// which every call is refused at once (kUnavailable). What a statement did whose connection was lost is not
// known: it is not said again, except by connections that only read. Statements outside of a transaction that
// the server undid because of others (deadlock, serialization) are said again. Statements are prepared on the
// server once for each connection. A COMMIT whose connection was lost is asked after by its
// transaction's number, for half a minute, so that its answer is the truth. Commits become visible first and
// wait for the disk afterwards, before the call comes back: what they lock, the numbering of events above
// all, they hold for no longer than the server computes. One thread at a time. Errors: as Statement.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "core/base/result.h"
#include "storage/db/outage/silence.h"
#include "storage/db/postgres/catalogue_place.h"
#include "storage/db/sql_connection.h"

struct pg_conn;
struct pg_result;

namespace skyquilt::storage {

struct PgResultCloser {
  void operator()(pg_result* result) const;
};
using PgResult = std::unique_ptr<pg_result, PgResultCloser>;

// A parameter as it is sent: in PostgreSQL's binary form, with its type.
struct PgParameter {
  std::uint32_t type = 0;  // oid; 0: by the statement, for NULL
  bool is_null = true;
  std::string bytes;  // its own: what was bound may be gone when the statement runs
};

class PostgresDb final : public SqlConnection {
 public:
  enum class Use { kWrite, kRead };
  // `silence`: shared by the connections of one process.
  PostgresDb(CataloguePlace place, Use use, std::shared_ptr<Silence> silence = std::make_shared<Silence>())
      : place_(std::move(place)), use_(use), silence_(std::move(silence)) {}
  ~PostgresDb() override;

  Result<void> Exec(const std::string& sql) override;
  Result<Statement> Prepare(std::string_view sql) override;
  std::int64_t Changes() const override { return changes_; }
  Dialect dialect() const override { return Dialect::kPostgres; }
  bool WasUndoneByOthers() const override { return was_undone_by_others_; }

  // For its statements: runs `sql` (with $1) and answers all of its rows.
  Result<PgResult> Run(const std::string& sql, const std::vector<PgParameter>& parameters);
  // Waits for a NOTIFY on this channel of the schema, or the end of the time, or a signal. True: there was
  // one, or may have been while the connection was lost.
  Result<bool> WaitForNotice(const std::string& channel, std::chrono::milliseconds time);
  // How long a call tries to connect again; two seconds where this was never said.
  void SetPatience(std::chrono::milliseconds time) { patience_ = time; }
  // Of a connection that writes: no other one of these tables that does so lives beside it from now on
  // (kUnavailable for them). False: one does.
  Result<bool> HoldAlone();
  // Of the tables; empty before the first use.
  const std::string& schema() const { return schema_; }

 private:
  Result<void> BeginTransaction(std::string_view flight) override;
  Result<void> CommitTransaction() override;
  void RollbackTransaction() override;
  Result<void> SyncCommits(bool on) override;

  Result<void> CommitAndFlush(bool& was_undone);
  // How a transaction ended whose COMMIT was not answered.
  Result<void> AskAfter(const std::string& number, const Error& lost);
  Result<void> EnsureOpen();
  Result<void> Connect();
  Result<void> PrepareSession();
  Result<bool> TakePart();
  void Drop();
  Error Lost(std::string_view what);
  Error Failed(const pg_result* result, std::string_view what);
  Result<PgResult> RunOnce(const std::string& sql, const std::vector<PgParameter>& parameters,
                           bool& may_repeat);
  Result<PgResult> Simple(const std::string& sql);
  Result<std::string> NameOf(const std::string& sql, const std::vector<PgParameter>& parameters);

  CataloguePlace place_;
  Use use_;
  std::shared_ptr<Silence> silence_;
  pg_conn* handle_ = nullptr;
  std::string schema_;
  std::unordered_map<std::string, std::string> prepared_;  // names on the server, by types and SQL
  std::int64_t changes_ = 0;
  bool in_transaction_ = false;
  std::string transaction_;  // its number
  bool syncs_ = true;
  bool is_alone_ = false;  // HoldAlone
  bool was_undone_by_others_ = false;
  std::string listens_to_;
  std::chrono::steady_clock::time_point not_before_;  // of the next attempt to connect
  std::chrono::milliseconds pause_{0};
  std::chrono::milliseconds patience_{2'000};
};

}  // namespace skyquilt::storage
