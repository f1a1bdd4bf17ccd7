-- Having had a token is remembered: when the last one is revoked or ends, the server stays closed.
CREATE TABLE token_policy(
  id INTEGER PRIMARY KEY CHECK(id = 1),
  asks_for_token INTEGER NOT NULL
) STRICT;
INSERT INTO token_policy SELECT 1, EXISTS(SELECT 1 FROM token);
CREATE TRIGGER token_added AFTER INSERT ON token BEGIN
  UPDATE token_policy SET asks_for_token = 1;
END;
-- So does a catalogue that was made anew from flights on the disk: one with an owner had a token.
CREATE TRIGGER owned_flight_added AFTER INSERT ON flight WHEN NEW.owner <> '' BEGIN
  UPDATE token_policy SET asks_for_token = 1;
END;

-- A token may open one flight alone, for reading; it goes with the flight.
ALTER TABLE token ADD COLUMN flight_id TEXT REFERENCES flight(id) ON DELETE CASCADE;
CREATE INDEX token_of_flight ON token(flight_id) WHERE flight_id IS NOT NULL;

-- An answer is given again only to the token that had it. What was kept without one belongs to nobody.
DROP TABLE idempotent_answer;
CREATE TABLE idempotent_answer(
  owner TEXT NOT NULL,                         -- id of the token that sent the request; '' without one
  key TEXT NOT NULL,
  route TEXT NOT NULL,                         -- method and path
  fingerprint BLOB NOT NULL,                   -- SHA-256 of the request's body, or of its form's parts
  status INTEGER NOT NULL,
  location TEXT NOT NULL,
  body TEXT NOT NULL,
  created_us INTEGER NOT NULL,
  PRIMARY KEY(owner, key, route)
) STRICT;
CREATE INDEX idempotent_answer_age ON idempotent_answer(created_us);
