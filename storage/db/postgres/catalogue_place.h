// CataloguePlace: where the catalogue and the queue lie: in the data folder (SQLite, the default), or in a
// PostgreSQL database that several servers and workers share. Said as a URL,
//   postgresql://USER@HOST:PORT/DATABASE?schema=NAME&sslmode=verify-full
// as libpq takes it, and `schema` beside: the tables are made in that schema. A password may stand in it;
// then it is taken out, so that the URL can be shown and handed to other processes. Else it comes from
// PGPASSWORD, PGPASSFILE, ~/.pgpass, or a file. Any thread. Errors: kInvalidArgument (not such a URL),
// kNotFound and kIo (the password's file); none shows a password.
#pragma once

#include <optional>
#include <string>

#include "core/base/result.h"

namespace skyquilt::storage {

struct CataloguePlace {
  std::string url;       // without password and schema; empty: in the data folder
  std::string password;  // empty: as libpq finds it
  std::string schema;    // empty: the first of the user's search path
  // Where photos and maps lie, "s3://bucket/prefix/"; empty: in the data folder. In a store any number of
  // machines, each with a folder of its own, share both.
  std::string files_at;
  // The catalogue whose they are, as that place says; absent: nobody's yet.
  std::optional<std::string> files_of;

  bool IsPostgres() const { return !url.empty(); }
  bool IsOfManyFolders() const { return IsPostgres() && !files_at.empty(); }
};

// `password_file`: its first line is the password; empty: none.
Result<CataloguePlace> CataloguePlaceFrom(const std::string& url, const std::string& password_file = "");

}  // namespace skyquilt::storage
