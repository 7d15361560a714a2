"""The session: document, undo, engine, jobs and record together, and the files that are made of them. No sockets."""
