// UploadSpool: uploads that go on after a break of either side. What the catalogue calls the offset is
// durable where the bytes lie (UploadBytes), so that even a power cut loses nothing that was promised. A
// complete upload becomes a file of its flight in one transaction. A part of an upload has no flight and
// stays until it is joined with the others, or expires. One writer at a time: whoever comes later takes over
// (its predecessor's connection is dead as a rule). Any thread. Errors: kNotFound (no such upload or flight,
// or expired), kConflict (another offset; taken over by another request), kCorrupt (bytes that came are
// gone), kTooLarge, kOutOfSpace, kUnprocessable, kIo.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/catalogue/catalogue.h"
#include "storage/uploads/photo_store.h"

namespace skyquilt::storage {

inline constexpr std::chrono::hours kUploadLifetime{24};  // from its last byte on, by the AgeClock

inline constexpr const char* kPartOfUpload = "partial";

struct SpooledUpload {
  std::string id;
  std::string flight_id;  // empty: a part
  std::string name;
  std::string metadata;
  std::optional<std::int64_t> length;
  std::int64_t offset = 0;
  bool is_done = false;
  Time expires;
  std::string owner;               // id of the token that began it; empty without one
  std::string concat;              // kPartOfUpload, or what it was joined from, or empty
  std::string parts;               // where photos lie elsewhere: its bytes (upload_chunks.h)
  std::optional<StoredFile> file;  // what it became, in the answer to whoever completed it

  bool IsPart() const { return concat == kPartOfUpload; }
  bool IsJoined() const { return !concat.empty() && !IsPart(); }
};

// Of UploadSpool alone: where the bytes lie until they are a file of their flight. The catalogue's row is
// changed here where it has to follow them. The caller holds the upload's turn.
class UploadBytes {
 public:
  UploadBytes(CatalogueDb& db, const PhotoStore& store) : db_(db), store_(store) {}
  virtual ~UploadBytes() = default;

  // Before the catalogue knows the upload.
  virtual Result<void> Create(const std::string&) const { return {}; }
  // For the bytes from the upload's offset on.
  virtual Result<std::unique_ptr<IncomingFile>> Open(const SpooledUpload& upload) const = 0;
  // First what was written up to `offset` is durable, then the catalogue says so, then `upload`.
  virtual Result<void> Sync(IncomingFile& file, SpooledUpload& upload, std::int64_t offset,
                            Time now) const = 0;
  // Durable in the flight's folder; answers the stored name. The bytes stay here too until Remove.
  virtual Result<std::string> PutInFlight(const SpooledUpload& upload) const = 0;
  // The catalogue did not take what PutInFlight answered, for `why`.
  virtual void TakeBack(const SpooledUpload& upload, const std::string& stored_name, const Error& why) const {
    store_.TakeBack(upload.flight_id, stored_name, why);
  }
  // Gives the bytes of all parts to `joined`; they lose them only when `enter` has told the catalogue.
  virtual Result<void> Join(const std::vector<SpooledUpload>& parts, SpooledUpload& joined,
                            const std::function<Result<void>()>& enter) const = 0;
  // What cannot be removed goes later, with the expired or with what nobody lists.
  virtual void Remove(const SpooledUpload& upload) const = 0;
  // Rows and bytes; how many.
  virtual Result<int> RemoveExpired(Time now) const = 0;

 protected:
  CatalogueDb& db_;
  const PhotoStore& store_;
};

// Each upload a file below uploads/.
std::unique_ptr<UploadBytes> BytesInFolder(CatalogueDb& db, const PhotoStore& store);
// Where photos lie elsewhere: chunks there (upload_chunks.h), so that any machine goes on with an upload.
std::unique_ptr<UploadBytes> BytesInChunks(CatalogueDb& db, const PhotoStore& store);

Error NoSuchUpload();
// What errno says of a write for an upload.
Error UploadWriteError(const std::string& what);

class UploadSpool {
 public:
  UploadSpool(CatalogueDb& db, Catalogue& catalogue, const PhotoStore& store)
      : db_(db),
        catalogue_(catalogue),
        store_(store),
        bytes_(store.blobs().IsFolder() ? BytesInFolder(db, store) : BytesInChunks(db, store)) {}

  class Append;

  // `now` here and below: by the AgeClock. A part needs neither flight nor name.
  Result<SpooledUpload> Create(const SpooledUpload& wish, Time now);
  // kNotFound for an upload that another token began: to all others it is not there.
  Result<void> CheckOwner(const std::string& id, const std::string& requester, Time now) const;
  // Stops a writer that is under way, so that the offset holds until the next one.
  Result<SpooledUpload> Find(const std::string& id, Time now);
  // Takes bytes from `offset` on, which must be the upload's. With `all_or_nothing` they count only at
  // Commit.
  Result<std::unique_ptr<Append>> Begin(const std::string& id, std::int64_t offset, bool all_or_nothing,
                                        Time now);
  // Only where it was not known; kConflict else, kTooLarge beyond the file limit or below the offset.
  Result<void> DeclareLength(const std::string& id, std::int64_t length, Time now);
  // The file of a flight out of complete parts, in this order; they are gone then. Who asks again for the
  // same (`wish.concat` and owner) is told of what it made. Parts of others only with `takes_any`. kConflict:
  // a part is not complete, or comes twice.
  Result<SpooledUpload> Join(const SpooledUpload& wish, const std::vector<std::string>& parts, bool takes_any,
                             Time now);
  Result<void> Remove(const std::string& id, Time now);

  // Makes files of the uploads that were complete when a server died. At the start.
  Result<std::vector<SpooledUpload>> FinishComplete(Time now);
  // Expired uploads, with what is left of finished ones; where photos lie elsewhere also what nobody lists.
  Result<int> RemoveExpired(Time now) { return bytes_->RemoveExpired(now); }
  // Files of no upload that the catalogue knows. At the start, when none is being made.
  Result<std::vector<std::filesystem::path>> StrayFiles() const;

 private:
  // What the writers of one upload share in this process.
  struct Turn {
    std::mutex mutex;
    Append* writer = nullptr;  // whose turn it is
  };
  // Ends a writer's turn; what it has written is kept. The caller holds the turn's mutex.
  static Result<void> TakeOver(Turn& turn, Time now);
  std::shared_ptr<Turn> TurnOf(const std::string& id);
  Result<SpooledUpload> Read(const std::string& id, Time now) const;
  Result<void> MakeFile(SpooledUpload& upload) const;
  Result<std::optional<SpooledUpload>> JoinedBefore(const SpooledUpload& wish, Time now) const;
  Result<std::vector<SpooledUpload>> CompleteParts(const std::vector<std::string>& parts, Time now) const;
  Result<void> EnterJoined(const SpooledUpload& joined, const std::vector<SpooledUpload>& parts) const;

  CatalogueDb& db_;
  Catalogue& catalogue_;
  const PhotoStore& store_;
  const std::unique_ptr<const UploadBytes> bytes_;
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<Turn>> turns_;
};

// One request's bytes. Destroyed without Commit: what came is kept, unless all-or-nothing. One thread at a
// time.
class UploadSpool::Append {
 public:
  ~Append();
  Append(const Append&) = delete;
  Append& operator=(const Append&) = delete;
  Result<void> Write(std::span<const std::uint8_t> bytes);
  const std::string& flight_id() const { return upload_.flight_id; }
  const std::string& owner() const { return upload_.owner; }
  bool is_joined() const { return upload_.IsJoined(); }
  bool has_length() const { return upload_.length.has_value(); }
  std::int64_t saved_offset() const;  // what the catalogue has
  // Durable; the upload as it is now. The last bytes make it a file of its flight.
  Result<SpooledUpload> Commit(Time now);

 private:
  friend class UploadSpool;
  Append(UploadSpool& spool, std::shared_ptr<Turn> turn, SpooledUpload upload,
         std::unique_ptr<IncomingFile> file, bool all_or_nothing);
  Result<void> Sync(Time now);

  UploadSpool& spool_;
  std::shared_ptr<Turn> turn_;
  SpooledUpload upload_;  // offset: what the catalogue has
  std::int64_t written_;  // offset of the next byte
  std::unique_ptr<IncomingFile> file_;
  bool all_or_nothing_;
};

}  // namespace skyquilt::storage
