#include "storage/db/read_ahead.h"

#include <sqlite3.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <new>
#include <vector>

namespace skyquilt::storage {
namespace {

constexpr int kAheadBytes = 32 * 1024;

// The file of SQLite's own VFS lies behind it.
struct AheadFile {
  sqlite3_file head;  // first: SQLite knows it as this
  sqlite3_int64 id = 0;
  sqlite3_int64 bytes = 0;
  sqlite3_int64 next = -1;  // where the last read ended
  int step = 0;             // how much was read at once of pages that follow each other
};

// What a thread read ahead of one file. Of ids none is ever given twice.
struct AheadBuffer {
  sqlite3_int64 id = 0;
  sqlite3_int64 begin = 0, end = 0;
  std::vector<char> bytes;
};

sqlite3_vfs* OwnVfs() { return sqlite3_vfs_find("unix"); }

AheadFile& Ahead(sqlite3_file* file) { return *reinterpret_cast<AheadFile*>(file); }
sqlite3_file* Own(sqlite3_file* file) { return reinterpret_cast<sqlite3_file*>(&Ahead(file) + 1); }

int ReadAhead(sqlite3_file* file, void* out, int size, sqlite3_int64 offset) {
  thread_local AheadBuffer buffer;
  AheadFile& ahead = Ahead(file);
  const bool follows = offset == ahead.next;
  ahead.next = offset + size;
  if (!follows) ahead.step = size;
  const bool is_here = buffer.id == ahead.id && offset >= buffer.begin && ahead.next <= buffer.end;
  // Twice as much each time: of a small value hardly more is read than it has.
  if (!is_here && follows) ahead.step = std::min(2 * ahead.step, kAheadBytes);
  const sqlite3_int64 end = std::min(offset + ahead.step, ahead.bytes);
  if (!is_here && follows && end > ahead.next) {
    buffer.id = 0;
    buffer.bytes.resize(kAheadBytes);
    const int code =
        Own(file)->pMethods->xRead(Own(file), buffer.bytes.data(), static_cast<int>(end - offset), offset);
    // Where one of the pages behind cannot be read, this one may be.
    if (code != SQLITE_OK) return Own(file)->pMethods->xRead(Own(file), out, size, offset);
    buffer.id = ahead.id;
    buffer.begin = offset;
    buffer.end = end;
  } else if (!is_here) {
    return Own(file)->pMethods->xRead(Own(file), out, size, offset);
  }
  std::memcpy(out, buffer.bytes.data() + (offset - buffer.begin), static_cast<std::size_t>(size));
  return SQLITE_OK;
}

template <auto kMethod, typename... Arguments>
int Pass(sqlite3_file* file, Arguments... arguments) {
  return (Own(file)->pMethods->*kMethod)(Own(file), arguments...);
}

int Open(sqlite3_vfs* /*vfs*/, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  static std::atomic<sqlite3_int64> ids{0};
  using Io = sqlite3_io_methods;
  static const Io methods{.iVersion = 1,
                          .xClose = Pass<&Io::xClose>,
                          .xRead = ReadAhead,
                          .xWrite = Pass<&Io::xWrite, const void*, int, sqlite3_int64>,
                          .xTruncate = Pass<&Io::xTruncate, sqlite3_int64>,
                          .xSync = Pass<&Io::xSync, int>,
                          .xFileSize = Pass<&Io::xFileSize, sqlite3_int64*>,
                          .xLock = Pass<&Io::xLock, int>,
                          .xUnlock = Pass<&Io::xUnlock, int>,
                          .xCheckReservedLock = Pass<&Io::xCheckReservedLock, int*>,
                          .xFileControl = Pass<&Io::xFileControl, int, void*>,
                          .xSectorSize = Pass<&Io::xSectorSize>,
                          .xDeviceCharacteristics = Pass<&Io::xDeviceCharacteristics>,
                          .xShmMap = nullptr,
                          .xShmLock = nullptr,
                          .xShmBarrier = nullptr,
                          .xShmUnmap = nullptr,
                          .xFetch = nullptr,
                          .xUnfetch = nullptr};
  // What SQLite keeps for itself meanwhile, it also writes.
  if ((flags & SQLITE_OPEN_MAIN_DB) == 0) return OwnVfs()->xOpen(OwnVfs(), name, file, flags, out_flags);
  AheadFile* const ahead = new (file) AheadFile();
  ahead->head.pMethods = nullptr;
  int code = OwnVfs()->xOpen(OwnVfs(), name, Own(file), flags, out_flags);
  if (code == SQLITE_OK) code = Own(file)->pMethods->xFileSize(Own(file), &ahead->bytes);
  if (code != SQLITE_OK) {
    if (Own(file)->pMethods != nullptr) Own(file)->pMethods->xClose(Own(file));
    return code;
  }
  ahead->id = ++ids;
  ahead->head.pMethods = &methods;
  return SQLITE_OK;
}

}  // namespace

const char* ReadAheadVfs() {
  static constexpr const char* kName = "skyquilt-read-ahead";
  static const bool is_known = [] {
    if (OwnVfs() == nullptr) return false;
    static sqlite3_vfs vfs = *OwnVfs();
    vfs.zName = kName;
    vfs.pNext = nullptr;
    vfs.szOsFile = static_cast<int>(sizeof(AheadFile)) + OwnVfs()->szOsFile;
    vfs.xOpen = Open;
    return sqlite3_vfs_register(&vfs, 0) == SQLITE_OK;
  }();
  return is_known ? kName : nullptr;
}

}  // namespace skyquilt::storage
