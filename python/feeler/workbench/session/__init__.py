"""The session: document, undo, engine, jobs and record together, and the exported files. No sockets."""
