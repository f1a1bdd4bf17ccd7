// ReadAhead: SQLite's way to a file that never changes, by few system calls. SQLite reads a large value page
// by page and copies each twice; here its pages, which mostly follow each other, are read at once into a
// buffer of the thread and shown to SQLite there. Any thread; a read that fails is SQLite's error, as ever.
#pragma once

#include <cstdint>

namespace skyquilt::storage {

// The name to open such a file by (zVfs of sqlite3_open_v2), with PRAGMA mmap_size above 0, without which
// SQLite does not ask to be shown anything; null where SQLite refused it: then its own is used.
const char* ReadAheadVfs();

// While it lives, what this thread reads is one value of so many bytes.
class ReadingValue {
 public:
  explicit ReadingValue(std::int64_t bytes);
  ~ReadingValue();
  ReadingValue(const ReadingValue&) = delete;
  ReadingValue& operator=(const ReadingValue&) = delete;
};

}  // namespace skyquilt::storage
