-- The id of the data folder that this catalogue belongs to: the one in its marker, skyquilt-data.json.
CREATE TABLE data_dir(
  one INTEGER PRIMARY KEY CHECK(one = 1),
  id TEXT NOT NULL
) STRICT;
