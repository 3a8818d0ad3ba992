"""The protocol between computer and board: messages, framing, codecs, and the firmware's header."""
