-- Has a row once a token was revoked and none was left: requests on this machine then still need a token.
CREATE TABLE closed (at_ms INTEGER NOT NULL) STRICT;
