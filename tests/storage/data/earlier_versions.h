// What makes a catalogue of this version, in either engine, one of an earlier: the steps of storage/db
// undone, the latest first.
#pragma once

#include <string>

namespace skyquilt::storage {

// Without the number of the version, which each engine has elsewhere.
inline std::string UndoToVersion(int version) {
  std::string sql =
      "ALTER TABLE job DROP COLUMN error_reason; ALTER TABLE map_export DROP COLUMN error_reason;";
  if (version <= 22) {
    sql +=
        "ALTER TABLE job DROP COLUMN units_of; ALTER TABLE job DROP COLUMN made_from;"
        "ALTER TABLE job DROP COLUMN troubles; ALTER TABLE unit DROP COLUMN troubles; DROP TABLE product;";
  }
  if (version <= 21) {
    sql +=
        "DROP TABLE worker_aside; ALTER TABLE unit DROP COLUMN since_us;"
        "ALTER TABLE data_dir DROP COLUMN blobs;";
  }
  if (version <= 20) sql += "ALTER TABLE revision DROP COLUMN quality;";
  if (version <= 19) sql += "ALTER TABLE unit DROP COLUMN waiting_us;";
  if (version <= 18) sql += "ALTER TABLE flight DROP COLUMN tags; ALTER TABLE flight DROP COLUMN is_kept;";
  if (version <= 17) sql += "DROP TABLE idle_flight;";
  return sql;
}

}  // namespace skyquilt::storage
