"""The workbench: a page in the browser, the server behind it, and the session that both share."""
