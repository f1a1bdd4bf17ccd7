// ReadAhead: SQLite's way to a file that never changes, by few system calls. SQLite reads a large value page
// by page, 4 KiB at a time; pages that follow each other are read many at a time here, into a buffer of the
// thread. Any thread; a read that fails is SQLite's error, as ever.
#pragma once

namespace skyquilt::storage {

// The name to open such a file by (zVfs of sqlite3_open_v2); null where SQLite refused it: then its own is
// used.
const char* ReadAheadVfs();

}  // namespace skyquilt::storage
