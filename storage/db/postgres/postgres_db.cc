#include "storage/db/postgres/postgres_db.h"

#include <fmt/format.h>
#include <libpq-fe.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <thread>
#include <utility>

#include "core/base/check.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "storage/db/postgres/postgres_statement.h"

namespace skyquilt::storage {
namespace {

using SteadyClock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kFirstPause{50};
constexpr milliseconds kMaxPause{2'000};
constexpr std::chrono::seconds kAskTime{30};
constexpr int kMaxRepeats = 5;
// Waits until all that was committed before is on the disk: the commit of a transaction that wrote a few
// bytes to the log and nothing else (without them PostgreSQL would not wait). Commits of the same moment
// share one write.
constexpr const char* kFlush =
    "BEGIN;SET LOCAL synchronous_commit=on;SELECT pg_logical_emit_message(true,'skyquilt','');COMMIT";

// What the states mean for who asked, each by its beginning; states that say nothing of their own mean that
// the server was not reached, or went away.
struct Meaning {
  std::array<std::string_view, 4> states;
  ErrorCode code;
  const char* message;
};
constexpr const char* kAway = nullptr;
constexpr Meaning kMeanings[] = {
    {{"23"}, ErrorCode::kConflict, "This exists already, or something it belongs to does not."},
    {{"53100"},
     ErrorCode::kOutOfSpace,
     "The disk of the catalogue's database is full. Free some space there and try again."},
    {{"08", "53", "57", "58"}, ErrorCode::kUnavailable, kAway},
    {{"40", "55P03"},
     ErrorCode::kUnavailable,
     "The database is in use by another program. Try again in a moment."},
    {{"22021", "22P05"},
     ErrorCode::kInvalidArgument,
     "A text has characters that cannot be stored. Send it as UTF-8, without zero bytes."},
    {{"54000"}, ErrorCode::kTooLarge, "A value is too large for the database."},
    {{"25006"},
     ErrorCode::kUnavailable,
     "The catalogue's database only reads: it may be a standby. Connect to its primary."},
    {{"28", "42501"},
     ErrorCode::kForbidden,
     "The catalogue's database refuses this to its user. Check user and password, and grant the user CREATE "
     "and USAGE on its schema."},
    {{"3D", "3F"},
     ErrorCode::kNotFound,
     "The catalogue's database or schema does not exist. Make it, or mend --catalogue."},
    {{"XX"},
     ErrorCode::kCorrupt,
     "The catalogue's database is damaged. Restore it from a backup, or make the catalogue anew with "
     "\"skyquilt data repair\"."},
};

Error LostConnection(std::string_view what, std::string_view library_message) {
  return flight::Because(ErrorCode::kUnavailable, flight::RemarkCode::kFailDatabaseAway,
                         fmt::format("postgresql: {}: {}", library_message, what));
}

// `what` says what was tried; `sqlstate` is empty where the library itself gave up.
Error PostgresError(std::string_view sqlstate, std::string_view what, std::string_view server_message) {
  if (sqlstate.empty()) return LostConnection(what, server_message);
  std::string detail = fmt::format("postgresql {} ({}): {}", sqlstate, server_message, what);
  for (const Meaning& meaning : kMeanings) {
    const bool is_it = std::any_of(meaning.states.begin(), meaning.states.end(), [&](std::string_view state) {
      return !state.empty() && sqlstate.starts_with(state);
    });
    if (is_it && meaning.message == kAway) return LostConnection(what, server_message);
    if (is_it) return {meaning.code, meaning.message, std::move(detail)};
  }
  return {ErrorCode::kIo, "The database could not be read or written.", std::move(detail)};
}

// Undone by the server because of what others did at the same time: the same again is right.
bool IsConflictOfWriters(std::string_view sqlstate) { return sqlstate == "40001" || sqlstate == "40P01"; }

std::string_view SqlstateOf(const pg_result* result) {
  const char* state = PQresultErrorField(result, PG_DIAG_SQLSTATE);
  return state != nullptr ? state : "";
}

std::string OneLine(const char* text) {
  std::string line = text != nullptr ? text : "";
  std::replace(line.begin(), line.end(), '\n', ' ');
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

bool IsWell(const pg_result* result) {
  const ExecStatusType status = PQresultStatus(result);
  return status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK;
}

// FNV-1a: the same in every process and version, which a library's hash need not be.
std::int64_t LockKey(std::string_view schema, std::string_view what) {
  std::uint64_t hash = 14695981039346656037U;
  const auto add = [&](std::string_view text) {
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211U;
    hash *= 1099511628211U;
  };
  add(schema);
  add(what);
  return static_cast<std::int64_t>(hash);
}

}  // namespace

void PgResultCloser::operator()(pg_result* result) const { PQclear(result); }

PostgresDb::~PostgresDb() { PQfinish(handle_); }

void PostgresDb::Drop() {
  PQfinish(handle_);
  handle_ = nullptr;
  prepared_.clear();
  listens_to_.clear();
}

// What is left of a transaction is rolled back by the server when it notices.
Error PostgresDb::Lost(std::string_view what) {
  Error error = LostConnection(what, OneLine(handle_ != nullptr ? PQerrorMessage(handle_) : "no connection"));
  Drop();
  return error;
}

Error PostgresDb::Failed(const pg_result* result, std::string_view what) {
  was_undone_by_others_ = IsConflictOfWriters(SqlstateOf(result));
  return PostgresError(SqlstateOf(result), what, OneLine(PQresultErrorMessage(result)));
}

Result<void> PostgresDb::Connect() {
  // What stands in the URL comes after the first ones and overrides them.
  const char* const password = place_.password.empty() ? nullptr : "password";
  const char* const keywords[] = {"connect_timeout",
                                  "keepalives_idle",
                                  "keepalives_interval",
                                  "keepalives_count",
                                  "tcp_user_timeout",
                                  "fallback_application_name",
                                  "dbname",
                                  "client_encoding",
                                  password,
                                  nullptr};
  const char* const values[] = {
      "5", "5", "2", "3", "10000", "skyquilt", place_.url.c_str(), "UTF8", place_.password.c_str(), nullptr};
  handle_ = PQconnectdbParams(keywords, values, 1);
  // What the server remarks is in the errors, where it matters; the library would print it.
  PQsetNoticeProcessor(
      handle_, [](void*, const char*) {}, nullptr);
  if (PQstatus(handle_) != CONNECTION_OK) {
    // The library has no code for this, only words.
    const std::string said = OneLine(PQerrorMessage(handle_));
    const bool is_refused =
        PQconnectionNeedsPassword(handle_) != 0 || said.find("authentication failed") != said.npos;
    const Error lost = Lost("connect");
    return is_refused ? PostgresError("28000", "connect", said) : lost;
  }
  Result<void> ready = PrepareSession();
  if (!ready && handle_ != nullptr) Drop();
  return ready;
}

Result<void> PostgresDb::PrepareSession() {
  // What a machine held that died is free half a minute later.
  std::string sql =
      "SET client_min_messages=warning; SET lock_timeout=10000; SET statement_timeout=120000;"
      "SET tcp_keepalives_idle=10; SET tcp_keepalives_interval=5; SET tcp_keepalives_count=3;"
      "SET synchronous_commit=off; SET idle_in_transaction_session_timeout=60000; SET default_transaction_isolation='read committed'; SET jit=off;";
  if (!place_.schema.empty()) sql += fmt::format("SET search_path TO \"{}\";", place_.schema);
  // Plans by index, however old the statistics of a queue are that was empty a minute ago.
  sql += use_ == Use::kRead ? "SET default_transaction_read_only=on;" : "SET enable_seqscan=off;";
  SKYQUILT_TRY(Simple(sql));
  SKYQUILT_TRY_ASSIGN(
      const PgResult named,
      Simple(
          "SELECT coalesce(current_schema(), ''), pg_is_in_recovery(), to_regproc('after_start') IS NOT NULL"));
  schema_ = place_.schema.empty() ? PQgetvalue(named.get(), 0, 0) : place_.schema;
  if (use_ == Use::kWrite && std::string_view(PQgetvalue(named.get(), 0, 1)) == "t") {
    return PostgresError("25006", "connect", "in recovery");
  }
  if (use_ == Use::kWrite && std::string_view(PQgetvalue(named.get(), 0, 2)) == "t") {
    SKYQUILT_TRY(Simple("SELECT after_start()"));
  }
  if (use_ == Use::kRead) return {};
  SKYQUILT_TRY_ASSIGN(const bool has_part, TakePart());
  if (has_part) return {};
  return Error{ErrorCode::kUnavailable,
               is_alone_
                   ? "Servers or workers began to use the catalogue while the connection to it was lost."
                   : "The photos and maps of this catalogue are being moved. Try again when that has ended.",
               "advisory lock"};
}

// The database lets go of this lock when the connection ends.
Result<bool> PostgresDb::TakePart() {
  SKYQUILT_TRY_ASSIGN(const PgResult taken,
                      Simple(fmt::format("SELECT pg_try_advisory_lock{}({})", is_alone_ ? "" : "_shared",
                                         LockKey(schema_, "part"))));
  return std::string_view(PQgetvalue(taken.get(), 0, 0)) == "t";
}

Result<bool> PostgresDb::HoldAlone() {
  SKYQUILT_TRY(EnsureOpen());
  is_alone_ = true;
  // Of a process that has just ended the server hears a moment later.
  const auto end = SteadyClock::now() + patience_;
  Result<bool> taken = TakePart();
  while (taken && !*taken && SteadyClock::now() < end) {
    std::this_thread::sleep_for(kFirstPause);
    taken = TakePart();
  }
  is_alone_ = taken && *taken;
  return taken;
}

Result<void> PostgresDb::EnsureOpen() {
  was_undone_by_others_ = false;
  if (in_transaction_) {
    if (handle_ == nullptr) return LostConnection("transaction", "the connection was lost before");
    return {};
  }
  // The end of a connection that lay idle is noticed before anything is sent over it.
  if (handle_ != nullptr && (PQconsumeInput(handle_) == 0 || PQstatus(handle_) != CONNECTION_OK)) Drop();
  if (handle_ != nullptr) return {};
  const auto end = SteadyClock::now() + patience_;
  if (SteadyClock::now() < not_before_) return LostConnection("connect", "not tried again yet");
  const bool was_open = !schema_.empty();
  for (milliseconds pause = kFirstPause;; pause = std::min(2 * pause, kMaxPause)) {
    const Result<void> connected = Connect();
    if (connected) {
      if (was_open) silence_->Ended();
      pause_ = milliseconds(0);
      return {};
    }
    const bool may_pass = connected.error().code == ErrorCode::kUnavailable;
    if (!may_pass || SteadyClock::now() + pause > end) {
      pause_ = std::clamp(pause_ * 2, kFirstPause, kMaxPause);
      not_before_ = SteadyClock::now() + pause_;
      return connected.error();
    }
    std::this_thread::sleep_for(pause);
  }
}

Result<PgResult> PostgresDb::Simple(const std::string& sql) {
  const auto asked = SteadyClock::now();
  PgResult result(PQexec(handle_, sql.c_str()));
  silence_->Answered(asked);
  if (result != nullptr && IsWell(result.get())) return result;
  if (result == nullptr || PQstatus(handle_) != CONNECTION_OK) return Lost(sql);
  return Failed(result.get(), sql);
}

Result<void> PostgresDb::Exec(const std::string& sql) {
  SKYQUILT_TRY(EnsureOpen());
  SKYQUILT_TRY_ASSIGN(const PgResult result, Simple(sql));
  const std::string_view count = PQcmdTuples(result.get());
  changes_ = 0;
  std::from_chars(count.data(), count.data() + count.size(), changes_);
  if (use_ == Use::kWrite && PQtransactionStatus(handle_) == PQTRANS_IDLE && syncs_) {
    SKYQUILT_TRY(Simple(kFlush));
  }
  return {};
}

Result<Statement> PostgresDb::Prepare(std::string_view sql) {
  return Statement(std::make_unique<PostgresStatement>(*this, sql));
}

Result<std::string> PostgresDb::NameOf(const std::string& sql, const std::vector<PgParameter>& parameters) {
  std::string key;
  std::vector<Oid> types;
  for (const PgParameter& parameter : parameters) {
    types.push_back(parameter.type);
    key += static_cast<char>(parameter.type % 128);
  }
  key += sql;
  const auto known = prepared_.find(key);
  if (known != prepared_.end()) return known->second;
  std::string name = fmt::format("s{}", prepared_.size());
  const PgResult result(
      PQprepare(handle_, name.c_str(), sql.c_str(), static_cast<int>(types.size()), types.data()));
  if (result == nullptr || PQstatus(handle_) != CONNECTION_OK) return Lost(sql);
  if (!IsWell(result.get())) return Failed(result.get(), sql);
  prepared_.emplace(std::move(key), name);
  return name;
}

Result<PgResult> PostgresDb::RunOnce(const std::string& sql, const std::vector<PgParameter>& parameters,
                                     bool& may_repeat) {
  may_repeat = false;
  SKYQUILT_TRY(EnsureOpen());
  const Result<std::string> name = NameOf(sql, parameters);
  if (!name) {
    may_repeat = handle_ == nullptr && !in_transaction_;  // lost before the statement was run
    return name.error();
  }
  std::vector<const char*> values;
  std::vector<int> lengths;
  std::vector<int> formats;
  for (const PgParameter& parameter : parameters) {
    values.push_back(parameter.is_null ? nullptr : parameter.bytes.data());
    lengths.push_back(static_cast<int>(parameter.bytes.size()));
    formats.push_back(1);
  }
  const auto asked = SteadyClock::now();
  PgResult result(PQexecPrepared(handle_, name->c_str(), static_cast<int>(values.size()), values.data(),
                                 lengths.data(), formats.data(), 0));
  silence_->Answered(asked);
  if (result == nullptr || PQstatus(handle_) != CONNECTION_OK) {
    may_repeat = use_ == Use::kRead && !in_transaction_;
    return Lost(sql);
  }
  if (!IsWell(result.get())) {
    const Error error = Failed(result.get(), sql);
    may_repeat = was_undone_by_others_ && !in_transaction_;
    return error;
  }
  const std::string_view count = PQcmdTuples(result.get());
  if (!count.empty() && !std::string_view(PQcmdStatus(result.get())).starts_with("SELECT")) {
    changes_ = 0;
    std::from_chars(count.data(), count.data() + count.size(), changes_);
    if (!in_transaction_ && syncs_ && changes_ > 0) {
      SKYQUILT_TRY(Simple(kFlush));
    }
  }
  return result;
}

Result<PgResult> PostgresDb::Run(const std::string& sql, const std::vector<PgParameter>& parameters) {
  for (int tries = 1;; ++tries) {
    bool may_repeat = false;
    Result<PgResult> result = RunOnce(sql, parameters, may_repeat);
    if (result || !may_repeat || tries >= kMaxRepeats) return result;
  }
}

Result<void> PostgresDb::BeginTransaction(std::string_view flight) {
  SKYQUILT_CHECK(!in_transaction_, "one transaction at a time");
  SKYQUILT_TRY(EnsureOpen());
  const std::int64_t all = LockKey(schema_, "");
  std::string sql = "BEGIN;";
  sql += "SELECT pg_current_xact_id(), ";
  sql += flight.empty() ? fmt::format("pg_advisory_xact_lock({})", all)
                        : fmt::format("pg_advisory_xact_lock_shared({}), pg_advisory_xact_lock({})", all,
                                      LockKey(schema_, flight));
  const Result<PgResult> begun = Simple(sql);
  if (!begun) {
    if (handle_ != nullptr) (void)Simple("ROLLBACK");
    return begun.error();
  }
  transaction_ = PQgetvalue(begun->get(), 0, 0);
  in_transaction_ = true;
  return {};
}

Result<void> PostgresDb::AskAfter(const std::string& number, const Error& lost) {
  for (const auto end = SteadyClock::now() + kAskTime; SteadyClock::now() < end;) {
    if (EnsureOpen()) {
      const Result<PgResult> answer = Simple(fmt::format("SELECT pg_xact_status('{}')", number));
      const std::string_view status = answer ? PQgetvalue(answer->get(), 0, 0) : "";
      if (status == "committed" && (!syncs_ || Simple(kFlush))) return {};
      if (status == "aborted") {
        return Error{
            ErrorCode::kUnavailable,
            "The connection to the catalogue's database was lost, and the change was undone. Try again.",
            lost.detail};
      }
    }
    std::this_thread::sleep_for(kFirstPause);
  }
  return lost;
}

// Both in one message.
Result<void> PostgresDb::CommitAndFlush(bool& was_undone) {
  std::string sql = "COMMIT";
  if (syncs_) sql.append(";").append(kFlush);
  if (PQsendQuery(handle_, sql.c_str()) == 0) return Lost(sql);
  std::optional<Error> failed;
  for (bool is_first = true; PgResult result{PQgetResult(handle_)}; is_first = false) {
    // A transaction that an error ended is rolled back by COMMIT, which says so and nothing else.
    if (is_first && IsWell(result.get()))
      was_undone = std::string_view(PQcmdStatus(result.get())) != "COMMIT";
    if (!IsWell(result.get()) && !failed) failed = Failed(result.get(), sql);
  }
  if (PQstatus(handle_) != CONNECTION_OK) return Lost(sql);
  if (failed) return *failed;
  return {};
}

Result<void> PostgresDb::CommitTransaction() {
  SKYQUILT_TRY(EnsureOpen());
  bool was_undone = false;
  const Result<void> committed = CommitAndFlush(was_undone);
  if (!committed && handle_ != nullptr) return committed.error();
  in_transaction_ = false;
  if (!committed) return AskAfter(transaction_, committed.error());
  if (was_undone) return Error{ErrorCode::kInternal, "The change was undone by an earlier error.", "commit"};
  return {};
}

void PostgresDb::RollbackTransaction() {
  if (std::exchange(in_transaction_, false) && handle_ != nullptr) (void)Simple("ROLLBACK");
}

Result<void> PostgresDb::SyncCommits(bool on) {
  syncs_ = on;
  return {};
}

Result<bool> PostgresDb::WaitForNotice(const std::string& channel, milliseconds time) {
  const auto end = SteadyClock::now() + time;
  SKYQUILT_TRY(EnsureOpen());
  const std::string wanted = schema_ + "." + channel;
  if (listens_to_ != wanted) {
    SKYQUILT_TRY(Simple(fmt::format("LISTEN \"{}\"", wanted)));
    listens_to_ = wanted;
    return true;  // what was said before is not heard
  }
  while (true) {
    bool heard = false;
    if (PQconsumeInput(handle_) == 0) return Lost("listen");
    while (PGnotify* notice = PQnotifies(handle_)) {
      heard = true;
      PQfreemem(notice);
    }
    if (heard) return true;
    const auto left = std::chrono::duration_cast<milliseconds>(end - SteadyClock::now());
    if (left.count() <= 0) return false;
    pollfd descriptor{PQsocket(handle_), POLLIN, 0};
    if (poll(&descriptor, 1, static_cast<int>(left.count())) < 0) return false;
  }
}

}  // namespace skyquilt::storage
