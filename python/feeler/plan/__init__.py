"""Planning: removal paths, removal order, tool access and swept volumes."""
