"""What a loop can render: stability limits, exact and measured."""
