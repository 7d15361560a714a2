"""The workbench: a page in the browser, the server that feeds it, and the session that both look at."""
