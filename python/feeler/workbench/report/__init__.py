"""One report of a project: requirements, findings, questions and work steps, as HTML, Excel or JSON.

Flow: a project or a document -> `source` -> `content`, rows of plain values -> `media`, pictures and films ->
`as_html`, `as_xlsx`, `as_json`.
"""
