-- Whose upload it is: nobody else goes on with it or ends it.
ALTER TABLE upload ADD COLUMN owner TEXT NOT NULL DEFAULT '';   -- id of the token that began it; '' without one
