-- Render jobs wait in the memory of the server. Pictures whose jobs are lost here are rendered when they are requested.
DROP TABLE job;
