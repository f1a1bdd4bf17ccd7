-- Who may do what. The token itself is nowhere: only its SHA-256.
CREATE TABLE token(
  id TEXT PRIMARY KEY,
  name TEXT NOT NULL UNIQUE,
  hash BLOB NOT NULL UNIQUE,
  scope TEXT NOT NULL CHECK(scope IN ('read','upload','admin')),
  created_us INTEGER NOT NULL,
  expires_us INTEGER                           -- NULL: never
) STRICT;

-- Answers to requests that a client may send again under the same key.
CREATE TABLE idempotent_answer(
  key TEXT NOT NULL,
  route TEXT NOT NULL,                         -- method and path
  fingerprint BLOB NOT NULL,                   -- SHA-256 of the request's body
  status INTEGER NOT NULL,
  location TEXT NOT NULL,
  body TEXT NOT NULL,
  created_us INTEGER NOT NULL,
  PRIMARY KEY(key, route)
) STRICT;
CREATE INDEX idempotent_answer_age ON idempotent_answer(created_us);
