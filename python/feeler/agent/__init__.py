"""The mock-up for agents: a server of the Model Context Protocol on stdin and stdout, `feeler mcp`.

    wire (bounded lines) -> protocol (package mcp) -> tools (table) -> lanes (threads) -> queries, planning, pictures
         <- answers (JSON of less than 4 kB, kinds of figures)

`protocol` and `wire` need the package `mcp`, the extra `feeler[mcp]`; all else does not.
"""

from feeler.agent.served import Opening, Served

__all__ = ["Opening", "Served"]
