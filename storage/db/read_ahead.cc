#include "storage/db/read_ahead.h"

#include <sqlite3.h>

#include <algorithm>
#include <new>
#include <vector>

namespace skyquilt::storage {
namespace {

constexpr sqlite3_int64 kMaxAheadBytes = 256 * 1024;
constexpr sqlite3_int64 kOverflowHead = 4;  // of a value's page: the number of the next one

// The file of SQLite's own VFS lies behind it.
struct AheadFile {
  sqlite3_file head;  // first: SQLite knows it as this
  sqlite3_int64 bytes = 0;
};

// What a thread read ahead of the value that it is reading.
struct AheadBuffer {
  const sqlite3_file* file = nullptr;
  sqlite3_int64 begin = 0, end = 0;
  std::vector<char> bytes;
  sqlite3_int64 value_bytes = 0;  // 0: it reads none
  int shown = 0;                  // pages that SQLite looks at
};
AheadBuffer& OfThread() {
  thread_local AheadBuffer buffer;
  return buffer;
}

sqlite3_vfs* OwnVfs() { return sqlite3_vfs_find("unix"); }

AheadFile& Ahead(sqlite3_file* file) { return *reinterpret_cast<AheadFile*>(file); }
sqlite3_file* Own(sqlite3_file* file) { return reinterpret_cast<sqlite3_file*>(&Ahead(file) + 1); }

// `page` stays null where SQLite is to read by itself: all but values, of which it keeps no page.
int ShowPage(sqlite3_file* file, sqlite3_int64 offset, int size, void** page) {
  *page = nullptr;
  AheadBuffer& buffer = OfThread();
  if (buffer.value_bytes == 0) return SQLITE_OK;
  if (buffer.file != file || offset < buffer.begin || offset + size > buffer.end) {
    const sqlite3_int64 pages = buffer.value_bytes / (size - kOverflowHead) + 1;
    const sqlite3_int64 end =
        std::min(offset + std::clamp<sqlite3_int64>(pages * size, size, kMaxAheadBytes), Ahead(file).bytes);
    if (buffer.shown > 0 || end < offset + size) return SQLITE_OK;
    const auto count = static_cast<std::size_t>(end - offset);
    if (buffer.bytes.size() < count) buffer.bytes.resize(count);
    buffer.file = nullptr;
    // Where one of the pages behind cannot be read, this one may be.
    if (Own(file)->pMethods->xRead(Own(file), buffer.bytes.data(), static_cast<int>(count), offset) !=
        SQLITE_OK)
      return SQLITE_OK;
    buffer.file = file;
    buffer.begin = offset;
    buffer.end = end;
  }
  ++buffer.shown;
  *page = buffer.bytes.data() + (offset - buffer.begin);
  return SQLITE_OK;
}

int TakePageBack(sqlite3_file* /*file*/, sqlite3_int64 /*offset*/, void* page) {
  if (page != nullptr) --OfThread().shown;
  return SQLITE_OK;
}

template <auto kMethod, typename... Arguments>
int Pass(sqlite3_file* file, Arguments... arguments) {
  return (Own(file)->pMethods->*kMethod)(Own(file), arguments...);
}

// SQLite's own VFS maps nothing: pages of a hundred maps would count as memory in use.
int Control(sqlite3_file* file, int operation, void* argument) {
  return operation == SQLITE_FCNTL_MMAP_SIZE
             ? SQLITE_OK
             : Own(file)->pMethods->xFileControl(Own(file), operation, argument);
}

int Open(sqlite3_vfs* /*vfs*/, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  using Io = sqlite3_io_methods;
  static const Io methods{.iVersion = 3,
                          .xClose = Pass<&Io::xClose>,
                          .xRead = Pass<&Io::xRead, void*, int, sqlite3_int64>,
                          .xWrite = Pass<&Io::xWrite, const void*, int, sqlite3_int64>,
                          .xTruncate = Pass<&Io::xTruncate, sqlite3_int64>,
                          .xSync = Pass<&Io::xSync, int>,
                          .xFileSize = Pass<&Io::xFileSize, sqlite3_int64*>,
                          .xLock = Pass<&Io::xLock, int>,
                          .xUnlock = Pass<&Io::xUnlock, int>,
                          .xCheckReservedLock = Pass<&Io::xCheckReservedLock, int*>,
                          .xFileControl = Control,
                          .xSectorSize = Pass<&Io::xSectorSize>,
                          .xDeviceCharacteristics = Pass<&Io::xDeviceCharacteristics>,
                          .xShmMap = nullptr,
                          .xShmLock = nullptr,
                          .xShmBarrier = nullptr,
                          .xShmUnmap = nullptr,
                          .xFetch = ShowPage,
                          .xUnfetch = TakePageBack};
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

ReadingValue::ReadingValue(std::int64_t bytes) { OfThread().value_bytes = bytes; }

// A file may be another's by the next time, at the same place in memory.
ReadingValue::~ReadingValue() {
  OfThread().value_bytes = 0;
  OfThread().file = nullptr;
}

}  // namespace skyquilt::storage
